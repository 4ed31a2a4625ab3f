"""Which column holds what, in which unit: as a person said, else as the file says; what neither says is asked."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from gcode.support.errors import UserError
from testbench.importing.clocks import own_clocks
from testbench.importing.layout import Column, Layout, shortened
from testbench.importing.vocabulary.laboratory_units import Unit, given_unit, units_spelt
from testbench.importing.vocabulary.notation import is_day, is_time_of_day, is_when
from testbench.importing.vocabulary.roles import ROLES, STRETCH, SYMBOL, is_generic, is_letter

ELECTRICAL = ("resistance", "conductance", "relative", "relative_change")
NOT_THERE = "none"
NAMED = "its name"
MISFIT = 10
DATE = "date"
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
        Where the unit was read: ``header``, ``row 2``, or the option that gave it.
    clock : Column or None
        The column of its own times, where that is another one than `time`'s.
    days : Column or None
        The column of the days that times of day are of.
    """

    role: str
    column: Column
    unit: Unit | None
    unit_from: str
    clock: Column | None = None
    days: Column | None = None

    @property
    def columns(self) -> tuple[Column, ...]:
        """All columns that it is read from."""
        return tuple(column for column in (self.column, self.clock, self.days) if column)


@dataclass(frozen=True)
class Trouble:
    """What has to be said by a person before the file can be taken in.

    Attributes
    ----------
    kind : str
        ``unit`` (it cannot be read), ``several`` (columns that fit alike), ``absent`` (nothing fits), ``r0``.
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


@dataclass(frozen=True)
class Said:
    """What a person said: columns by name or by number from 1 (``none``: not there), units, clocks by role."""

    columns: Mapping[str, str] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    clocks: Mapping[str, str] = field(default_factory=dict)
    has_rate: bool = False
    has_r0: bool = False


def choose(layout: Layout, rows: Sequence[Sequence[str]], said: Said) -> Choice:
    """Find the columns.

    Parameters
    ----------
    layout : Layout
    rows : sequence of rows of cells
        The top of the table.
    said : Said

    Raises
    ------
    UserError
        If a column or unit that a person named is not there.
    """
    picked = {role: column_of(layout, text) for role, text in said.columns.items() if text != NOT_THERE}
    choice = Choice()
    found = _searched(layout, said, picked)
    times = found.get("time", [])
    clocks = {role: column_of(layout, text) for role, text in said.clocks.items()}
    for role, columns in found.items():
        if len(columns) == 1:
            picked[role] = columns[0]
        elif role != "time":
            choice.troubles.append(Trouble("several", role, tuple(columns)))
    _prefer(picked, choice, said)
    if len(times) > 1:
        clocks = _several_clocks(times, picked, choice, clocks)
    when = _columns_of(layout, rows, is_when)
    for role in ROLES:
        if role in picked:
            _take(choice, role, picked[role], clocks.get(role), said, when)
    _check_enough(choice, said)
    choice.unused = _unused(choice, layout)
    _join_days(choice, layout, rows)
    return choice


def idle_words(choice: Choice, said: Said) -> str:
    """What a person said of what no column is taken for, in words, since it would be left out; or nothing."""
    alike = {role: {one for one in ROLES if UNIT_FLAGS[one] == UNIT_FLAGS[role]} for role in said.units}
    idle = [UNIT_FLAGS[role] for role, those in alike.items() if not those & set(choice.taken)]
    idle += [f"--time-of {role}=" for role in said.clocks if role not in choice.taken]
    if idle:
        taken = "; ".join(f"{role}: {one.column.label}" for role, one in choice.taken.items())
        return f"{idle[0]} is of what no column is taken for ({taken or 'none is'}); leave it out"
    if said.has_rate and "time" in choice.taken:
        return (
            f"--rate-hz is of a file without times, and {choice.taken['time'].column.label} is taken for them; leave "
            "--rate-hz or --time out"
        )
    if said.has_r0 and not any(role.startswith("relative") for role in choice.taken):
        return "--rest-ohm is R0 of a relative resistance, of which no column is taken; leave it out"
    return ""


def _unused(choice: Choice, layout: Layout) -> tuple[Column, ...]:
    used = {id(column) for one in choice.taken.values() for column in one.columns}
    open_ones = {id(column) for trouble in choice.troubles for column in trouble.columns}
    return tuple(column for column in layout.columns if id(column) not in used | open_ones)


def _join_days(choice: Choice, layout: Layout, rows: Sequence[Sequence[str]]) -> None:
    """Where the time is one of day, its days are in a column of dates beside it, if there is one.

    Raises
    ------
    UserError
        If there are several.
    """
    time = choice.taken.get("time")
    if time is None or time.unit is not None:
        return
    clocks = _columns_of(layout, rows, is_time_of_day)
    dates = _columns_of(layout, rows, is_day)
    days = [column for column in choice.unused if column.number in dates]
    if time.column.number not in clocks or not days:
        return
    if len(days) > 1:
        labels = " and ".join(column.label for column in days)
        raise UserError(
            f"{time.column.label} has times of day, and {labels} have dates: which are its days cannot be told; "
            "leave one of them in the file"
        )
    choice.taken["time"] = replace(time, days=days[0])
    choice.unused = _unused(choice, layout)


def column_of(layout: Layout, text: str) -> Column:
    """The column that a person named, by its header cell, its name without unit, or its number from 1.

    Raises
    ------
    UserError
        If there is no such column, or the name stands twice.
    """
    for same in (
        [column for column in layout.columns if column.heading.text == text.strip()],
        [column for column in layout.columns if column.heading.base == text.strip()],
    ):
        if len(same) == 1:
            return same[0]
        if same:
            where = " and ".join(str(column.number) for column in same)
            raise UserError(f"the columns {where} are both called {text!r}; say which by its number")
    if text.strip().isdigit() and 1 <= int(text) <= len(layout.columns):
        return layout.columns[int(text) - 1]
    raise UserError(f"no column {text!r}; {described(layout)}")


def described(layout: Layout) -> str:
    """The columns of a file in words."""
    names = [shortened(column.heading.text) or f"(column {column.number})" for column in layout.columns]
    shown = ", ".join(names[:12]) + (", ..." if len(names) > 12 else "")
    if layout.header_row is None:
        return f"no header was found above the {len(names)} columns, which are numbered from 1"
    return f"row {layout.header_row} has: {shown}"


def _searched(layout: Layout, said: Said, picked: Mapping[str, Column]) -> dict[str, list[Column]]:
    """For each role that nobody spoke of, the columns that fit it best."""
    taken = {id(column) for column in picked.values()}
    taken |= {id(column_of(layout, text)) for text in said.clocks.values()}
    fitting: dict[str, list[tuple[int, Column]]] = {}
    for column in layout.columns:
        role, strength = _role(column)
        if role and id(column) not in taken and _wanted(role, said):
            fitting.setdefault(role, []).append((strength, column))
    best = {role: max(strength for strength, _ in columns) for role, columns in fitting.items()}
    return {
        role: [column for strength, column in columns if strength == best[role]] for role, columns in fitting.items()
    }


def _wanted(role: str, said: Said) -> bool:
    """Whether to search for a role: nobody spoke of it, nor of another one that takes its place."""
    if role == "time" and said.has_rate:
        return False
    for group in (STRETCH, set(ELECTRICAL)):
        if role in group and any(said.columns.get(other, NOT_THERE) != NOT_THERE for other in group):
            return False
    return role not in said.columns


def _role(column: Column) -> tuple[str, int]:
    """What a column is by its name and unit, and how plainly; an empty role where it cannot be told."""
    unit = column.heading.unit(column.unit_text)
    roles = dict(column.heading.roles)
    if STRETCH & set(roles):
        stretch = {"length": "displacement", "ratio": "strain"}.get(unit.quantity if unit else "")
        roles = {stretch or role: strength for role, strength in roles.items()}
    if unit:
        roles = {role: strength for role, strength in roles.items() if unit.quantity in ROLES[role]}
        if is_generic(column.heading.base):
            role = next((role for role, quantities in ROLES.items() if quantities == (unit.quantity,)), "")
            return (role if unit.quantity != "ratio" else ""), SYMBOL
    if len(roles) != 1 or (column.heading.base in ("s", "T") and unit is None):
        return "", 0  # s: a displacement or seconds, T: a temperature or a time; the letter alone does not say
    role, strength = next(iter(roles.items()))
    # A unit that does not suit the name (a force in mV) gives way to any column with one that does.
    return role, strength if unit or not column.unit_text else strength - MISFIT


def _prefer(picked: dict[str, Column], choice: Choice, said: Said) -> None:
    """One of displacement and strain, one of resistance, conductance and R/R0: the first that says so plainly."""
    unclear = {trouble.role: trouble.columns[0] for trouble in choice.troubles}
    for group in (("displacement", "strain"), ELECTRICAL):
        there = [role for role in group if role in picked or role in unclear]
        plain = [role for role in there if role in said.columns or _is_plain(picked.get(role) or unclear[role])]
        for role in there:
            if role != (plain or there)[0] and role not in said.columns:
                picked.pop(role, None)
                choice.troubles = [trouble for trouble in choice.troubles if trouble.role != role]


def _is_plain(column: Column) -> bool:
    """Whether a column says what it is: by a word, a formula or its letter, not by a letter with a word behind it."""
    _, strength = _role(column)
    return strength > SYMBOL or (strength == SYMBOL and is_letter(column.heading.base))


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


def _columns_of(layout: Layout, rows: Sequence[Sequence[str]], kind: Callable[[str], bool]) -> set[int]:
    """Numbers of the columns most of whose cells are of a kind, such as dates."""
    body = rows[layout.first_row - 1 :]
    found = set()
    for column in layout.columns:
        cells = [row[column.number - 1] for row in body if len(row) >= column.number and row[column.number - 1]]
        if cells and sum(map(kind, cells)) > 0.5 * len(cells):
            found.add(column.number)
    return found


def _take(choice: Choice, role: str, column: Column, clock: Column | None, said: Said, when: set[int]) -> None:
    """Settle the unit of a column."""
    given = said.units.get(role)
    if role == "time" and (given == DATE or (given is None and column.number in when)):
        choice.taken[role] = Taken(role, column, None, "its dates")
        return
    from_file = _unit_in_file(role, column)
    if given is not None:
        unit = given_unit(UNIT_FLAGS[role], given, ROLES[role])
        if column.unit_text and from_file != unit:
            choice.notes.append(
                f"{role}: {column.label} says {column.unit_text}, {UNIT_FLAGS[role]} says {unit.symbol}: "
                f"{unit.symbol} was taken"
            )
        choice.taken[role] = Taken(role, column, unit, UNIT_FLAGS[role], clock)
        return
    if role == "displacement" and from_file is not None and from_file.quantity == "ratio":
        role = "strain"
    if from_file is None:
        choice.troubles.append(Trouble("unit", role, (column,)))
        where = ""
    else:
        where = column.unit_from or NAMED
    choice.taken[role] = Taken(role, column, from_file, where, clock)
    if role.startswith("relative") and not said.has_r0:
        choice.troubles.append(Trouble("r0", role, (column,)))


def _unit_in_file(role: str, column: Column) -> Unit | None:
    """The unit that the file says, if it is one of the role's (for a displacement, % as well)."""
    if role.startswith("relative") and not column.unit_text and _is_plainly_one(role, column):
        return next(unit for unit in units_spelt("1") if unit.quantity == "ratio")
    quantities = ("length", "ratio") if role == "displacement" else ROLES[role]
    fitting = [unit for unit in units_spelt(column.unit_text) if unit.quantity in quantities]
    return fitting[0] if len(fitting) == 1 else None


def _is_plainly_one(role: str, column: Column) -> bool:
    """Whether a ratio without a unit can be nothing but one: a "change of the resistance" may as well be in %."""
    return column.heading.says_ratio or role not in column.heading.roles or role == "relative"


def _check_enough(choice: Choice, said: Said) -> None:
    """A recording needs a time, and a displacement or force and resistance."""
    have = set(choice.taken) | {trouble.role for trouble in choice.troubles}
    if "time" not in have and not said.has_rate:
        choice.troubles.append(Trouble("absent", "time"))
    if not have & STRETCH and not ("force" in have and have & set(ELECTRICAL)):
        choice.troubles.append(Trouble("absent", "displacement"))
