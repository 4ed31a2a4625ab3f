"""The columns of a comma-separated file, as strictly as a recording needs them."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Callable, Container, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gcode.support.errors import UserError
from gcode.support.strict import check_plain, read_bytes
from testbench.recordings.channels import UNITS

if TYPE_CHECKING:
    import pandas as pd

MOST_BYTES = 4 << 30  # 24 h at 1 kHz
MOST_COLUMNS = 1000
MOST_LINE = 64 << 10
LONGEST_NAME = 300  # characters

HasNumbers = Callable[[Sequence[str]], bool]


def read_columns(path: Path, growing: bool = False) -> dict[str, np.ndarray]:
    """All numeric columns of a comma-separated file, by header name.

    Parameters
    ----------
    path : Path
    growing : bool
        A recorder may be writing (or was killed): what follows the last line feed is not a line yet.

    Raises
    ------
    UserError
        If the file is empty, is not comma-separated, or a cell is not a number.
    """
    return columns_of(path, read_frame(path, growing))


def columns_of(path: Path, frame: pd.DataFrame) -> dict[str, np.ndarray]:
    """The numeric columns of what was read from `path`, see `read_columns`."""
    names = [name for name in frame.columns if not is_remark(name, frame[name])]
    return {name: _numbers(path, name, frame[name]) for name in names}


def listed(names: Iterable[str], numeric: Container[str]) -> str:
    """The columns that there are, for a message; those of text are marked, as nothing is read from them."""
    there = (str(name) for name in names if not re.fullmatch(r"Unnamed: \d+", str(name)))
    return ", ".join(name if name in numeric else f"{name} (text)" for name in there) or "none"


def read_frame(path: Path, growing: bool = False) -> pd.DataFrame:
    """All columns of a comma-separated file, bad cells included; see `read_columns`.

    Raises
    ------
    UserError
        If the file is empty or is not comma-separated, or has numbers in a column without a name or within a cell.
    """
    import pandas as pd

    check_plain(path, "recording", MOST_BYTES)
    try:
        _check_head(path)
        source: Path | io.BytesIO = _whole_lines(path) if growing else path
        frame = pd.read_csv(source, skipinitialspace=True, low_memory=False, compression=None)
    except pd.errors.EmptyDataError:
        raise UserError(f"{path}: the file is empty") from None
    except (pd.errors.ParserError, UnicodeError) as error:
        raise UserError(f"{path}: {in_words(error)}; mend it, or try `testbench import`") from None
    except OSError as error:
        raise UserError(f"{path}: cannot read it: {error.strerror or error}") from None
    _check_named(path, frame)
    if _has_line_breaks(frame):
        with path.open(encoding="utf-8-sig") as stream:
            check_quotes(path, stream, ",", 1, _has_numbers)
    return frame.rename(columns=str.strip)


def _check_named(path: Path, frame: pd.DataFrame) -> None:
    """Refuse numbers in a column without a name: a decimal comma before them may have parted one cell in two.

    The first column may have none: pandas writes the numbers of the rows there.
    """
    for number, name in enumerate(frame.columns):
        if number and name == f"Unnamed: {number}" and not is_remark(name, frame[name]):
            raise UserError(
                f"{path}: row 1 ends in a comma or leaves a name out: column {number + 1} has numbers and no name; "
                "name it, or turn the file into a recording with `testbench import`"
            )


def _check_head(path: Path) -> None:
    """Refuse what pandas would read as something else: other separators, repeated names, rows with more cells."""
    with path.open(encoding="utf-8-sig", newline="") as stream:
        header, first = stream.readline(MOST_LINE), stream.readline(MOST_LINE)
    if max(len(header), len(first)) >= MOST_LINE:
        raise UserError(f"{path}: a line of more than {MOST_LINE} characters; a recording's rows are shorter")
    header, first = header.rstrip("\r\n"), first.rstrip("\r\n")
    for separator, what in ((";", "semicolons"), ("\t", "tabs")):
        if separator in header and "," not in header:
            raise UserError(f"{path}: {what} between the columns; turn it into a recording with `testbench import`")
    names = [name.strip() for name in header.split(",")]
    if len(names) > MOST_COLUMNS:
        raise UserError(f"{path}: {len(names)} columns; a recording has at most {MOST_COLUMNS}")
    if (longest := max(map(len, names))) > LONGEST_NAME:
        raise UserError(
            f"{path}: row 1 names a column in {longest} characters; a name has at most {LONGEST_NAME}, shorten it"
        )
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise UserError(f"{path}: row 1 names the column {twice!r} twice; name each column once")
    cells = len(next(csv.reader([first]), []))
    if cells > len(names):
        seen = f"row 2 has {cells} cells, the header {len(names)}"
        raise UserError(f"{path}: {seen}; turn it into a recording with `testbench import`")


def is_remark(name: str, column: pd.Series) -> bool:
    """Whether a column has no number from top to bottom (text, or a comma that ends each row); never one of ours."""
    return str(name).strip() not in UNITS and bool(as_numbers(column).isna().all())


def as_numbers(column: pd.Series) -> pd.Series:
    """A column as numbers; NaN where a cell is none, as True is none. What is too large for one is infinite."""
    import pandas as pd

    if column.dtype.kind in "bO":
        column = column.astype(str).where(column.notna())
    return pd.to_numeric(column, errors="coerce")


def check_quotes(path: Path, lines: Iterable[str], separator: str, first_row: int, has_numbers: HasNumbers) -> None:
    """Refuse a cell that holds rows of numbers: a mark is closed only lines later, by a slip.

    Parameters
    ----------
    path : Path
        Named in the message.
    lines : iterable of str
        Of the table, each with its line feed.
    separator : str
        A blank stands for any number of them.
    first_row : int
        Row of the file (from 1) that the first of the lines is.
    has_numbers : callable
        Whether cells are those of a row of numbers.

    Raises
    ------
    UserError
        With the rows in which it begins and ends.
    """
    if hidden := _hidden_rows(lines, separator, has_numbers):
        begin, end = (place + first_row for place in hidden)
        raise UserError(
            f"{path}: a quotation mark in row {begin} is closed only in row {end}, so the rows between are "
            "one cell and no rows of numbers; take out the marks that quote nothing (inches, noise)"
        )


def _hidden_rows(lines: Iterable[str], separator: str, has_numbers: HasNumbers) -> tuple[int, int] | None:
    """Places (from 0) of the lines in which the first cell that holds rows of numbers begins and ends; or None."""
    reader = csv.reader(lines, delimiter=separator, skipinitialspace=True)
    begin = 0
    try:
        for cells in reader:
            within = [line for cell in cells for line in cell.split("\n")[1:]]
            if any(has_numbers(line.split(separator)) for line in within):
                return begin, reader.line_num - 1
            begin = reader.line_num
    except csv.Error:  # a cell of more than 128 kB
        return begin, reader.line_num - 1
    return None


def _has_line_breaks(frame: pd.DataFrame) -> bool:
    """Whether some name or cell goes over several lines; a column of numbers has no such cell."""
    texts = [frame.columns.to_series(), *(column for _, column in frame.select_dtypes(exclude="number").items())]
    return any(column.astype(str).str.contains("\n", regex=False).any() for column in texts)


def _has_numbers(cells: Sequence[str]) -> bool:
    import pandas as pd

    return bool(as_numbers(pd.Series(cells, dtype=object)).notna().sum() > 1)


def in_words(error: Exception, header_row: int = 1) -> str:
    """What pandas or the decoder objects to, without their jargon; rows count from `header_row`."""
    found = re.search(r"Expected (\d+) fields in line (\d+), saw (\d+)", str(error))
    if found:
        return f"row {found[2]} has {found[3]} cells, the rows above {found[1]}"
    if found := re.search(r"EOF inside string starting at row (\d+)", str(error)):
        return f"a quotation mark in row {header_row + int(found[1])} has no other that closes it"
    if isinstance(error, UnicodeError):
        return "not plain (UTF-8) text"
    return f"not a readable CSV ({str(error).strip()})"


def _whole_lines(path: Path) -> io.BytesIO:
    data = read_bytes(path, "recording", MOST_BYTES)
    return io.BytesIO(data[: data.rfind(b"\n") + 1])


def _numbers(path: Path, name: str, column) -> np.ndarray:
    numbers = as_numbers(column)
    wrong = np.flatnonzero(numbers.isna() & column.notna())
    if wrong.size:
        row, came = int(wrong[0]) + 2, column.iloc[int(wrong[0])]
        raise UserError(
            f"{path}: row {row}: {name} must be a number, got {str(came)!r:.60}; "
            "`testbench import --drop-bad` leaves such rows out"
        )
    return numbers.to_numpy(dtype=np.float64)
