"""What every column of a file was taken for, and what a person said of them."""

from __future__ import annotations

from dataclasses import dataclass, field

from testbench.importing.layout import Column
from testbench.importing.vocabulary.laboratory_units import Unit
from testbench.importing.vocabulary.roles import ROLES

ELECTRICAL = ("resistance", "conductance", "relative", "relative_change")
NOT_THERE = "none"
NAMED, ITS_CELLS = "its name", "its cells"
FLAGS = {role: f"--{role.replace('_', '-')}" for role in ROLES} | {"relative": "--relative-resistance"}
UNIT_FLAGS = {role: f"--{role}-unit" for role in ROLES if not role.startswith("relative")}
UNIT_FLAGS |= {"relative": "--relative-unit", "relative_change": "--relative-unit"}


@dataclass(frozen=True)
class Taken:
    """A column, and the quantity that it was taken for.

    Attributes
    ----------
    role : str
        Key of `testbench.importing.vocabulary.roles.ROLES`.
    column : Column
    unit : Unit or None
        None for a time given as dates.
    unit_from : str
        Where the unit was read: ``header``, ``row 2``, the column of the units, or the option that gave it.
    clock : Column or None
        The column of its own times, where that is another one than `time`'s.
    days : Column or None
        The column of the days that times of day are of.
    short : str
        What the first number of times such as ``12:01`` counts, ``h`` or ``min``; empty where they are none such.
    part : Column or None
        The column of the parts of a second, beside a time in whole ones.
    units : Column or None
        The column that says the unit of each row: itself, or one beside it, as multimeters write it.
    """

    role: str
    column: Column
    unit: Unit | None
    unit_from: str
    clock: Column | None = None
    days: Column | None = None
    part: Column | None = None
    units: Column | None = None
    short: str = ""

    @property
    def columns(self) -> tuple[Column, ...]:
        """All columns that it is read from."""
        return tuple(column for column in (self.column, self.clock, self.days, self.part, self.units) if column)

    @property
    def units_behind(self) -> bool:
        """Whether the unit of each row stands behind its number, in the same cell."""
        return self.units is not None and self.units.number == self.column.number

    @property
    def may_change(self) -> bool:
        """Whether its unit is that which the first row says, so that others may say another."""
        return self.units is not None and self.unit_from in (self.units.label, ITS_CELLS)


@dataclass(frozen=True)
class Trouble:
    """What has to be said by a person before the file can be taken in.

    Attributes
    ----------
    kind : str
        ``unit`` (it cannot be read), ``several`` (columns that fit alike), ``absent`` (nothing fits), ``r0``, or
        ``r0_in_ohm`` where the change is in Ω.
    role : str
    columns : tuple of Column
    """

    kind: str
    role: str
    columns: tuple[Column, ...] = ()


@dataclass
class Choice:
    """What every column was taken for; `troubles` must be empty before anything is read."""

    taken: dict[str, Taken] = field(default_factory=dict)
    troubles: list[Trouble] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    unused: tuple[Column, ...] = ()
