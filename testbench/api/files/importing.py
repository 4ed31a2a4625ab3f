"""`import_file`: a file of another tester or logger becomes recordings."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gcode.support.errors import UserError
from gcode.support.files import check_place, existing_file
from gcode.support.html import card
from gcode.support.kinds import flag, path_of
from testbench.campaigns.clearing import check_vacant, replaced
from testbench.importing import from_file
from testbench.importing.choice import FLAGS, UNIT_FLAGS
from testbench.importing.imported import Imported, place_of, write_import
from testbench.importing.sheet import Hints
from testbench.importing.vocabulary.roles import ROLES
from testbench.importing.wish import Wish
from testbench.recordings.files import write_recording_csv
from testbench.recordings.recording import Recording

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

# A message of the import names options of the command line: in Python each is a field of `testbench.Wish`.
# A word of its own: a file may be called day--force.csv. Some are said of a role: `--negate displacement`.
OPTION = re.compile(rf"(?<![\w./\\-])(--[a-z][a-z0-9-]*)(?: ({'|'.join(ROLES)})\b)?")
FIELDS = {
    "--gauge-length-mm": "gauge_length_mm=...",
    "--rate-hz": "rate_hz=...",
    "--rest-ohm": "r0_ohm=...",
    "--repeat": "repeat=...",
    "--drop-bad": "drop_bad=True",
    "--sort": "sort=True",
    "--time-of": "time_of={{{role!r}: ...}}",
    "--zero": "zero={{{role!r}: ...}}",
    "--negate": "negate={{{role!r}}}",
    **{f"--{one.name.replace('_', '-')}": f"hints=Hints({one.name}=...)" for one in fields(Hints)},
    **{flag: f"columns={{{{{role!r}: ...}}}}" for role, flag in FLAGS.items()},
    **{flag: f"units={{{{{flag.removeprefix('--').removesuffix('-unit')!r}: ...}}}}" for flag in UNIT_FLAGS.values()},
}


@dataclass(frozen=True, eq=False, repr=False)
class ImportResult:
    """What a foreign file holds, not written yet.

    Attributes
    ----------
    imported : tuple of Imported
        One recording, or one for each repeat, with what was done to get it.
    """

    imported: tuple[Imported, ...]

    @property
    def recording(self) -> Recording:
        """The recording; of several, the first."""
        return self.imported[0].recording

    @property
    def recordings(self) -> tuple[Recording, ...]:
        """All of them, one for each repeat in the file."""
        return tuple(one.recording for one in self.imported)

    @property
    def taken(self) -> dict[str, str]:
        """By role: what was taken for what, with the conversion shown."""
        return self.imported[0].taken

    @property
    def doubts(self) -> tuple[str, ...]:
        """What looks wrong, with the remedy."""
        return tuple(in_python(doubt) for one in self.imported for doubt in one.doubts)

    def __repr__(self) -> str:
        return f"<ImportResult {', '.join(repr(one) for one in self.recordings)}>"

    def __str__(self) -> str:
        return "\n".join([*self._taken(), *(line for one in self.imported for line in one.words)])

    def places(self, out: str | Path) -> tuple[Path, ...]:
        """Where `write` puts each recording: ``knit-3`` for the repeat 3 of several in ``knit``."""
        several, out = len(self.imported) > 1, path_of(out, "folder or CSV")
        return tuple(place_of(out, one.label if several else "") for one in self.imported)

    def write(self, out: str | Path, overwrite: bool = False) -> tuple[Path, ...]:
        """Write each recording as a campaign folder, or as a plain CSV where `out` ends in ``.csv``.

        Parameters
        ----------
        out : path
        overwrite : bool
            Replace an earlier import in such a folder, or such a file.

        Returns
        -------
        tuple of Path
            As `places`.

        Raises
        ------
        UserError
            If a folder holds something else, or there is a file already; nothing is written then.
        """
        places, overwrite = self.places(out), flag("overwrite", overwrite)
        if Path(out).suffix.lower() == ".csv":
            for place in places:
                check_place(place, overwrite=overwrite)
                if place.exists() and not overwrite:
                    raise UserError(f"{place}: is there; choose another place, or give `overwrite`")
            for one, place in zip(self.imported, places, strict=True):
                write_recording_csv(place, one.recording)
            return places
        for place in places:
            check_vacant(place, overwrite, "imported")
        for one, place in zip(self.imported, places, strict=True):
            with replaced(place, overwrite, "imported") as draft:
                write_import(one, draft)
        return places

    def words(self, out: str | Path) -> str:
        """What was taken for what, and what came of it, a line each that names where it was written."""
        told = zip(self.imported, self.places(out), strict=True)
        return "\n".join([*self._taken(), *(f"{place}: {line}" for one, place in told for line in one.words)])

    def to_dict(self, out: str | Path | None = None) -> dict[str, Any]:
        """JSON-ready form, the same as ``testbench import --json``; with `out`, also where each one is written."""
        found = [one.to_dict() for one in self.imported]
        if out is not None:
            found = [{"out": str(place), **one} for place, one in zip(self.places(out), found, strict=True)]
        return {"recordings": found}

    def to_frame(self) -> pd.DataFrame:
        """The samples of `recording` as a table, see `Recording.to_frame`."""
        return self.recording.to_frame()

    def plot(self, axes: Axes | Sequence[Axes] | None = None) -> Any:
        """Draw every channel of `recording` over time, see `Recording.plot`."""
        return self.recording.plot(axes)

    def _taken(self) -> list[str]:
        return [f"{role}: {words}" for role, words in self.taken.items()]

    def _repr_html_(self) -> str:
        drawn = [recording._repr_html_() for recording in self.recordings]
        return card(f"Import of {self.recording.source}", [*self._taken(), *self.doubts], *drawn)


def import_file(path: str | Path, wish: Wish | None = None, *, gauge_length_mm: float | None = None) -> ImportResult:
    """Read a file of a tester or logger: text (CSV and the like), Excel or TDMS.

    Columns, units, and how the file is written are found by themselves; what cannot be told is asked for in the
    message of the error.

    Parameters
    ----------
    path : path
    wish : testbench.Wish, optional
        What you say about the file: columns, units, repairs.
    gauge_length_mm : float, optional
        Length between the clamps at rest, in mm; needed where the file has a displacement or strain and `wish` does
        not say it.

    Returns
    -------
    ImportResult

    Raises
    ------
    UserError
        If a column or its unit is not clear, or a row cannot be used; the message names file, row and remedy.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> import testbench as tb
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder) / "lab.csv"
    ...     _ = file.write_text("Zeit [s];Weg [cm];Kraft [mN]\\n0,0;0,0;0\\n0,1;0,5;900\\n0,2;1,0;1800\\n")
    ...     found = tb.import_file(file, gauge_length_mm=40)
    >>> found.recording["displacement_mm"].tolist(), found.recording["force_N"].tolist()
    ([0.0, 5.0, 10.0], [0.0, 0.9, 1.8])
    """
    if wish is not None and not isinstance(wish, Wish):
        raise UserError(f"wish: must be a testbench.Wish, got {type(wish).__name__}; tb.Wish(gauge_length_mm=40)")
    given = wish or Wish()
    if gauge_length_mm is not None and given.gauge_length_mm not in (None, gauge_length_mm):
        raise UserError(
            f"gauge_length_mm: is {gauge_length_mm} mm, and the wish says {given.gauge_length_mm} mm; say one of them"
        )
    if gauge_length_mm is not None:
        given = replace(given, gauge_length_mm=gauge_length_mm)
    try:
        return imported(path, given)
    except UserError as error:
        raise UserError(in_python(str(error))) from None


def imported(path: str | Path, wish: Wish) -> ImportResult:
    """As `import_file`, whose messages name the options of the command line."""
    return ImportResult(tuple(from_file.import_file(existing_file(path), wish)))


def in_python(text: str) -> str:
    """A message of the import, and behind it which fields the options are that it names.

    ``say --force-unit (N, kN)`` goes on ``(in Python, of testbench.Wish: --force-unit is units={'force': ...})``.
    """
    options = dict.fromkeys(OPTION.findall(text))
    named = [f"{flag} is {FIELDS[flag].format(role=role or 'force')}" for flag, role in options if flag in FIELDS]
    return f"{text} (in Python, of testbench.Wish: {', '.join(named)})" if named else text
