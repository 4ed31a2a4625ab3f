"""The tables of an HTML page, which some programs write under the name of .xls."""

from __future__ import annotations

import html
import re
from pathlib import Path

from gcode.support.strict import read_bytes
from testbench.importing.files.cells import Rows, check_size
from testbench.importing.files.encodings import encoding_of, known_encoding

_TAG = re.compile(r"<(/?)([A-Za-z]\w{0,9})(?!\w)([^<>]*)>")
_WIDE = re.compile(r"\bcolspan\s*=\s*[\"']?(\d{1,3})\b", re.I)


def tables_in(path: Path, encoding: str | None) -> dict[str, Rows]:
    """The tables by their numbers, as rows of texts; a cell over several columns has empty ones behind it."""
    raw = read_bytes(path, "table")
    how = known_encoding(encoding) if encoding else encoding_of(raw) or "utf-8"
    tables: dict[str, Rows] = {}
    rows: list[list[str]] = []
    count = 0  # of cells
    at: int | None = None  # of the cell that is open, in the last row
    _, *pieces = _TAG.split(raw.decode(how, errors="replace"))
    for end, tag, more, text in zip(*(pieces[place::4] for place in range(4)), strict=True):
        name = tag.lower()
        if name == "table" and not end:
            tables[str(len(tables) + 1)] = rows = []
        if name in ("table", "tr"):
            at = None
            rows += [[]] * (name == "tr" and not end) and [[]]
        elif name in ("td", "th"):
            at = None if end or not rows else len(rows[-1])
            if at is not None:
                wide = _WIDE.search(more)
                rows[-1] += [""] * max(1, int(wide[1]) if wide else 1)
                count += len(rows[-1]) - at
                check_size(path, count)
        if at is not None:
            rows[-1][at] = f"{rows[-1][at]} {html.unescape(text).strip()}".strip()
    return tables
