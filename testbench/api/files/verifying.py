"""`verify`: whether every byte of a campaign, or of a whole data set, agrees with its manifest."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gcode.support.errors import UserError
from gcode.support.html import card
from gcode.support.kinds import flag, path_of
from testbench.api.arguments import own_file
from testbench.campaigns.datasets.index import INDEX, index_problems
from testbench.campaigns.datasets.parquet_checksums import CHECKSUMS, PARQUET, parquet_problems
from testbench.campaigns.remake import made_again
from testbench.recordings import manifest
from testbench.recordings.doubts import say_once

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class VerifiedCampaign:
    """One campaign that was looked at.

    Attributes
    ----------
    folder : Path
    problems : tuple of str
        A sentence for each file that does not agree with the manifest.
    remade : bool
        Whether it was also made again, to compare every byte.
    other_software : tuple of str
        Versions that differ from those it was made with, where it was made again.

    Examples
    --------
    >>> from pathlib import Path
    >>> from testbench import VerifiedCampaign
    >>> print(VerifiedCampaign(Path("campaigns/one"), remade=True))
    campaigns/one: intact, made again byte for byte
    """

    folder: Path
    problems: tuple[str, ...] = ()
    remade: bool = False
    other_software: tuple[str, ...] = ()

    @property
    def intact(self) -> bool:
        """Whether nothing is wrong with it."""
        return not self.problems

    def __str__(self) -> str:
        if self.problems:
            return "\n".join(self.problems)
        note = ", made again byte for byte" if self.remade else ""
        note += f" (by other software: {'; '.join(self.other_software)})" if self.other_software else ""
        return f"{self.folder}: intact{note}"


@dataclass(frozen=True)
class VerifyResult:
    """A campaign, or the campaigns of a data set, held against their manifests.

    Attributes
    ----------
    folder : Path
    campaigns : tuple of VerifiedCampaign
    index_problems : tuple of str
        What does not agree with a data set's own list of campaigns, or with the checksums of its Parquet files.
    """

    folder: Path
    campaigns: tuple[VerifiedCampaign, ...]
    index_problems: tuple[str, ...] = ()

    @property
    def problems(self) -> tuple[str, ...]:
        """Everything that is wrong, a sentence each; those of the list of campaigns come first."""
        return (*self.index_problems, *(problem for one in self.campaigns for problem in one.problems))

    @property
    def intact(self) -> bool:
        """Whether nothing is wrong."""
        return not self.problems

    def __repr__(self) -> str:
        found = f"{len(self.problems)} problems" if self.problems else "intact"
        count = len(self.campaigns)
        return f"<VerifyResult {self.folder}: {count} campaign{'s' * (count != 1)}, {found}>"

    def _repr_html_(self) -> str:
        return card(repr(self)[1:-1], self.problems)

    def __str__(self) -> str:
        return "\n".join([*(str(one) for one in self.campaigns if one.intact), *self.problems])

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready form: the folder, how many campaigns were looked at, and every problem."""
        return {"folder": str(self.folder), "campaigns": len(self.campaigns), "problems": list(self.problems)}

    def to_frame(self) -> pd.DataFrame:
        """A row a campaign: campaign, intact, problems."""
        import pandas as pd

        rows = [(str(one.folder), one.intact, "; ".join(one.problems)) for one in self.campaigns]
        return pd.DataFrame(rows, columns=["campaign", "intact", "problems"])


def verify(
    folder: str | Path,
    *,
    again: bool = False,
    effects: str | Path | None = None,
    report: Callable[[VerifiedCampaign], None] = lambda campaign: None,
) -> VerifyResult:
    """Check every file of a campaign, or of every campaign of a data set, against its manifest.

    Parameters
    ----------
    folder : path
        A campaign, or a data set.
    again : bool
        Also make a simulated campaign again and compare every byte.
    effects : path, optional
        With `again`: the file with the user's own effects that the campaign used.
    report : callable
        Called with each campaign as soon as it is checked.

    Returns
    -------
    VerifyResult

    Raises
    ------
    UserError
        If there is no campaign, or with `again` one that cannot be made again.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> import gcode
    >>> import testbench as tb
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = tb.run(tb.preset("pes"), gcode.generate("paper-1", seed=1, duration_s=30), folder)
    ...     before = tb.verify(folder, again=True).intact
    ...     _ = Path(folder, "recording.csv").write_text("time_s,force_N")
    ...     before, tb.verify(folder).intact
    (True, False)
    """
    folder, own, again = path_of(folder, "campaign"), own_file(effects), flag("again", again)
    stored: list[str] = []
    if (folder / CHECKSUMS).is_file():
        stored = parquet_problems(folder)
    elif (folder / PARQUET).exists():
        say_once(
            f"{folder / PARQUET}: not verified, these files carry no checksum; `testbench dataset --format parquet` "
            "writes them anew"
        )
    is_data_set = (folder / INDEX).is_file()
    members, unlisted = index_problems(folder) if is_data_set else ([folder], [])
    campaigns = []
    for member in members:
        found = _verified(member, again, own, alone=not is_data_set)
        campaigns.append(found)
        report(found)
    return VerifyResult(folder, tuple(campaigns), (*unlisted, *stored))


def _verified(folder: Path, again: bool, effects: Path | None, alone: bool) -> VerifiedCampaign:
    """One campaign; in a data set, one that cannot be read at all does not hide the others."""
    try:
        wrong = manifest.problems(folder)
    except UserError as error:
        if alone:
            raise
        wrong = [str(error)]
    if wrong or not again:
        return VerifiedCampaign(folder, tuple(wrong))
    remade = made_again(folder, effects)
    return VerifiedCampaign(folder, tuple(remade.explained(folder)), True, remade.changes)
