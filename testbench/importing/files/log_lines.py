"""Lines as programs log them: a stamp before each, and names in the cells (``t=0.1, F=2 N``, lines of JSON)."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

from testbench.importing.layout import Layout, column_named
from testbench.importing.vocabulary.notation import is_value

_CELL = re.compile(r"""^[\s{]*["']?([^\W\d][^:="'{}]*?)["']?\s*[:=]\s*([^:={}]*?)[\s}]*$""")
BETWEEN = {",": r"\s*,\s*", ";": r"\s*;\s*", "\t": r"\s*\t\s*", "|": r"\s*\|\s*", " ": r"\s+"}
# Monitors of serial ports write when a line came, in brackets (Tera Term) or with an arrow behind it (Arduino);
# boards (ESP-IDF) how grave it is, their ms or time in brackets, and which part of the program speaks.
_CLOCK = r"(?:\d{4}-\d{2}-\d{2}[ T])?\d{1,2}:\d{2}:\d{2}(?:[.,]\d+)?"
_STAMPED = rf"(?m)^(?:\[?({_CLOCK})(?:\]| -?>)|[EWIDV] \((\d+|{_CLOCK})\) [^:\n]*:)[ \t]?"
_COLOURS = re.compile(r"\x1b\[[\d;?]*[A-Za-z]")  # of a terminal, which its log keeps
# Of DOS, which some loggers still write below the last row; or what is left of the space that was set aside.
_PADDING = re.compile(r"(?m)^[\0\x1a]+$")


def plain_lines(text: str, separator: str) -> str:
    """Lines of cells in which a stamp is a cell of its own, without colours and what fills up the file."""
    if "\x1b" in text:
        text = _COLOURS.sub("", text)
    if "\0" in text or "\x1a" in text:
        text = _PADDING.sub("", text)
    if ">" in text or "]" in text or ") " in text:
        text = re.sub(rf"{_STAMPED}(?=.*{re.escape(separator)})", rf"\1\2{separator}", text)
    return text


@dataclass(frozen=True)
class NamedCells:
    """The names that stand in the cells of most lines, what parts the cells, and how many lines are above the first.

    A stamp before the cells has no name.
    """

    names: tuple[str, ...]
    separator: str
    above: int

    def taken_out(self, text: str) -> str:
        """Lines without the names; those that have other names, or in another order, as they came."""
        cells = [
            rf"""[ {{]*["']?{re.escape(name)}["']?[ ]*[:=][ ]*(.*?)""" if name else "(.*?)" for name in self.names
        ]
        line = rf"(?m)^{BETWEEN[self.separator].join(cells)}[ }}\r,;]*$"
        plain = self.separator.join(rf"\{at}" for at in range(1, len(cells) + 1))
        return re.sub(line, plain, plain_lines(text, self.separator))

    def put_above(self, layout: Layout) -> Layout:
        """The layout of the lines without names, with the names that stand in its first row of numbers."""
        columns = tuple(column_named(at, name) for at, name in enumerate(self.names, 1))
        return replace(layout, columns=columns, header_row=layout.first_row)


def named_cells(lines: Sequence[str]) -> NamedCells | None:
    """What names stand in the cells of most lines; None where they have none."""
    for separator, between in BETWEEN.items():
        plain = [plain_lines(line, separator).strip(" ,;\t\r") for line in lines]
        found = [_names(re.split(between, line)) for line in plain]
        counts = Counter(filter(None, found))
        names = max(counts, key=counts.__getitem__, default=())
        if len(names) > 1 and len(set(names)) == len(names) and 2 * counts[names] > sum(map(bool, plain)):
            return NamedCells(names, separator, found.index(names))
    return None


def _names(cells: Sequence[str]) -> tuple[str, ...]:
    """The names in all cells of a line, empty for a stamp before them; none where another has none, or no number."""
    found = [_CELL.match(cell) for cell in cells]
    named = tuple(one[1] if one and is_value(one[2]) else "" for one in found)
    return named if all(named[1:]) and (named[0] or is_value(cells[0])) else ()
