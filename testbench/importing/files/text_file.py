"""Text files: encoding, separator and decimal sign are found, then the layout."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Mapping, Sequence, Set
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from statistics import mode
from typing import TYPE_CHECKING

import numpy as np

from gcode.support.errors import UserError
from gcode.support.strict import blocks_of
from testbench.importing.files.encodings import encoding_of, is_text, known_encoding
from testbench.importing.files.log_lines import NamedCells, named_cells, plain_lines
from testbench.importing.layout import (
    SHOWN,
    Layout,
    count_numbers,
    find_layout,
    is_data,
    row_with,
    shortened,
    width_of,
    words_in,
)
from testbench.importing.sheet import HEAD_ROWS, Hints, Sheet
from testbench.importing.vocabulary.notation import decimal_sign
from testbench.recordings.csv_columns import MOST_COLUMNS, check_quotes, in_words

if TYPE_CHECKING:
    import pandas as pd

SEPARATORS = (",", ";", "\t", "|")
BLANKS = " "  # any number of blanks is one separator
MOST_BROKEN = 60  # lines of a row whose quoted cells have line breaks
# What may stand between names that have blanks themselves, where blanks part the numbers below them.
BETWEEN_NAMES = (re.compile(r"\s*[,;|\t]\s*"), re.compile(r"\t+| {2,}"))
AFTER_A_UNIT = re.compile(r"(?<=[)\]])\s+")
WORDS = re.compile(r'"[^"]*"|\S+')
ROW_NAME = re.compile(r'"1"([,;\t ])[^"]')
QUOTED = re.compile(r'"[^"\n]*"')
# A spreadsheet leaves out the empty cells at the ends of rows in as many rows at once (Microsoft KB 77295).
BLOCK_ROWS = 16

Odd = Mapping[int, tuple[int, str | Sequence[str]]]  # rows, by place: number of cells, and the line or its cells


class _Headed(io.TextIOBase):
    """A text stream with a header above it: pandas takes a column that no row has from a header alone.

    Attributes
    ----------
    lines : int
        Lines that were read below the header.
    odd : dict of int to (int, str)
        Those that have another number of cells than usual, blank ones aside, with that number, by place.
    """

    def __init__(
        self, names: Sequence[int], separator: str, usual: int, stream: io.TextIOWrapper, named: NamedCells | None
    ) -> None:
        self._header, self._named = separator.join(map(str, names)) + "\n", named
        self._separator, self._usual, self._stream = separator, usual, stream
        self.lines, self.odd = 0, dict[int, tuple[int, str]]()

    def read(self, size: int | None = -1) -> str:
        """The header at first, then what is in the stream, in whole lines."""
        if header := self._header:
            self._header = ""
            return header
        text = self._stream.read(size) + self._stream.readline()
        text = self._named.taken_out(text) if self._named else plain_lines(text, self._separator)
        lines = text.removesuffix("\n").split("\n") if text else []
        counts = _counts(lines, self._separator)
        if counts.count(self._usual) < len(lines):
            found = enumerate(zip(counts, lines, strict=True), self.lines)
            self.odd |= {place: one for place, one in found if one[0] != self._usual and one[1].strip()}
        self.lines += len(lines)
        return text


def _counts(lines: Sequence[str], separator: str) -> list[int]:
    """How many cells each line has."""
    plain = [QUOTED.sub('"', line) if '"' in line else line for line in lines]
    return [len(line.split()) if separator == BLANKS else line.count(separator) + 1 for line in plain]


@dataclass(frozen=True)
class TextSheet(Sheet):
    """A text file."""

    encoding: str
    named: NamedCells | None = None

    def blank(self, frame: pd.DataFrame) -> np.ndarray:
        """Which rows of columns that `body` gave are empty.

        pandas reads ``NaN`` as nothing, too; but between other rows that is a sample without a value.
        """
        nothing = super().blank(frame).copy()
        inner = np.flatnonzero(nothing[: np.flatnonzero(~nothing).max(initial=0)])
        if inner.size:
            nothing[self._filled(set(inner.tolist()), [int(one) for one in frame.columns], len(frame))] = False
        return nothing

    def _filled(self, places: Set[int], numbers: Sequence[int], count: int) -> list[int]:
        """Those of the rows that have a text in one of the columns; none where the rows are not the `count` lines."""
        found, place = [], -1
        with self.path.open(encoding=self.encoding) as stream:
            for place, line in enumerate(stream, 1 - self.layout.first_row):
                if place in places and line.strip():
                    cells = _split([self.named.taken_out(line) if self.named else line], self.separator)[0]
                    if {"\0", "\x1a"} & set(line) or any(
                        number <= len(cells) and cells[number - 1].strip() for number in numbers
                    ):
                        found.append(place)
        return found if place + 1 == count else []

    @cached_property
    def _typical(self) -> Sequence[str]:
        """The first row that has as many cells as most."""
        rows = [cells for cells in self.head[self.layout.first_row - 1 :] if width_of(cells)]
        usual = mode(map(len, rows))
        return next(cells for cells in rows if len(cells) == usual)

    def body(self, numbers: Sequence[int]) -> pd.DataFrame:
        """The columns with these numbers, from the first row of numbers on.

        Of a row whose cells may stand in columns that are not theirs, the first is the row as it came, the rest none.
        """
        import pandas as pd

        numbers = sorted(set(numbers))
        names = list(range(numbers[-1]))
        try:
            with self._opened() as stream:
                headed = _Headed(names, self.separator, len(self._typical), stream, self.named)
                frame = pd.read_csv(
                    headed,
                    sep=r"\s+" if self.separator == BLANKS else self.separator,
                    decimal=self.decimal,
                    header=0,
                    names=names,
                    usecols=[number - 1 for number in numbers],
                    skip_blank_lines=False,
                    skipinitialspace=True,
                    index_col=False,
                    low_memory=False,
                )
        except (pd.errors.ParserError, UnicodeError) as error:
            said = in_words(error, self.layout.first_row - 1)
            raise UserError(f"{self.path}: {said}; check the export, or name --separator") from None
        frame = frame.set_axis(numbers, axis=1)
        odd: Odd = headed.odd
        if headed.lines > len(frame):  # some cell goes over several lines
            with self._opened() as stream:
                check_quotes(self.path, stream, self.separator, self.layout.first_row, _has_numbers)
            with self._opened() as stream:
                rows = csv.reader(stream, delimiter=self.separator, skipinitialspace=True)
                found = ((place, (len(cells), cells)) for place, cells in enumerate(rows))
                odd = {place: one for place, one in found if one[0] not in (0, len(self._typical))}
        if odd and (moved := self._moved(odd, frame)):
            gone = frame.index.isin(moved)
            frame = frame.apply(lambda column: column.mask(gone)).astype({numbers[0]: object})
            frame.loc[list(moved), numbers[0]] = list(moved.values())
        return frame

    def _moved(self, odd: Odd, frame: pd.DataFrame) -> dict[int, str]:
        """Rows, by place, whose cells may stand in columns that are not theirs, as they came and in words.

        Where a row has more cells than there are columns, one was parted in two, as ``1,5`` is by commas, unless what
        stands beside the table are words. Where it has fewer than usual, it was cut, or two cells ran together: what
        leaves out empty cells at the end does so in many rows at once, or in all to the last. Where blanks part the
        cells, any may be the one that is missing.
        """
        usual = len(self._typical)
        most = max(usual, len(self.layout.columns))
        last = max(np.flatnonzero(frame.notna().any(axis=1)).max(initial=0), *odd)
        places, counts = np.array(list(odd)), np.array([count for count, _ in odd.values()])
        found = {}
        for run in np.split(places, np.flatnonzero((np.diff(places) != 1) | (np.diff(counts) != 0)) + 1):
            ends = len(run) >= (2 if run[-1] == last else BLOCK_ROWS) and self.separator != BLANKS
            if ends and odd[int(run[0])][0] < usual:
                continue
            for place in run.tolist():
                row, why = odd[place][1], ""
                cells = _split([row], self.separator)[0] if isinstance(row, str) else row
                if len(cells) < usual and count_numbers(cells):
                    why = f"fewer than {usual}"
                elif len(cells) > most and not self._goes_beside(cells):
                    why = f"more than {most}"
                if why:
                    found[place] = f"{shortened(self.separator.join(cells), SHOWN // 2)} ({why} cells)"
        return found

    def _opened(self) -> io.TextIOWrapper:
        """The file at its first row of numbers."""
        stream = self.path.open(encoding=self.encoding)
        for _ in range(self.layout.first_row - 1):  # pandas would count a cell with line breaks as one line
            stream.readline()
        return stream

    def _goes_beside(self, cells: Sequence[str]) -> bool:
        """Whether what a row has beyond the table are words, and before them it is one of the table."""
        width = width_of(self._typical)
        beyond = next((cell for cell in cells[width:] if cell.strip()), "")
        return words_in(cells[:width]) == words_in(self._typical[:width]) and (not beyond or bool(words_in([beyond])))


def open_text(path: Path, wanted: Sequence[str], hints: Hints) -> TextSheet:
    """Read the top of a text file and find how it is written.

    Raises
    ------
    UserError
        If the file is missing, empty or no text, has no numbers, or it cannot be told what its decimal sign is.
    """
    encoding, lines = _head(path, hints.encoding)
    lines = _with_corner(lines)
    found, named = _layouts(lines, [hints.separator] if hints.separator else SEPARATORS, wanted, hints), None
    if not any(len(layout.columns) > 1 for _, _, layout in found):
        if named := named_cells(lines):
            lines = [""] * named.above + named.taken_out("\n".join(lines[named.above :])).split("\n")
            layouts = _layouts(lines, [named.separator], (), replace(hints, header_row=0, units_row=0))
            found = [(separator, rows, named.put_above(layout)) for separator, rows, layout in layouts]
        else:
            found = _layouts(lines, [hints.separator or BLANKS], wanted, hints) or found
    if not found:
        raise UserError(f"{path}: {_no_numbers(lines, wanted, hints)}")
    separator, rows, layout = best = max(found, key=lambda one: _worth(one[1], one[2], wanted))
    if separator == "," and not hints.separator and not named:  # alone of the signs, it may stand within numbers
        ways = [one for one in _layouts(lines, [BLANKS], wanted, hints) if _commas_are_of_numbers(one[1], one[2])]
        separator, rows, layout = max([best, *ways], key=lambda one: _worth(one[1], one[2], wanted)[:2])
    decimal = hints.decimal_said or _decimal(path, rows, layout, separator)
    details = {"separator": separator, "decimal": decimal, "encoding": encoding.removesuffix("-sig")}
    return TextSheet(path, rows, layout, decimal, separator, details, encoding, named)


def _with_corner(lines: list[str]) -> list[str]:
    """Lines with a name, if an empty one, above the names that R's ``write.table`` gives the rows."""
    for at, (above, below) in enumerate(pairwise(lines)):
        if above.startswith('"') and (named := ROW_NAME.match(below)):
            names, cells = _counts([above, below], named[1])
            if names + 1 == cells:
                return [*lines[:at], f'""{named[1]}{above}', *lines[at + 1 :]]
    return lines


def _layouts(
    lines: Sequence[str], separators: Sequence[str], wanted: Sequence[str], hints: Hints
) -> list[tuple[str, list[list[str]], Layout]]:
    """What each separator makes of the file, as far as it makes a table of it."""
    return [
        (separator, rows, layout)
        for separator in separators
        for rows in [_split(lines, separator)]
        if (layout := find_layout(rows, wanted, hints.header_row, hints.units_row))
    ]


def _head(path: Path, encoding: str | None) -> tuple[str, list[str]]:
    raw = next(blocks_of(path, "table"), b"")
    # A block may end within a character: whole lines only.
    whole = raw if len(raw) == path.stat().st_size else raw[: raw.rfind(b"\n") + 1] or raw
    encoding = known_encoding(encoding) if encoding else encoding_of(whole)
    if encoding is None:
        raise UserError(f"{path}: not a text file; export it as CSV, Excel (.xlsx) or TDMS first")
    text = whole.decode(encoding, errors="replace")
    if not text.strip():
        raise UserError(f"{path}: the file is empty")
    if not encoding.startswith("utf-16") and not is_text(whole):
        raise UserError(f"{path}: not a text file in {encoding}; leave --encoding out, or export it again")
    return encoding, text.replace("\r\n", "\n").replace("\r", "\n").split("\n")[:HEAD_ROWS]


def _split(lines: Sequence[str], separator: str) -> list[list[str]]:
    """Rows of cells, one a line; below a cell with line breaks, as many empty ones."""
    lines = [plain_lines(line, separator) for line in lines]
    if separator == BLANKS:
        return [_at_blanks(line) for line in lines]
    rows: list[list[str]] = []
    while len(rows) < len(lines):
        cells, count = _cells(lines[len(rows) : len(rows) + MOST_BROKEN], separator)
        rows += [cells, *([[]] * (count - 1))]
    return rows


def _at_blanks(line: str) -> list[str]:
    """Numbers stand apart by any blanks; names that have blanks themselves (``Force (N)``) by more.

    That is a comma or the like, a wider gap, or the bracket behind the unit of each.
    """
    cells = [cell.strip('"') for cell in WORDS.findall(line)]
    if is_data(cells):
        return cells
    for between in BETWEEN_NAMES:
        if len(names := between.split(line.strip())) > 1 and not is_data(names):
            return names
    names = AFTER_A_UNIT.split(line.strip())
    return names if all(name.endswith((")", "]")) for name in names) else cells


def _cells(lines: Sequence[str], separator: str) -> tuple[list[str], int]:
    """The cells of the first line, and how many lines they take: a quoted cell may have line breaks."""
    ways = [(lines[:1], False)]
    if lines[0].count('"') % 2:  # over several lines, or no more than a quotation mark, as of inches
        ways.insert(0, (lines, True))
    for some, strict in ways:
        reader = csv.reader([f"{line}\n" for line in some], delimiter=separator, skipinitialspace=True, strict=strict)
        with suppress(csv.Error):  # a cell of more than 128 kB is no name of a column
            cells = [cell.replace("\n", " ").rstrip() for cell in next(reader, [])]
            return cells[:MOST_COLUMNS], max(1, reader.line_num)
    return [], 1


def _has_numbers(cells: Sequence[str]) -> bool:
    return is_data(cells) and count_numbers(cells) > 1


def _worth(rows: Sequence[Sequence[str]], layout: Layout, wanted: Sequence[str]) -> tuple[float, ...]:
    """What a separator makes of the file: all wanted names, rows of numbers (the purer, the more), names, columns."""
    header = rows[layout.header_row - 1] if layout.header_row else []
    meanings = sum(bool(column.heading.roles) for column in layout.columns)
    data = [row for row in rows[layout.first_row - 1 :] if len(row) > 1 and is_data(row)]
    cells = [cell for row in data for cell in row if cell.strip()]
    pure = count_numbers(cells) / max(1, len(cells))
    has_wanted = not wanted or row_with([header], wanted) is not None
    return has_wanted, round(len(data) * pure, 1), meanings, len(layout.columns)


def _commas_are_of_numbers(rows: Sequence[Sequence[str]], layout: Layout) -> bool:
    """Whether every comma in the rows of numbers stands within a number, or a clock."""
    cells = [cell for row in rows[layout.first_row - 1 :] if is_data(row) for cell in row if "," in cell]
    return count_numbers([cell for cell in cells if not cell.endswith(",")]) == len(cells)


def _decimal(path: Path, rows: Sequence[Sequence[str]], layout: Layout, separator: str) -> str:
    cells = [cell for row in rows[layout.first_row - 1 :] for cell in row]
    sign = decimal_sign(cells)
    if sign is None:
        commas = [cell for cell in cells if "," in cell]
        if not commas and separator == ",":
            return "."  # a comma that parts the columns is no decimal sign
        seen = next(cell for cell in commas or cells if "," in cell or "." in cell)
        raise UserError(
            f"{path}: cannot tell what the {'comma' if commas else 'point'} means in numbers such as "
            f"{seen.strip()!r}; say --decimal , or --decimal ."
        )
    return sign


def _no_numbers(lines: Sequence[str], wanted: Sequence[str], hints: Hints) -> str:
    named = [row_with(_split(lines, separator), wanted) for separator in SEPARATORS]
    if below := next(filter(None, named), hints.header_row):
        return f"there is nothing below the header in row {below}"
    filled = [line.strip() for line in lines if line.strip()] or [""]
    return (
        f"no rows of numbers in its first {len(lines)} lines, where cells hold nothing but a number each: a row is "
        f"{shortened(filled[len(filled) // 2])!r}; words and brackets in the cells are to be "
        "taken out; a table that begins further below is found where lines above it are taken out; else see "
        "--separator, --encoding and --header-row"
    )
