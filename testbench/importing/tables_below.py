"""Names below the first rows of numbers: the same, where a test or page begins, or those of another table."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from gcode.support.errors import UserError
from testbench.importing.choice import Choice
from testbench.importing.layout import Column, shortened
from testbench.importing.sheet import Sheet
from testbench.importing.vocabulary.headings import read_heading
from testbench.importing.vocabulary.laboratory_units import plain_text
from testbench.importing.vocabulary.notation import is_value

if TYPE_CHECKING:
    import pandas as pd

_LETTER = r"[^\W\d_eE]"  # of a word; e is one of numbers, too


def names_again(sheet: Sheet, choice: Choice, frame: pd.DataFrame, rows: np.ndarray) -> np.ndarray:
    """Which rows are the names or units of the columns once more, or remarks beside those, shape (n,).

    Parameters
    ----------
    sheet : Sheet
    choice : Choice
    frame : DataFrame
        The columns that were taken, by their numbers, without blank rows.
    rows : ndarray of int, shape (n,)
        Of the file.

    Raises
    ------
    UserError
        If a row has other names or units: what is below it is of another table, whatever else is left out.
    """
    columns = [one.column for one in choice.taken.values()]
    words = {column.number: _words_in(frame[column.number]) for column in columns}
    taken = frame[list(words)]
    _check_one_table(sheet, columns, taken, words, rows)
    ours = np.all([_which(words[column.number], partial(_is_ours, column)) for column in columns], axis=0)
    if not ours.any() or "time" not in choice.taken:
        return np.zeros(len(frame), dtype=bool)
    time = choice.taken["time"].column.number
    worded = {number: text.notna().to_numpy(dtype=bool) for number, text in words.items()}
    timed = taken[time].notna().to_numpy() & ~worded[time]
    # A remark has words in the place of a time, or a time with nothing beside it.
    remark = np.where(timed, taken.notna().sum(axis=1) == 1, np.any([*worded.values()], axis=0))
    run = np.cumsum(np.diff(remark, prepend=False))
    return remark & np.isin(run, run[ours])


def begins_of(between: np.ndarray) -> list[int]:
    """Places, among the rows that are left, of those that follow on the ones between."""
    return np.flatnonzero(np.diff(np.cumsum(between)[~between], prepend=0)).tolist()


def _words_in(cells: pd.Series) -> pd.Series:
    """The cells that hold words, and no numbers or times; nothing in the place of the others."""
    import pandas as pd

    if cells.dtype.kind in "fiumM":
        return pd.Series(pd.NA, cells.index, dtype="string")
    text = cells.astype("string").str.strip()
    lettered = text.where(text.str.contains(_LETTER, na=False))
    return lettered.mask(lettered.isin([word for word in lettered.dropna().unique() if is_value(word)]))


def _which(words: pd.Series, kind: Callable[[str], bool]) -> np.ndarray:
    return words.isin([word for word in words.dropna().unique() if kind(word)]).to_numpy(dtype=bool)


def _check_one_table(
    sheet: Sheet, columns: Sequence[Column], taken: pd.DataFrame, words: Mapping[int, pd.Series], rows: np.ndarray
) -> None:
    speaking, worded = np.zeros(len(rows), dtype=int), np.zeros(len(rows), dtype=int)
    for column in columns:
        worded += words[column.number].notna().to_numpy(dtype=bool)
        speaking += _which(words[column.number], partial(_is_another_name, column))
    filled = taken.notna().sum(axis=1).to_numpy()
    if sheet.separator != " ":  # which parts the words of a remark, too
        full = np.flatnonzero((worded == len(columns)) & (speaking == 0))
        full = full[~taken.iloc[full].duplicated().to_numpy()]
        speaking[full[[_are_names(taken.iloc[row], columns) for row in full]]] = 1
    again = np.flatnonzero((speaking > 1) | ((speaking > 0) & (worded > 1) & (worded == filled)))
    if again.size:
        names = ", ".join(map(str, taken.iloc[again[0]].dropna()))
        raise UserError(
            f"{sheet.path}: row {rows[again[0]]} has other names or units ({shortened(names)}), so another table "
            "begins there: end the file before it, or part it into one file each"
        )


def _are_names(cells: pd.Series, columns: Sequence[Column]) -> bool:
    """Whether words in every column are names, if only ones that say nothing to us: all differ, and from ours."""
    words = {str(cell).strip() for cell in cells}
    return len(words) == len(columns) and not any(_is_ours(column, word) for word in words for column in columns)


def _is_another_name(column: Column, text: str) -> bool:
    heading = read_heading(text)
    return not _is_ours(column, text) and bool(heading.roles or heading.unit_text)


def _is_ours(column: Column, text: str) -> bool:
    """Whether a text is the name or the unit of a column, once more."""
    return plain_text(text) == plain_text(column.heading.text) or text.strip("[](){}<> ") == column.unit_text
