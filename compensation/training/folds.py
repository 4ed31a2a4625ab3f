"""What cross-validation holds out: whole recordings where there are enough, else contiguous parts of all rows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from compensation.series.preprocessing import Series

FOLDS, GROUPS_FROM = 5, 3


def folds_of(series: Sequence[Series]) -> NDArray[np.int64]:
    """Number of the fold of every row: recordings shared out, or contiguous parts of all rows."""
    lengths = [len(part) for part in series]
    if len(series) >= GROUPS_FROM:
        count = min(len(series), FOLDS)
        return np.repeat(np.arange(len(series)) * count // len(series), lengths)
    total = sum(lengths)
    return np.arange(total) * FOLDS // total


def cut(series: Sequence[Series], folds: NDArray[np.int64]) -> list[Series]:
    """The recordings cut where the folds meet: what each fold is predicted from."""
    found, begin = [], 0
    for part in series:
        own = folds[begin : begin + len(part)]
        found += [part.rows(rows) for rows in np.split(np.arange(len(part)), np.flatnonzero(np.diff(own)) + 1)]
        begin += len(part)
    return found
