"""Which column holds what: as a person said, else as the file says; what neither says is asked."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from gcode.support.errors import UserError
from testbench.importing.by_name import prefer, searched
from testbench.importing.by_unit import Kinds, take
from testbench.importing.choice import ELECTRICAL, ITS_CELLS, NOT_THERE, Choice, Trouble
from testbench.importing.clocks import own_clocks
from testbench.importing.layout import Column, Layout, column_of, count_numbers, width_of, words_in
from testbench.importing.vocabulary.laboratory_units import unit_of, units_spelt
from testbench.importing.vocabulary.notation import is_day, is_short_clock, is_time_of_day, is_when, unit_in
from testbench.importing.vocabulary.roles import ROLES, STRETCH
from testbench.importing.wish import Wish


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
    found = searched(layout, wish, picked)
    times = found.get("time", [])
    if not times and "time" not in wish.columns and wish.rate_hz is None:
        found |= _dates_in(layout, kinds, picked)
    clocks = {role: column_of(layout, text) for role, text in wish.time_of.items()}
    for role, columns in found.items():
        if len(columns) == 1:
            picked[role] = columns[0]
        elif role != "time":
            choice.troubles.append(Trouble("several", role, tuple(columns)))
    prefer(picked, choice, wish)
    if len(times) > 1:
        clocks = _several_clocks(times, picked, choice, clocks)
    for role in ROLES:
        if role in picked:
            take(choice, role, picked[role], clocks.get(role), wish, kinds)
    for role, one in choice.taken.items():
        where, unit = units.get(one.column.number, (None, ""))
        if where and one.unit and unit_of(unit, (one.unit.quantity,)):
            choice.taken[role] = replace(one, units=where)
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
        cells = [row[place : place + 2] for row in body if count_numbers(row[place : place + 1])]
        behind = [unit_in(cell) for cell, *_ in cells]
        beside = [cell for _, *others in cells for cell in others if words_in([cell]) and _may_be_of(cell, column)]
        for where, texts in zip(layout.columns[place : place + 2], (behind, beside), strict=False):
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


def _dates_in(layout: Layout, kinds: Kinds, picked: Mapping[str, Column]) -> dict[str, list[Column]]:
    """The time where one column alone has dates or times of day that go on: such are a time by any name."""
    going_on = {number for number, differ in kinds[is_when].items() if differ > 1} - set(kinds[is_day])
    dated = [column for column in layout.columns if column.number in going_on and column not in picked.values()]
    return {"time": dated} if len(dated) == 1 else {}


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
