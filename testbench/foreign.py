"""Reading other people's CSV files: which line is the header, what separates, comma or point for decimals."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gcode.support.errors import UserError
from gcode.support.strict import check_plain
from testbench.recording_files import MOST_BYTES, MOST_COLUMNS, in_words

if TYPE_CHECKING:
    import pandas as pd

HEAD_LINES = 200
SEPARATORS = (",", ";", "\t", "|")
ENCODINGS = ("utf-8-sig", "utf-16", "cp1252")
_DECIMAL_COMMA = re.compile(r"^\s*-?\d+,\d+([eE][+-]?\d+)?\s*$")


@dataclass(frozen=True)
class Layout:
    """How a file is written down.

    Attributes
    ----------
    separator, decimal, encoding : str
    header_row : int
        Row of the column names, counting from 1 as an editor does.
    names : tuple of str
        The columns.
    """

    separator: str
    decimal: str
    encoding: str
    header_row: int
    names: tuple[str, ...]


def layout_of(path: Path, wanted: Sequence[str], separator: str | None = None, decimal: str | None = None) -> Layout:
    """Find the header line that has all the `wanted` names, and with it the separator.

    Raises
    ------
    UserError
        If the file is missing or empty, or no line near its top has all the names.
    """
    encoding, lines = _head(path)
    best: tuple[int, Layout] | None = None
    for candidate in [separator] if separator else SEPARATORS:
        for number, cells in enumerate(_split(lines, candidate)):
            names = tuple(cell.strip() for cell in cells)
            found = sum(name in names for name in wanted)
            layout = Layout(candidate, decimal or ".", encoding, number + 1, names)
            if found == len(wanted):
                return Layout(candidate, decimal or _decimal(lines[number + 1 :], candidate), *_rest(layout))
            if best is None or (found, len(names)) > (best[0], len(best[1].names)):
                best = (found, layout)
    assert best is not None
    names = best[1].names
    missing = next(name for name in wanted if name not in names)
    shown = ", ".join(names[:12]) + (", ..." if len(names) > 12 else "")
    raise UserError(
        f"{path}: no column {missing!r} in its first {len(lines)} lines; row {best[1].header_row} has: {shown}"
    )


def _rest(layout: Layout) -> tuple[str, int, tuple[str, ...]]:
    return layout.encoding, layout.header_row, layout.names


def _head(path: Path) -> tuple[str, list[str]]:
    check_plain(path, "table", MOST_BYTES)
    try:
        with path.open("rb") as stream:
            raw = stream.read(1 << 20)
    except OSError as error:
        raise UserError(f"{path}: cannot read it: {error.strerror or error}") from None
    if not raw.strip():
        raise UserError(f"{path}: the file is empty")
    utf16 = raw[:2] in (b"\xff\xfe", b"\xfe\xff")
    for encoding in ("utf-16",) if utf16 else ("utf-8-sig", "cp1252"):
        try:
            # The cut at 1 MiB may fall within a character: decode whole lines only.
            whole = raw if utf16 else raw[: raw.rfind(b"\n") + 1] or raw
            text = whole.decode(encoding)
        except UnicodeDecodeError:
            continue
        if "\0" not in text:
            return encoding, text.splitlines()[:HEAD_LINES]
    raise UserError(f"{path}: not a text file; export it as CSV first")


def _split(lines: list[str], separator: str) -> list[list[str]]:
    return [_cells(line, separator) for line in lines]


def _cells(line: str, separator: str) -> list[str]:
    try:
        return next(csv.reader([line], delimiter=separator), [])[:MOST_COLUMNS]
    except csv.Error:
        return []  # a cell of more than 128 kB is no name of a column


def _decimal(lines: list[str], separator: str) -> str:
    if separator == ",":
        return "."
    cells = [cell for row in _split(lines[:50], separator) for cell in row]
    return "," if any(_DECIMAL_COMMA.match(cell) for cell in cells) else "."


def read_foreign(
    path: Path, layout: Layout, wanted: Sequence[str], dates: Sequence[str] = ()
) -> tuple[np.ndarray, dict[str, np.ndarray], list[str]]:
    """The wanted columns as numbers.

    Parameters
    ----------
    path, layout, wanted
    dates : sequence of str
        Those of the wanted columns that are dates and times; they become seconds since the first one.

    Returns
    -------
    rows : ndarray of int, shape (n,)
        Row of the file (from 1) that each entry came from; blank rows are left out.
    columns : dict of str to ndarray, each shape (n,)
        NaN where a cell is empty or no number.
    notes : list of str
        The first cell of each column that is no number, in words.
    """
    import pandas as pd

    try:
        frame = pd.read_csv(
            path,
            sep=layout.separator,
            decimal=layout.decimal,
            encoding=layout.encoding,
            header=None,
            names=list(range(len(layout.names))),
            usecols=[layout.names.index(name) for name in wanted],
            skiprows=layout.header_row,
            skip_blank_lines=False,
            skipinitialspace=True,
            index_col=False,
            low_memory=False,
            compression=None,
        )
    except pd.errors.EmptyDataError:
        frame = pd.DataFrame()
    except (pd.errors.ParserError, UnicodeError) as error:
        raise UserError(f"{path}: {in_words(error)}; check the export, or name --separator") from None
    rows = np.arange(len(frame)) + layout.header_row + 1
    blank = frame.isna().all(axis=1).to_numpy()
    frame, rows = frame[~blank], rows[~blank]
    if not len(rows):
        raise UserError(f"{path}: there is nothing below the header in row {layout.header_row}")
    numbers, notes = {}, []
    for name in wanted:
        cells = frame[layout.names.index(name)]
        kind = "a date and time" if name in dates else "a number"
        numbers[name], note = _seconds(cells) if name in dates else _numeric(cells, layout.decimal)
        if note is not None:
            notes.append(f"row {rows[note]}: {name} must be {kind}, got {str(cells.iloc[note])!r}")
    return rows, numbers, notes


def _numeric(cells: pd.Series, decimal: str) -> tuple[np.ndarray, int | None]:
    import pandas as pd

    if cells.dtype.kind not in "fiu":
        text = cells.astype("string").str.strip()
        text = text.str.replace(decimal, ".", regex=False) if decimal != "." else text
        cells, before = pd.to_numeric(text, errors="coerce"), text
        wrong = np.flatnonzero((cells.isna() & before.notna()).to_numpy())
        return cells.to_numpy(dtype=np.float64, na_value=np.nan), int(wrong[0]) if wrong.size else None
    return cells.to_numpy(dtype=np.float64), None


def _seconds(cells: pd.Series) -> tuple[np.ndarray, int | None]:
    import pandas as pd

    when = pd.to_datetime(cells.astype("string").str.strip(), errors="coerce", format="mixed", utc=True)
    wrong = np.flatnonzero((when.isna() & cells.notna()).to_numpy())
    since = (when - when.min()).dt.total_seconds()
    return since.to_numpy(dtype=np.float64, na_value=np.nan), int(wrong[0]) if wrong.size else None
