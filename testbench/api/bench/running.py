"""`run`: a program played on the simulated rig and kept as a campaign."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from gcode.programs.api import text_of
from gcode.programs.make import Made
from gcode.support.errors import UserError
from gcode.support.files import existing_file, write_text
from gcode.support.html import card
from gcode.support.kinds import flag, instance, number, path_of, whole
from testbench.api.arguments import AnyModel, Effects, catalogue_of, is_preset, model_file_of, model_name, own_file
from testbench.campaigns.campaign import matches, simulate_campaign, simulate_live
from testbench.campaigns.clearing import vacant
from testbench.campaigns.plan import Plan, effects_kept, programs_before
from testbench.recordings.files import check_beside, read_recording
from testbench.recordings.instruments import Instruments
from testbench.recordings.recording import Recording
from testbench.recordings.stored import MOST_SEEDS
from testbench.rig.acquisition.recorder import Report, Status
from testbench.rig.acquisition.stopping import stop_signals
from testbench.rig.connection.parts import real_time as at_the_machines_pace
from testbench.rig.simulation.played import DEFAULT_REST_S, LONGEST_REST_S, played
from testbench.rig.simulation.simulated import Motion

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

ENDED_WELL = ("complete", "interrupted")


@dataclass(frozen=True)
class CampaignResult:
    """A campaign that was just recorded, of a real sensor or a simulated one, on the disk.

    Attributes
    ----------
    folder : Path
        With the recording, the program and the manifest.
    status : Status or None
        How the recording ended; None where the same campaign was there already, every byte of it.
    """

    folder: Path
    status: Status | None

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self}>"

    @property
    def ended_well(self) -> bool:
        """Whether it is complete, or was ended early because somebody asked for it."""
        return self.status is None or self.status.state in ENDED_WELL

    @property
    def recording(self) -> Recording:
        """What was recorded, read from the folder."""
        return read_recording(self.folder)

    def to_frame(self) -> pd.DataFrame:
        """Its samples as a table, see `Recording.to_frame`."""
        return self.recording.to_frame()

    def plot(self, axes: Axes | Sequence[Axes] | None = None) -> Any:
        """Draw every channel over time, see `Recording.plot`."""
        return self.recording.plot(axes)

    def _repr_html_(self) -> str:
        recorded = self.status is None or self.status.samples
        return card(str(self), [], self.recording._repr_html_() if recorded else "")


@dataclass(frozen=True, repr=False)
class RunResult(CampaignResult):
    """A simulated campaign on the disk, from whose folder it can be made again.

    Attributes
    ----------
    sensor : str
        What its manifest calls the sensor.
    seed : int
    """

    sensor: str
    seed: int

    def __str__(self) -> str:
        if self.status is None:
            return f"{self.folder}: already there and intact; not run again"
        done = f"{self.status.samples} samples in {self.status.time_s:.0f} s of motion"
        told = f"; {self.status.message}" if self.status.message else ""
        return f"{self.folder}: {done}, {self.sensor}, seed {self.seed}{told}"

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready form: folder, sensor, seed, and whether it was made now."""
        made = self.status is not None
        return {"folder": str(self.folder), "sensor": self.sensor, "seed": self.seed, "made": made}


def run(
    model: AnyModel,
    program: Made | str | Path,
    folder: str | Path,
    *,
    seed: int = 1,
    gauge_length_mm: float | None = None,
    instruments: Instruments | None = None,
    after: Iterable[str | Path] = (),
    rest_s: float = DEFAULT_REST_S,
    effects: str | Path | None = None,
    overwrite: bool = False,
    real_time: bool = False,
    report: Report = lambda status: None,
) -> RunResult:
    """Play a program on the simulated rig, whose sensor is `model`, and keep the campaign in a folder.

    The same call again does nothing where the campaign is there and intact. `testbench.simulate` gives the recording
    and keeps no files.

    Parameters
    ----------
    model : KnitModel, result, path or name of a preset
        The sensor: ``"pes"``, or ``"pes@3"`` for the third specimen of its kind, are presets.
    program : Made, path or str
        From `gcode.generate`, or a Mach4 program: its file, or its text.
    folder : path
        Of the campaign; must not exist, or be empty, or hold this campaign (or another one, with `overwrite`).
    seed : int
        Of noise and sampling times.
    gauge_length_mm : float, optional
        In mm; default: the program's.
    instruments : Instruments, optional
        Default: those of the paper's bench.
    after : iterable of path, optional
        Programs, or campaigns of this sensor, that it went through before, in order. It remembers them, and what
        each of the campaigns was after.
    rest_s : float
        Rest after each of these, in s.
    effects : path, optional
        The file with the user's own effects that the model uses; a copy of it is kept in the folder.
    overwrite : bool
        Replace another simulated campaign in `folder`; a measured one never is.
    real_time : bool
        Take as long as the machine would; the files can be read while they grow, and Ctrl-C ends the recording well.
    report : callable
        Called with a `testbench.rig.acquisition.recorder.Status` while it runs and at the end.

    Returns
    -------
    RunResult

    Raises
    ------
    UserError
        If the program cannot be played, the folder holds something else, a campaign in `after` is of another sensor,
        or the model makes values that are not finite.

    Examples
    --------
    >>> import tempfile
    >>> import gcode
    >>> import testbench as tb
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     made = tb.run("pes", gcode.generate("paper-1", seed=1, duration_s=60), folder)
    ...     made.recording.gauge_length_mm
    25.0
    """
    folder = path_of(folder, "folder")
    overwrite, real_time = flag("overwrite", overwrite), flag("real_time", real_time)
    ready = planned(model, program, seed, gauge_length_mm, instruments, after, rest_s, own_file(effects))
    with ready as (plan, motion):
        if matches(folder, plan):
            return RunResult(folder, None, plan.sensor, plan.seed)
        _check_apart(folder, [plan.program, *plan.past, *filter(None, [plan.effects, _file_of(model)])])
        if real_time:
            vacant(folder, overwrite)
            with stop_signals() as stopped:
                status = simulate_live(plan, folder, motion, report, at_the_machines_pace, stopped)
        else:
            status = simulate_campaign(plan, folder, motion, report, overwrite)
    return RunResult(folder, status, plan.sensor, plan.seed)


def _file_of(model: AnyModel) -> Path | None:
    """The file that a model comes from, if it does."""
    return Path(model) if isinstance(model, str | Path) and not is_preset(model) else None


def _check_apart(folder: Path, sources: Iterable[Path]) -> None:
    """Refuse to replace a campaign that the new one is made from."""
    for source in sources:
        if folder.resolve() in (source.resolve(), source.resolve().parent):
            raise UserError(
                f"{folder}: cannot replace a campaign that this one is made from ({source}); choose another"
            )


@contextlib.contextmanager
def program_file(program: Made | str | Path) -> Iterator[Path]:
    """The file of a program, which a campaign's manifest vouches for if it lies in one's folder.

    Of a program that was only generated, or given as its text, a file for the time of the block.
    """
    if not isinstance(program, Made | str | Path):
        raise UserError(
            f"program: must be what gcode.generate made, or the path of one, got {type(program).__name__}"
        )
    is_text = isinstance(program, str) and "\n" in program
    if not isinstance(program, Made) and not is_text:
        check_beside(existing_file(program, "program"))
        yield Path(program)
        return
    with TemporaryDirectory(prefix="knitbench-") as folder:
        path = Path(folder) / "program.tap"
        write_text(path, text_of(program)[0])
        try:
            yield path
        except UserError as error:  # nobody has heard of this file
            raise UserError(str(error).replace(str(path), "program")) from None


def earlier_runs(after: Iterable[str | Path]) -> list[Path]:
    """The programs and campaigns that a sensor went through before.

    Raises
    ------
    UserError
        If they are one path, of which each letter would be one, or anything but paths.
    """
    several = isinstance(after, Iterable) and not isinstance(after, str)
    paths = list(after) if several else []
    if not several or not all(isinstance(one, str | Path) for one in paths):
        raise UserError(f"after: must be a list of paths of programs or campaigns, got {paths or after!r}")
    return [Path(one) for one in paths]


@contextlib.contextmanager
def planned(
    model: AnyModel,
    program: Made | str | Path,
    seed: int,
    gauge_length_mm: float | None,
    instruments: Instruments | None,
    after: Iterable[str | Path],
    rest_s: float,
    effects: Effects,
) -> Iterator[tuple[Plan, Motion]]:
    """Everything that a simulated campaign depends on, and the motion of its program; parameters as in `run`."""
    own = Path(effects) if isinstance(effects, str | Path) else None
    knit, earlier = model_file_of(model, catalogue_of(effects)).model, earlier_runs(after)
    seed, rest_s = whole("seed:", seed, 0), number("rest_s", rest_s, 0)
    if seed >= MOST_SEEDS:
        raise UserError(f"seed: must be at most {MOST_SEEDS - 1}, got {seed}")
    if rest_s > LONGEST_REST_S:
        raise UserError(f"rest_s must be at most {LONGEST_REST_S:g} s, got {rest_s:g}")
    tools = Instruments() if instruments is None else instance("instruments", instruments, Instruments)
    with program_file(program) as path:
        motion, gauge = played(path, gauge_length_mm)
        past, rests_s = programs_before(earlier, knit, gauge, rest_s, own)
        own = effects_kept(knit, own)
        yield Plan(path, knit, gauge, seed, model_name(model), tools, past, rests_s, own), motion
