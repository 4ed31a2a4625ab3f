"""Which columns may be what, by their names and units."""

from __future__ import annotations

from collections.abc import Mapping

from testbench.importing.choice import ELECTRICAL, NOT_THERE, Choice
from testbench.importing.layout import Column, Layout, column_of
from testbench.importing.vocabulary.laboratory_units import unit_of
from testbench.importing.vocabulary.roles import ROLES, STRETCH, SYMBOL, is_generic, is_letter, role_beside_unit
from testbench.importing.wish import Wish

MISFIT = 10  # how much less plainly a column is what its name says where its unit is of something else


def searched(layout: Layout, wish: Wish, picked: Mapping[str, Column]) -> dict[str, list[Column]]:
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
            return (role if unit.quantity != "ratio" else ""), SYMBOL
    roles = {role: strength for role, strength in roles.items() if strength == max(roles.values())}
    if len(roles) != 1 or (column.heading.base in ("s", "T") and unit is None):
        return "", 0  # s: a displacement or seconds, T: a temperature or a time; the letter alone does not say
    role, strength = next(iter(roles.items()))
    # A unit that does not suit the name (a force in mV) gives way to any column with one that does.
    return role, strength if unit or not column.unit_text else strength - MISFIT


def prefer(picked: dict[str, Column], choice: Choice, wish: Wish) -> None:
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
