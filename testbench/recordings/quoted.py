"""A quotation mark that is closed only lines later: a cell with line breaks, or a slip that hides rows of numbers."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from gcode.support.errors import UserError

HasNumbers = Callable[[Sequence[str]], bool]


def check_quotes(path: Path, lines: Iterable[str], separator: str, first_row: int, has_numbers: HasNumbers) -> None:
    """Refuse a cell that holds rows of numbers.

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
