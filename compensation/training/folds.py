"""What cross-validation holds out: whole recordings where that leaves enough, else contiguous parts of all rows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from compensation.series.preprocessing import Series

FOLDS, GROUPS_FROM = 5, 3
# A fold that holds more of all rows is predicted from less than it has itself, which says nothing of the whole.
LARGEST_SHARE = 0.5


def folds_of(series: Sequence[Series]) -> tuple[NDArray[np.int64], bool]:
    """Number of the fold of every row, and whether they are whole recordings: of three or more, none huge."""
    count = min(len(series), FOLDS)
    whole = np.repeat(np.arange(len(series)) * count // len(series), [len(part) for part in series])
    if len(series) >= GROUPS_FROM and np.bincount(whole).max() <= LARGEST_SHARE * len(whole):
        return whole, True
    return contiguous(len(whole), FOLDS), False


def fold_count(folds: NDArray[np.int64]) -> int:
    """How many folds rows with these numbers are in."""
    return int(folds.max()) + 1


def contiguous(rows: int, count: int) -> NDArray[np.int64]:
    """Which of so many parts in a row each of so many rows is in."""
    return np.arange(rows) * count // rows


def split(series: Sequence[Series], held_out: NDArray[np.bool_]) -> tuple[list[Series], list[Series]]:
    """What is learned from and what is held out: the recordings, or what is left of them on either side of a cut."""
    rest: list[Series] = []
    parts: list[Series] = []
    begin = 0
    for part in series:
        own = held_out[begin : begin + len(part)]
        for rows in np.split(np.arange(len(part)), np.flatnonzero(np.diff(own)) + 1):
            (parts if own[rows[0]] else rest).append(part.rows(rows))
        begin += len(part)
    return rest, parts
