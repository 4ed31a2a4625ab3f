"""Rows of numbers above the table that was found: results that testers write there, or another test that is lost."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

from testbench.importing.layout import Layout, Rows, count_numbers, is_data, names_above, width_of, words_in
from testbench.importing.vocabulary.headings import Heading, read_heading

LONG = 20  # rows on a time of their own: more than a phase before the test has


def left_out(rows: Rows, layout: Layout) -> str:
    """Which rows of numbers above the table are a recording, too, in words; empty where none are.

    They are one where they stand as those of the table do, below the same names or between its names and its first
    row, and where many of them stand below a time, or below no names but a title.
    """
    for table in _tables(rows, layout):
        if _is_alike(rows, layout, table) or _is_long(rows, table):
            return (
                f"{_numbers_in(table)} would be left out, since the table was taken to begin in row "
                f"{layout.first_row}: part the file into one file each, or say --header-row N, the row of the names "
                "(0: none)"
            )
    return ""


def passed_over(rows: Rows, layout: Layout) -> list[str]:
    """A sentence on each block of numbers above the table, none of which is read."""
    return [f"not read: {_numbers_in(table)}, above the table" for table in _tables(rows, layout)]


def _tables(rows: Rows, layout: Layout) -> list[list[int]]:
    """Places of the rows of numbers above the first row of the table, a list for each block without other rows."""
    filled = [place for place in range(layout.first_row - 1) if width_of(rows[place])]

    def has_numbers(place: int) -> bool:
        named = place + 1 in (layout.header_row, layout.units_row)
        return not named and count_numbers(rows[place]) > 1 and is_data(rows[place])

    return [list(block) for numbers, block in groupby(filled, has_numbers) if numbers]


def _numbers_in(table: Sequence[int]) -> str:
    first, last = table[0] + 1, table[-1] + 1
    return f"the numbers in row {first}" if first == last else f"the numbers in rows {first} to {last}"


def _is_long(rows: Rows, table: Sequence[int]) -> bool:
    names = [heading for heading in _names_of(rows, table) if heading.text]
    timed = any("time" in heading.roles for heading in names)
    return len(table) >= LONG and (timed or len(names) < 2)


def _is_alike(rows: Rows, layout: Layout, table: Sequence[int]) -> bool:
    first = rows[layout.first_row - 1]
    if 2 * sum(_stands_as(rows[place], first) for place in table) <= len(table):
        return False
    if layout.header_row is None or layout.header_row <= table[0]:
        return table[0] >= (layout.units_row or 0)  # above the units, they number the columns
    named = [read_heading(cell) for cell in rows[layout.header_row - 1]]
    return not any(heading.roles for heading in named) or _mean_the_same(_names_of(rows, table), named)


def _names_of(rows: Rows, table: Sequence[int]) -> list[Heading]:
    """The names above a block of numbers, column by column; empty where there are none."""
    row = names_above(rows, table[0], width_of(rows[table[0]]))
    return [read_heading(cell) for cell in rows[row - 1]] if row else []


def _mean_the_same(names: Sequence[Heading], others: Sequence[Heading]) -> bool:
    """Whether most of the `others` are among the names, or speak of what the one in their place speaks of."""
    known = {heading.base.casefold() for heading in names}
    roles = [set(heading.roles) for heading in names] + [set[str]()] * len(others)
    named = [(place, heading) for place, heading in enumerate(others) if heading.base]
    same = [
        heading.base.casefold() in known or (heading.roles and set(heading.roles) == roles[place])
        for place, heading in named
    ]
    return 2 * sum(map(bool, same)) > len(named)


def _stands_as(cells: Sequence[str], first: Sequence[str]) -> bool:
    """Whether a row is about as wide as the first of the table, and has words only where that has some."""
    return abs(width_of(cells) - width_of(first)) <= 1 and words_in(cells) <= words_in(first)
