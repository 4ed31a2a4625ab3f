"""Names in the cells (``t=0.1, F=2 N``, lines of JSON): taken out of the lines, and put above the table."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

from testbench.importing.layout import Layout, column_named
from testbench.importing.vocabulary.notation import is_value

_CELL = re.compile(r"""^[\s{]*["']?([^\W\d][^:="'{}]*?)["']?\s*[:=]\s*([^:={}]*?)[\s}]*$""")
BETWEEN = {",": r"\s*,\s*", ";": r"\s*;\s*", "\t": r"\s*\t\s*", "|": r"\s*\|\s*", " ": r"\s+"}


@dataclass(frozen=True)
class NamedCells:
    """The names that stand in the cells of most lines, and what parts the cells."""

    names: tuple[str, ...]
    separator: str

    def taken_out(self, text: str) -> str:
        """Lines without the names; those that have other names, or in another order, as they came."""
        cells = [rf"""["']?{re.escape(name)}["']?[ ]*[:=][ ]*(.*?)""" for name in self.names]
        line = rf"(?m)^[ {{]*{BETWEEN[self.separator].join(cells)}[ }}\r]*$"
        return re.sub(line, self.separator.join(rf"\{at}" for at in range(1, len(cells) + 1)), text)

    def put_above(self, layout: Layout) -> Layout:
        """The layout of the lines without names, with the names that stand in its first row of numbers."""
        columns = tuple(column_named(at, name) for at, name in enumerate(self.names, 1))
        return replace(layout, columns=columns, header_row=layout.first_row)


def named_cells(lines: Sequence[str]) -> NamedCells | None:
    """What names stand in the cells of most lines; None where they have none."""
    filled = [line for line in lines if line.strip()]
    for separator, between in BETWEEN.items():
        found = Counter(_names(re.split(between, line.strip())) for line in filled)
        names, count = found.most_common(1)[0]
        if len(names) > 1 and len(set(names)) == len(names) and 2 * count > len(filled):
            return NamedCells(names, separator)
    return None


def _names(cells: Sequence[str]) -> tuple[str, ...]:
    """The names in all cells of a line; none where one has none, or no number behind it."""
    found = [_CELL.match(cell) for cell in cells]
    return tuple(one[1] if one and is_value(one[2]) else "" for one in found) if all(found) else ()
