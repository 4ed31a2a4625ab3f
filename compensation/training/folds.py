"""What cross-validation holds out: whole recordings where that leaves enough, else contiguous parts of all rows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from compensation.series.preprocessing import Series

FOLDS, GROUPS_FROM = 5, 3
# A fold that holds more of all rows is predicted from less than it has itself, which says nothing of the whole.
LARGEST_SHARE = 0.5


def whole_recordings(series: Sequence[Series]) -> bool:
    """Whether the folds are whole recordings: of three or more, none so long that its fold has over half of all."""
    if len(series) < GROUPS_FROM:
        return False
    folds = _shared_out(series)
    return bool(np.bincount(folds).max() <= LARGEST_SHARE * len(folds))


def folds_of(series: Sequence[Series]) -> NDArray[np.int64]:
    """Number of the fold of every row: recordings shared out, or contiguous parts of all rows."""
    if whole_recordings(series):
        return _shared_out(series)
    return contiguous(sum(len(part) for part in series), FOLDS)


def fold_count(folds: NDArray[np.int64]) -> int:
    """How many folds rows with these numbers are in."""
    return int(folds.max()) + 1


def contiguous(rows: int, count: int) -> NDArray[np.int64]:
    """Which of so many parts in a row each of so many rows is in."""
    return np.arange(rows) * count // rows


def _shared_out(series: Sequence[Series]) -> NDArray[np.int64]:
    count = min(len(series), FOLDS)
    return np.repeat(np.arange(len(series)) * count // len(series), [len(part) for part in series])


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
