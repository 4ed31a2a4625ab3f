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
# Monitors of serial ports write when a line came, in brackets (Tera Term), with an arrow behind it (Arduino) or alone
# (CoolTerm); boards (ESP-IDF, Zephyr) their ms or time in brackets, how grave it is, and which part of the program
# speaks. Behind a clock alone stands a cell, and not what belongs to the clock.
_CLOCK = r"(?:\d{1,4}[-/.]\d{1,2}[-/.]\d{1,4}[ T])?\d{1,2}:\d{2}:\d{2}(?:[.,]\d+)?(?:,\d{3})?"
_MARKED = rf"\[?({_CLOCK})(?:\](?: <\w+> [^:\n]*:)?| -?>)|[EWIDV] \((\d+|{_CLOCK})\) [^:\n]*:"
_OF_CLOCK = r"[AaPp]\.?[Mm]\.?|[A-Z]{3,5}|Z|[+-]\d{2}:?\d{2}"
_COLOURS = re.compile(r"\x1b\[[\d;?]*[A-Za-z]")  # of a terminal, which its log keeps
# Of DOS, which some loggers still write below the last row; or what is left of the space that was set aside.
_PADDING = re.compile(r"(?m)^[\0\x1a]+$")


def plain_lines(text: str, separator: str) -> str:
    """Lines of cells in which a stamp is a cell of its own, without colours and what fills up the file."""
    if "\x1b" in text:
        text = _COLOURS.sub("", text)
    if "\0" in text or "\x1a" in text:
        text = _PADDING.sub("", text)
    if ":" in text or ") " in text:
        sign = re.escape(separator)
        cells = rf"""(?=[^\W\d]|["{{]|(?!.*[^\s{sign}] +[^\s{sign}]))"""  # in those of numbers, there are no blanks
        alone = rf"({_CLOCK}) +(?! *(?:(?:{_OF_CLOCK}) *)*{sign}){cells}" if separator != " " else "(?!)()"
        stamped = rf"(?m)^(?:(?:{_MARKED})[ \t]?|{alone})(?=.*{sign})"
        text = re.sub(stamped, lambda found: _plain_clock(found[1] or found[2] or found[3]) + separator, text)
    return text


def _plain_clock(stamp: str) -> str:
    """A clock whose parts of a second stand behind one point: ``00:00:01.400,091`` is Zephyr's."""
    whole, *parts = re.split("[.,]", stamp)
    return ".".join([whole, "".join(parts)] if parts else [whole])


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
