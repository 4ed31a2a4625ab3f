"""What a person has chosen on the import page, as a wish (to look) and as a command line (to import)."""

from __future__ import annotations

import json
from dataclasses import dataclass, field, fields
from pathlib import Path

from gcode.support.errors import UserError
from gcode.support.strict import json_of, validated
from testbench.importing.choice import ELECTRICAL, FLAGS, UNIT_FLAGS
from testbench.importing.sheet import Hints
from testbench.importing.wish import Wish
from testbench.studio.importing.import_words import TITLES

NOT_THERE = "none"
HINTS = ("header_row", "units_row", "separator", "decimal", "thousands", "encoding", "sheet")


@dataclass
class Choices:
    """Everything that was said on the page; what is not in here is found by itself.

    Attributes
    ----------
    path : Path
    columns, units, clocks : dict of str to str
        By role: number of the column (``none``: not there), unit, number of the column of its own times.
    hints : dict of str to (str, int or None)
        How the file is written; the fields of `testbench.importing.sheet.Hints`.
    negate, zero : set of str
        Roles.
    """

    path: Path
    columns: dict[str, str] = field(default_factory=dict)
    units: dict[str, str] = field(default_factory=dict)
    clocks: dict[str, str] = field(default_factory=dict)
    hints: dict[str, str | int | None] = field(default_factory=dict)
    negate: set[str] = field(default_factory=set)
    zero: set[str] = field(default_factory=set)
    rate_hz: float | None = None
    r0_ohm: float | None = None
    gauge_length_mm: float | None = None
    sort: bool = False
    drop_bad: bool = False

    def told(self) -> str:
        """All that was chosen beyond the file, as text for an address; empty where nothing was."""
        said = {name: value for name, value in vars(self).items() if value and name != "path"}
        plain = {name: sorted(value) if isinstance(value, set) else value for name, value in said.items()}
        return json.dumps(plain, separators=(",", ":"), ensure_ascii=False) if plain else ""

    @classmethod
    def from_told(cls, path: Path, text: str) -> Choices:
        """The choices that an address of the page holds.

        Raises
        ------
        UserError
            If it does not say choices.
        """
        data = json_of(text, "choices", "the address") if text else {}
        if not isinstance(data, dict) or set(data) - ({one.name for one in fields(cls)} - {"path"}):
            raise UserError(f"the address asks for something else than choices: {text[:80]!r}")
        choices = validated({"path": path, **data}, cls, "the address", "choice")
        roles = {*choices.columns, *choices.units, *choices.clocks, *choices.negate, *choices.zero}
        unknown = sorted(roles - set(TITLES)) + sorted(set(choices.hints) - set(HINTS))
        if unknown:
            raise UserError(f"the address asks for {unknown[0]!r}, which the import does not know")
        return choices

    def wish(self) -> Wish:
        """What is said on the page, as the import takes it."""
        return Wish(
            gauge_length_mm=self.gauge_length_mm,
            columns=self.columns,
            units=self.units,
            time_of=self.clocks,
            rate_hz=self.rate_hz,
            r0_ohm=self.r0_ohm,
            hints=Hints(**{name: value for name, value in self.hints.items() if value is not None}),  # type: ignore[arg-type]
        )

    def command(self, folder: Path, roles: set[str]) -> list[str]:
        """The command line that imports into `folder`.

        Parameters
        ----------
        folder : Path
        roles : set of str
            What was taken from the file; a unit, clock, sign or zero of anything else is left out.

        Raises
        ------
        UserError
            If the gauge length is missing and the file has a displacement or strain.
        """
        stretched = bool(roles & {"displacement", "strain"})
        if stretched and not self.gauge_length_mm:
            raise UserError("“Gauge length / mm” is empty: say the sensor's length between the clamps at rest")
        argv = ["testbench", "import", str(self.path)]
        for role, column in self.columns.items():
            argv += [FLAGS[role], column]
        units, clocks = ({r: one for r, one in said.items() if r in roles} for said in (self.units, self.clocks))
        for role, unit in units.items():
            argv += [UNIT_FLAGS[role], unit]
        for role, column in clocks.items():
            argv += ["--time-of", f"{FLAGS[role].removeprefix('--')}={column}"]
        for name, value in self.hints.items():
            argv += [f"--{name.replace('_', '-')}", str(value)] if value is not None else []
        r0_ohm = self.r0_ohm if roles & {"relative", "relative_change"} else None
        rate_hz = None if "time" in roles else self.rate_hz
        for flag, number in (("--rate-hz", rate_hz), ("--rest-ohm", r0_ohm)):
            argv += [flag, f"{number:.12g}"] if number else []
        argv += ["--gauge-length-mm", f"{self.gauge_length_mm:.12g}"] if stretched else []
        for flag, marked in (("--negate", self.negate & roles), ("--zero", self.zero & roles)):
            argv += [flag, *sorted(marked)] if marked else []
        argv += ["--sort"] * self.sort + ["--drop-bad"] * self.drop_bad
        return [*argv, "--json", "-o", str(folder)]

    def set_column(self, role: str, column: str) -> None:
        """Take a column for `role`; another electrical quantity, or a strain for a displacement, gives way to it."""
        self.columns[role] = column
        for group in (("displacement", "strain"), ELECTRICAL):
            if column != NOT_THERE and role in group:
                for other in set(group) - {role}:
                    self.columns.pop(other, None)
        self.units.pop(role, None)
