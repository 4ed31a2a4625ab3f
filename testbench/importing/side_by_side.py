"""Specimens side by side in one table: groups of columns with the same names and units, a time in each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from gcode.support.errors import UserError
from testbench.importing.layout import Column, Layout
from testbench.importing.vocabulary.roles import words_of
from testbench.importing.wish import Wish

Named = tuple[tuple[str, ...], str]  # words of a name, without what numbers the groups; unit


def specimens(layout: Layout, wish: Wish) -> list[tuple[str, Layout]]:
    """The columns of each specimen with its number; all of them, without one, where the names do not repeat.

    A person who gives columns by number means those, and no groups.

    Raises
    ------
    UserError
        If `wish` names a repeat, and the specimens have other numbers.
    """
    given = [*wish.columns.values(), *wish.time_of.values()]
    groups = _groups([] if any(text.strip().isdigit() for text in given) else layout.columns)
    if not groups:
        return [("", layout)]
    found = {str(number): replace(layout, columns=tuple(group)) for number, group in enumerate(groups, 1)}
    if wish.repeat is None:
        return list(found.items())
    if str(wish.repeat) not in found:
        raise UserError(f"no repeat {wish.repeat} among the specimens side by side: they are 1 to {len(found)}")
    return [(str(wish.repeat), found[str(wish.repeat)])]


def _groups(columns: Sequence[Column]) -> list[Sequence[Column]]:
    """Groups of columns alike, a time in each; what stands before the first and says nothing is in none."""
    named = [column for column in columns if column.heading.text]
    first = next((place for place, column in enumerate(named) if column.heading.roles), len(named))
    named = named[first:]
    names: list[Named] = [(tuple(words_of(one.heading.text)), one.unit_text) for one in named]
    for size in range(2, len(named) // 2 + 1):
        timed = any("time" in column.heading.roles for column in named[:size])
        if timed and len(named) % size == 0 and names == names[:size] * (len(named) // size):
            return [named[place : place + size] for place in range(0, len(named), size)]
    return []
