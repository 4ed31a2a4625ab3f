"""Which column holds what, and its unit: as a person said, else as the file says; what neither says is asked."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from gcode.support.errors import UserError
from testbench.importing.choice import ELECTRICAL, ITS_CELLS, NAMED, NOT_THERE, UNIT_FLAGS, Choice, Taken, Trouble
from testbench.importing.clocks import are_parts, own_clocks, unit_of_part
from testbench.importing.layout import Column, Layout, column_of, count_numbers, width_of, words_in
from testbench.importing.vocabulary.headings import unit_behind
from testbench.importing.vocabulary.laboratory_units import Unit, given_unit, unit_of, units_spelt
from testbench.importing.vocabulary.notation import (
    WHOLE_CLOCKS,
    is_day,
    is_short_clock,
    is_time_of_day,
    is_when,
    unit_in,
)
from testbench.importing.vocabulary.roles import ROLES, STRETCH, SYMBOL, is_generic, is_letter, role_beside_unit
from testbench.importing.wish import Wish

MISFIT = 10  # how much less plainly a column is what its name says where its unit is of something else
DATE = "date"
# Numbers of the columns most of whose cells are of a kind, with how many of them differ.
Kinds = Mapping[Callable[[str], bool], Mapping[int, int]]


def choose(layout: Layout, rows: Sequence[Sequence[str]], wish: Wish) -> Choice:
    """Find the columns.

    Parameters
    ----------
    layout : Layout
    rows : sequence of rows of cells
        The top of the table.
    wish : Wish

    Raises
    ------
    UserError
        If a column or unit that a person named is not there.
    """
    layout, units = _with_units_beside(layout, rows)
    picked = {role: column_of(layout, text) for role, text in wish.columns.items() if text != NOT_THERE}
    choice = Choice()
    kinds: Kinds = {one: _columns_of(layout, rows, one) for one in (is_when, is_time_of_day, is_short_clock, is_day)}
    found = _searched(layout, wish, picked)
    clock, part = _seconds_and_parts(layout, rows, kinds)
    if "time" not in wish.columns and wish.rate_hz is None:
        found["time"] = [clock] if clock else found.get("time") or _dates_in(layout, kinds, picked)
    times = found.get("time", [])
    clocks = {role: column_of(layout, text) for role, text in wish.time_of.items()}
    picked |= {role: columns[0] for role, columns in found.items() if len(columns) == 1}
    several = [role for role, columns in found.items() if len(columns) > 1 and role != "time"]
    choice.troubles += [Trouble("several", role, tuple(found[role])) for role in several]
    _prefer(picked, choice, wish)
    if len(times) > 1:
        clocks = _several_clocks(times, picked, choice, clocks)
    for role in ROLES:
        if role in picked:
            _take(choice, role, picked[role], clocks.get(role), wish, kinds)
    for role, one in choice.taken.items():
        where, unit = units.get(one.column.number, (None, ""))
        if where and one.unit and unit_of(unit, (one.unit.quantity,)):
            choice.taken[role] = replace(one, units=where)
    if clock and picked.get("time") is clock:
        choice.taken["time"] = replace(choice.taken["time"], part=part)
    _check_enough(choice, wish)
    choice.unused = _unused(choice, layout)
    _join_days(choice, layout, kinds)
    return choice


def _with_units_beside(layout: Layout, rows: Sequence[Sequence[str]]) -> tuple[Layout, dict[int, tuple[Column, str]]]:
    """Columns with the unit that stands behind or beside each of their numbers (``7.8 %``, ``4.7,kOhm``).

    Returns
    -------
    layout : Layout
        Columns without a unit have that of the first row that says one.
    units : dict of int to (Column, str)
        By the number of a column: the one that says its units, itself or the one right of it, and the first of them.
    """
    body = [row for row in rows[layout.first_row - 1 :] if width_of(row)]
    units, columns = {}, list(layout.columns)
    for place, column in enumerate(layout.columns):
        at = column.number - 1
        cells = [row[at : at + 2] for row in body if count_numbers(row[at : at + 1])]
        behind = [unit_in(cell) for cell, *_ in cells]
        beside = [cell for _, *others in cells for cell in others if words_in([cell]) and _may_be_of(cell, column)]
        pair = [one for one in layout.columns[place : place + 2] if one.number <= column.number + 1]
        for where, texts in zip(pair, (behind, beside), strict=False):
            said = list(filter(None, texts))
            if 2 * len(said) > len(body):
                units[column.number] = where, said[0]
                if not column.unit_text:
                    label = ITS_CELLS if where is column else where.label
                    columns[place] = replace(column, unit_text=said[0], unit_from=label)
    return replace(layout, columns=tuple(columns)), units


def _may_be_of(unit_text: str, column: Column) -> bool:
    """Whether a text is a unit that a column may be in, as far as its name says what it is."""
    return bool(column.heading.unit(unit_text) if column.heading.quantities else units_spelt(unit_text))


def _unused(choice: Choice, layout: Layout) -> tuple[Column, ...]:
    used = {id(column) for one in choice.taken.values() for column in one.columns}
    open_ones = {id(column) for trouble in choice.troubles for column in trouble.columns}
    return tuple(column for column in layout.columns if id(column) not in used | open_ones)


def _join_days(choice: Choice, layout: Layout, kinds: Kinds) -> None:
    """Where the time is one of day, its days are in a column of dates beside it, if there is one.

    Raises
    ------
    UserError
        If there are several.
    """
    time = choice.taken.get("time")
    if time is None or time.unit is not None:
        return
    days = [column for column in choice.unused if column.number in kinds[is_day]]
    if not (time.short == "h" or time.column.number in kinds[is_time_of_day]) or not days:
        return
    if len(days) > 1:
        labels = " and ".join(column.label for column in days)
        raise UserError(
            f"{time.column.label} has times of day, and {labels} have dates: which are its days cannot be told; "
            "leave one of them in the file"
        )
    choice.taken["time"] = replace(time, days=days[0])
    choice.unused = _unused(choice, layout)


def _dates_in(layout: Layout, kinds: Kinds, picked: Mapping[str, Column]) -> list[Column]:
    """The one column with dates or times of day that go on, where one alone has some: a time by any name."""
    going_on = {number for number, differ in kinds[is_when].items() if differ > 1} - set(kinds[is_day])
    dated = [column for column in layout.columns if column.number in going_on and column not in picked.values()]
    return dated if len(dated) == 1 else []


def _seconds_and_parts(
    layout: Layout, rows: Sequence[Sequence[str]], kinds: Kinds
) -> tuple[Column | None, Column | None]:
    """Dates or times in whole seconds, and the column of the parts of them, which begin anew with one of those."""
    body = rows[layout.first_row - 1 :]
    for clock in layout.columns:
        if clock.number in kinds[is_when] and clock.number not in kinds[is_day]:
            for part in layout.columns:
                unit, last = unit_of_part(part), max(clock.number, part.number)
                seen = [(row[clock.number - 1], row[part.number - 1]) for row in body if len(row) >= last]
                if part is not clock and unit and are_parts([pair for pair in seen if all(pair)], unit.factor):
                    return clock, part
    return None, None


def _several_clocks(
    times: Sequence[Column], picked: dict[str, Column], choice: Choice, said: Mapping[str, Column]
) -> dict[str, Column]:
    """Each channel's own time, by a person, names or places; the main one is the resistance's, or the force's."""
    found = own_clocks(times, {role: column for role, column in picked.items() if role not in said})
    if found is None:
        choice.troubles.append(Trouble("several", "time", tuple(times)))
        return dict(said)
    clocks = {**found, **said}
    main = next(role for role in (*ELECTRICAL, "force", *picked) if role in clocks)
    picked["time"] = clocks[main]
    return {role: clock for role, clock in clocks.items() if clock is not clocks[main]}


def _columns_of(layout: Layout, rows: Sequence[Sequence[str]], kind: Callable[[str], bool]) -> dict[int, int]:
    """Numbers of the columns most of whose cells are of a kind, such as dates; with how many of them differ."""
    body = rows[layout.first_row - 1 :]
    found = {}
    for column in layout.columns:
        cells = [row[column.number - 1] for row in body if len(row) >= column.number and row[column.number - 1]]
        if cells and sum(map(kind, cells)) > 0.5 * len(cells):
            found[column.number] = len(set(cells))
    return found


def _check_enough(choice: Choice, wish: Wish) -> None:
    """A recording needs a time, and a displacement or force and resistance."""
    have = set(choice.taken) | {trouble.role for trouble in choice.troubles}
    if "time" not in have and wish.rate_hz is None:
        choice.troubles.append(Trouble("absent", "time"))
    if not have & STRETCH and not ("force" in have and have & set(ELECTRICAL)):
        choice.troubles.append(Trouble("absent", "displacement"))


def _searched(layout: Layout, wish: Wish, picked: Mapping[str, Column]) -> dict[str, list[Column]]:
    """For each role that nobody spoke of, the columns that fit it best."""
    taken = {id(column) for column in picked.values()}
    taken |= {id(column_of(layout, text)) for text in wish.time_of.values()}
    fitting: dict[str, list[tuple[int, Column]]] = {}
    for column in layout.columns:
        role, strength = _role(column)
        if role and id(column) not in taken and _wanted(role, wish):
            fitting.setdefault(role, []).append((strength, column))
    best = {role: max(strength for strength, _ in columns) for role, columns in fitting.items()}
    return {
        role: [column for strength, column in columns if strength == best[role]] for role, columns in fitting.items()
    }


def _wanted(role: str, wish: Wish) -> bool:
    """Whether to search for a role: nobody spoke of it, nor of another one that takes its place."""
    if role == "time" and wish.rate_hz is not None:
        return False
    for group in (STRETCH, set(ELECTRICAL)):
        if role in group and any(wish.columns.get(other, NOT_THERE) != NOT_THERE for other in group):
            return False
    return role not in wish.columns


def _role(column: Column) -> tuple[str, int]:
    """What a column is by its name and unit, and how plainly; an empty role where it cannot be told."""
    unit = column.heading.unit(column.unit_text)
    roles = dict(column.heading.roles)
    named = role_beside_unit(column.heading.base, column.heading.whole)
    if named and unit_of(column.unit_text, ROLES[named]):
        return named, SYMBOL
    if unit:
        stretch = {"length": "displacement", "ratio": "strain"}.get(unit.quantity)
        roles = {stretch if stretch and role in STRETCH else role: strength for role, strength in roles.items()}
        roles = {role: strength for role, strength in roles.items() if unit.quantity in ROLES[role]}
        if is_generic(column.heading.base):
            role = next((role for role, quantities in ROLES.items() if quantities == (unit.quantity,)), "")
            is_told = unit.quantity != "ratio" and column.unit_text != "g"  # which accelerations are in, too
            return (role if is_told else ""), SYMBOL
    roles = {role: strength for role, strength in roles.items() if strength == max(roles.values())}
    if len(roles) != 1 or (column.heading.base in ("s", "T") and unit is None):
        return "", 0  # s: a displacement or seconds, T: a temperature or a time; the letter alone does not say
    role, strength = next(iter(roles.items()))
    # A unit that does not suit the name (a force in mV) gives way to any column with one that does.
    return role, strength if unit or not column.unit_text else strength - MISFIT


def _prefer(picked: dict[str, Column], choice: Choice, wish: Wish) -> None:
    """One of displacement and strain, one of resistance, conductance and R/R0: the first that says so plainly."""
    unclear = {trouble.role: trouble.columns[0] for trouble in choice.troubles}
    for group in (("displacement", "strain"), ELECTRICAL):
        there = [role for role in group if role in picked or role in unclear]
        plain = [role for role in there if role in wish.columns or _is_plain(picked.get(role) or unclear[role])]
        for role in there:
            if role != (plain or there)[0] and role not in wish.columns:
                picked.pop(role, None)
                choice.troubles = [trouble for trouble in choice.troubles if trouble.role != role]


def _is_plain(column: Column) -> bool:
    """Whether a column says what it is: by a word, a formula or its letter, not by a letter with a word behind it."""
    _, strength = _role(column)
    return strength > SYMBOL or (strength == SYMBOL and is_letter(column.heading.base))


def _take(choice: Choice, role: str, column: Column, clock: Column | None, wish: Wish, kinds: Kinds) -> None:
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
    # A formula (dR/R0) or R/R0 in words can be nothing but 1; a "change of the resistance" may as well be in %.
    is_one = column.heading.says_ratio or role not in column.heading.roles or role == "relative"
    if role.startswith("relative") and not column.unit_text and is_one:
        return next(unit for unit in units_spelt("1") if unit.quantity == "ratio")
    quantities = ("length", "ratio") if role == "displacement" else ROLES[role]
    if role.startswith("relative") and column.heading.says_ratio:
        quantities = ("ratio",)
    text = column.unit_text or unit_behind(column.heading.whole, quantities)
    fitting = [unit for unit in units_spelt(text) if unit.quantity in quantities]
    return fitting[0] if len(fitting) == 1 else None
