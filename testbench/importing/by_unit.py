"""The unit that a column was taken in: as a person said, else as the file says; what neither says is asked."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

from testbench.importing.choice import NAMED, UNIT_FLAGS, Choice, Taken, Trouble
from testbench.importing.layout import Column
from testbench.importing.vocabulary.headings import unit_behind
from testbench.importing.vocabulary.laboratory_units import Unit, given_unit, unit_of, units_spelt
from testbench.importing.vocabulary.notation import WHOLE_CLOCKS, is_day, is_short_clock, is_when
from testbench.importing.vocabulary.roles import ROLES
from testbench.importing.wish import Wish

DATE = "date"
# Numbers of the columns most of whose cells are of a kind, with how many of them differ.
Kinds = Mapping[Callable[[str], bool], Mapping[int, int]]


def take(choice: Choice, role: str, column: Column, clock: Column | None, wish: Wish, kinds: Kinds) -> None:
    """Settle the unit of a column."""
    given = wish.units.get(role)
    if role == "time" and column.number in kinds[is_short_clock]:
        if short := _short(given, column, kinds[is_day]):
            choice.taken[role] = Taken(role, column, None, "its times", short=short)
            return
        column = replace(column, unit_text=column.unit_text or "h:min or min:s")
    if role == "time" and (given == DATE or (given is None and column.number in kinds[is_when])):
        choice.taken[role] = Taken(role, column, None, "its dates")
        return
    unit, where = _unit_in_file(role, column), column.unit_from or NAMED
    if given is not None:
        from_file, unit, where = unit, given_unit(UNIT_FLAGS[role], given, ROLES[role]), UNIT_FLAGS[role]
        if column.unit_text and from_file != unit:
            choice.notes.append(
                f"{role}: {column.label} says {column.unit_text}, {where} says {unit.symbol}: {unit.symbol} was taken"
            )
    elif role == "displacement" and unit is not None and unit.quantity == "ratio":
        role = "strain"
    if unit is None:
        choice.troubles.append(Trouble("unit", role, (column,)))
    choice.taken[role] = Taken(role, column, unit, where if unit else "", clock)
    if role.startswith("relative") and wish.r0_ohm is None:
        in_ohm = unit is not None and unit.quantity == "resistance"
        choice.troubles.append(Trouble("r0_in_ohm" if in_ohm else "r0", role, (column,)))


def _short(given: str | None, column: Column, days: Mapping[int, int]) -> str:
    """What the first number of ``12:01`` counts: as is said, or hours beside days that go on; empty where neither."""
    unit = unit_of(given, ("time",)) if given else column.heading.unit(column.unit_text)
    if given == DATE or (unit is None and not given and max(days.values(), default=0) > 1):
        return "h"
    return unit.symbol if unit and unit.symbol in WHOLE_CLOCKS else ""


def _unit_in_file(role: str, column: Column) -> Unit | None:
    """The unit that the file says, if it is one of the role's (for a displacement, % as well)."""
    if role.startswith("relative") and not column.unit_text and _is_plainly_one(role, column):
        return next(unit for unit in units_spelt("1") if unit.quantity == "ratio")
    quantities = ("length", "ratio") if role == "displacement" else ROLES[role]
    if role.startswith("relative") and column.heading.says_ratio:
        quantities = ("ratio",)
    text = column.unit_text or unit_behind(column.heading.whole, quantities)
    fitting = [unit for unit in units_spelt(text) if unit.quantity in quantities]
    return fitting[0] if len(fitting) == 1 else None


def _is_plainly_one(role: str, column: Column) -> bool:
    """Whether a ratio without a unit can be nothing but one: a "change of the resistance" may as well be in %."""
    return column.heading.says_ratio or role not in column.heading.roles or role == "relative"
