"""A quotation mark that is closed only lines later: a cell with line breaks, or a slip that hides rows of numbers."""

from __future__ import annotations

import csv
from collections.abc import Iterable

from testbench.importing.layout import count_numbers, is_data


def hidden_rows(lines: Iterable[str], separator: str) -> tuple[int, int] | None:
    """The first cell that holds rows of numbers: places (from 0) of the lines in which it begins and ends; or None.

    Parameters
    ----------
    lines : iterable of str
        Of a table, each with its line feed.
    separator : str
        A blank stands for any number of them.
    """
    reader = csv.reader(lines, delimiter=separator, skipinitialspace=True)
    begin = 0
    try:
        for cells in reader:
            end = reader.line_num
            if end > begin + 1 and any(_has_numbers(line, separator) for line in _lines_within(cells)):
                return begin, end - 1
            begin = end
    except csv.Error:  # a cell of more than 128 kB
        return begin, reader.line_num - 1
    return None


def _lines_within(cells: Iterable[str]) -> list[str]:
    return [line for cell in cells for line in cell.split("\n")[1:]]


def _has_numbers(line: str, separator: str) -> bool:
    cells = line.split(separator)
    return is_data(cells) and count_numbers(cells) > 1
