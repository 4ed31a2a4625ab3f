"""`dataset`: thousands of simulated campaigns from one file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from gcode.support.console import MOST_PROCESSES, Progress
from gcode.support.errors import UserError
from gcode.support.html import card, frame_table
from gcode.support.kinds import path_of, whole
from testbench.api.arguments import own_file
from testbench.campaigns.datasets.dataset import (
    cluster,
    drop_stale_parquet,
    one_at_a_time,
    run,
    write_index,
    write_parquet,
)
from testbench.campaigns.datasets.index import is_campaign, listed
from testbench.campaigns.datasets.spec import read_spec
from testbench.campaigns.datasets.tasks import tasks_of
from testbench.recordings.doubts import say_once

if TYPE_CHECKING:
    import pandas as pd

FORMATS = ("csv", "parquet")
SHOWN = 8  # campaigns that a notebook lists
Counted = Callable[[int, int], None]


@dataclass(frozen=True)
class DatasetResult:
    """A data set on the disk.

    Attributes
    ----------
    folder : Path
    made, there : int
        How many campaigns were made now, and how many were there already, every byte of them.
    parquet_files : int or None
        How many Parquet files were written now; None where none were asked for.
    """

    folder: Path
    made: int
    there: int
    parquet_files: int | None = None

    def __len__(self) -> int:
        return self.made + self.there

    def __repr__(self) -> str:
        return f"<DatasetResult {self}>"

    def __str__(self) -> str:
        return f"{self.folder}: {len(self)} campaigns: {self.made} made, {self.there} there already"

    def to_frame(self) -> pd.DataFrame:
        """A row a campaign: campaign, sensor, program, seed, specimen, split, samples, manifest_sha256."""
        import pandas as pd

        return pd.DataFrame(listed(self.folder))

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready form: the folder and the counts."""
        counts = {"made": self.made, "there": self.there, "parquet_files": self.parquet_files}
        return {"folder": str(self.folder), **counts}

    def _repr_html_(self) -> str:
        return card(str(self), [], frame_table(self.to_frame().head(SHOWN)))


def dataset(
    spec: str | Path,
    folder: str | Path,
    *,
    format: Literal["csv", "parquet"] = "csv",
    workers: int = -1,
    scheduler: str | None = None,
    effects: str | Path | None = None,
    progress: Counted | bool | None = None,
) -> DatasetResult:
    """Make every campaign that a TOML file describes; the same call again makes what is missing.

    Parameters
    ----------
    spec : path
        Sensors, programs and seeds; its entries are documented in docs/datasets.md.
    folder : path
        Of the data set; made if it is not there.
    format : {"csv", "parquet"}
        Campaign folders with a CSV each; with ``"parquet"`` there are also Parquet files, split by specimen, with
        Croissant metadata (docs/datasets.md).
    workers : int
        Processes, 1 to 1024; -1 is one for each core.
    scheduler : str, optional
        Address of a Dask cluster that shall do the work, for instance ``tcp://10.0.0.5:8786``.
    effects : path, optional
        The file with the user's own effects that the spec names.
    progress : callable or bool, optional
        Called with how many campaigns are done and how many there are; None or True shows a line where somebody
        watches, False nothing.

    Returns
    -------
    DatasetResult

    Raises
    ------
    UserError
        If the spec is wrong, the folder is a campaign, another call is at work in it, or the cluster does not answer.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> import gcode
    >>> import testbench as tb
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = gcode.generate("paper-1", seed=1, duration_s=30).write(folder)
    ...     spec = Path(folder) / "knits.toml"
    ...     _ = spec.write_text('sensors = ["pes"]\\nprograms = ["*.tap"]\\nseeds = "1-2"')
    ...     knits = tb.dataset(spec, Path(folder) / "knits", workers=1, progress=False)
    ...     list(knits.to_frame().seed)
    [1, 2]
    """
    if format not in FORMATS:
        raise UserError(f"format: must be one of {', '.join(FORMATS)}, got {format!r}")
    if workers != -1 and not 1 <= whole("workers", workers, -1) <= MOST_PROCESSES:
        raise UserError(f"workers: must be 1 to {MOST_PROCESSES}, or -1 for one a core, got {workers}")
    if scheduler is not None and not (isinstance(scheduler, str) and scheduler):
        raise UserError(f"scheduler: must be an address such as tcp://10.0.0.5:8786, got {scheduler!r}")
    spec, out, own = path_of(spec, "TOML file"), path_of(folder, "folder"), own_file(effects)
    wanted = read_spec(spec)
    if is_campaign(out):
        raise UserError(f"{out}: is a campaign itself; choose another folder for the data set")
    with one_at_a_time(out):
        tasks = tasks_of(wanted, spec.parent, out, own)
        with cluster(scheduler):
            made, there = run(tasks, "dask" if scheduler else "loky", workers, _counting(progress, len(tasks)))
        write_index(out, spec, tasks)
        files = write_parquet(out, tasks, workers) if format == "parquet" else None
        if files is None and (dropped := drop_stale_parquet(out, tasks)):
            say_once(
                f"{out}: removed {dropped} Parquet files of campaigns that are others now; the format parquet writes "
                "those of the present ones"
            )
    return DatasetResult(out, made, there, files)


def _counting(progress: Counted | bool | None, total: int) -> Callable[[], None]:
    """What is called after each campaign."""
    if progress is False:
        return lambda: None
    if not callable(progress):
        return Progress("campaigns", total).step
    done = count(1)
    return lambda: progress(next(done), total)
