"""The columns that a person named, and what was said of none."""

from __future__ import annotations

from gcode.support.errors import UserError
from testbench.importing.choice import UNIT_FLAGS, Choice, Said
from testbench.importing.layout import Column, Layout, shortened
from testbench.importing.vocabulary.roles import ROLES


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
