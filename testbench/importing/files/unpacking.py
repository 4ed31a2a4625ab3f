"""Refuses a workbook that would fill the memory: it is a zip of XML, and some kB of it may hold any amount.

The XML of a sheet is read row by row, everything else at once. So a sheet may be long, but no row of it, and the rest
together may not. Sizes are counted while unpacking, not believed; nothing is kept.
"""

from __future__ import annotations

import struct
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from xml.parsers import expat

from gcode.support.errors import UserError

# A sheet of 24 h at 10 Hz and six columns has 5 million cells and 200 MB of XML; Excel itself ends at 1,048,576 rows
# of 16,384 cells.
MOST_SHEET_BYTES, MOST_OTHER_BYTES = 256 << 20, 32 << 20
MOST_ROWS, MOST_IN_A_ROW, MOST_CELLS = 1 << 20, 4 << 14, 10_000_000
MOST_ELEMENTS = 1_000_000  # outside rows: texts, styles, merged cells
BROKEN = (
    OSError,
    EOFError,
    RuntimeError,  # an encrypted part; a way of packing that Python does not know
    ValueError,
    struct.error,
    zipfile.BadZipFile,
    zlib.error,
    expat.ExpatError,
)
_BLOCK = 1 << 20


def check_unpacked(path: Path) -> None:
    """Refuse a workbook that unpacks to more than a recording can need.

    Raises
    ------
    UserError
        With the part and what is allowed, or if it is no workbook.
    """
    try:
        with zipfile.ZipFile(path) as book:
            budget = _Budget(path)
            for part in book.infolist():
                if part.filename.endswith((".xml", ".rels")):
                    budget.take(book, part)
    except UserError:
        raise
    except BROKEN as error:
        raise UserError(f"{path}: not an Excel workbook that can be read ({error}); save it again as .xlsx") from None


class _Budget:
    """What is left of each allowance."""

    def __init__(self, path: Path) -> None:
        self.path, self.bytes_left, self.elements_left = path, MOST_OTHER_BYTES, MOST_ELEMENTS

    def take(self, book: zipfile.ZipFile, part: zipfile.ZipInfo) -> None:
        """Unpack a part and count it off."""
        sheet = part.filename.startswith("xl/worksheets/") and part.filename.endswith(".xml")
        left = MOST_SHEET_BYTES if sheet else self.bytes_left
        counter = _Counter(self.elements_left)
        for block in _blocks(book, part):
            left -= len(block)
            counter.feed(block)
            reason = f"more than {MOST_SHEET_BYTES >> 20} MB" if left < 0 and sheet else counter.problem
            reason = reason or (f"more than {MOST_OTHER_BYTES >> 20} MB, sheets not counted" if left < 0 else "")
            if reason:
                raise UserError(f"{self.path}: {part.filename} unpacks to {reason}; export the table as CSV")
        counter.feed(b"", last=True)
        self.elements_left = counter.elements_left
        if not sheet:
            self.bytes_left = left


def _blocks(book: zipfile.ZipFile, part: zipfile.ZipInfo) -> Iterator[bytes]:
    with book.open(part) as stream:
        while block := stream.read(_BLOCK):
            yield block


class _Counter:
    """Counts rows, what is in each, and what is outside rows."""

    def __init__(self, elements_left: int) -> None:
        self.elements_left, self.rows, self.in_row, self.depth, self.row_depth = elements_left, 0, 0, 0, 0
        self.problem = ""
        self._parser = expat.ParserCreate()
        self._parser.StartElementHandler, self._parser.EndElementHandler = self._start, self._end

    def feed(self, block: bytes, last: bool = False) -> None:
        """Take the next bytes; what is wrong with them stands in `problem`."""
        self._parser.Parse(block, last)

    def _start(self, name: str, attributes: Mapping[str, str]) -> None:
        self.depth += 1
        if self.row_depth:
            self.in_row += 1
            if self.in_row > MOST_IN_A_ROW:
                self.problem = f"a row of more than {MOST_IN_A_ROW} elements"
        elif name.rpartition(":")[2] == "row":
            self.row_depth, self.rows, self.in_row = self.depth, self.rows + 1, 0
            # A row may say its own number; all rows before it are then there, empty.
            if self.rows > MOST_ROWS or len(attributes.get("r", "")) > len(str(MOST_ROWS)):
                self.problem = f"more than {MOST_ROWS} rows"
        else:
            self.elements_left -= 1
            if self.elements_left < 0:
                self.problem = f"more than {MOST_ELEMENTS} elements outside rows"

    def _end(self, _name: str) -> None:
        if self.depth == self.row_depth:
            self.row_depth = 0
        self.depth -= 1
