"""Refuses a workbook that would fill the memory: it is a zip of XML, and some kB of it may hold any amount.

The XML of a sheet is read row by row, everything else at once. So a sheet may be long, but no row of it, and the rest
together may not. Sizes are counted while unpacking, not believed; nothing is kept.
"""

from __future__ import annotations

import struct
import zipfile
import zlib
from collections.abc import Mapping
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
    bytes_left, elements_left = MOST_OTHER_BYTES, MOST_ELEMENTS
    try:
        with zipfile.ZipFile(path) as book:
            for part in book.namelist():
                if not part.endswith((".xml", ".rels")):
                    continue
                sheet = part.startswith("xl/worksheets/") and part.endswith(".xml")
                most = f"{MOST_SHEET_BYTES >> 20} MB" if sheet else f"{MOST_OTHER_BYTES >> 20} MB, sheets not counted"
                counter = _Counter(MOST_SHEET_BYTES if sheet else bytes_left, elements_left)
                counter.take(book, part)
                if problem := counter.problem or f"more than {most}" * (counter.bytes_left < 0):
                    raise UserError(f"{path}: {part} unpacks to {problem}; export the table as CSV")
                elements_left = counter.elements_left
                bytes_left = bytes_left if sheet else counter.bytes_left
    except UserError:
        raise
    except BROKEN as error:
        raise UserError(f"{path}: not an Excel workbook that can be read ({error}); save it again as .xlsx") from None


class _Counter:
    """Counts rows, what is in each, and what is outside rows."""

    def __init__(self, bytes_left: int, elements_left: int) -> None:
        self.bytes_left, self.elements_left, self.problem = bytes_left, elements_left, ""
        self.rows, self.in_row, self.depth, self.row_depth = 0, 0, 0, 0
        self._parser = expat.ParserCreate()
        self._parser.StartElementHandler, self._parser.EndElementHandler = self._start, self._end

    def take(self, book: zipfile.ZipFile, part: str) -> None:
        """Unpack a part, until something is wrong with it: that stands in `problem`, or no bytes are left."""
        with book.open(part) as stream:
            while not self.problem and self.bytes_left >= 0:
                block = stream.read(_BLOCK)
                self.bytes_left -= len(block)
                self._parser.Parse(block, not block)
                if not block:
                    return

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
