"""Fewer points, the same picture: every spike that a screen could show is kept."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gcode.support.arrays import FloatArray

LEAST = 200  # samples that a look at a stretch needs
POINTS = 2000  # nearly twice the pixels of a wide plot: each pixel column keeps its lowest and highest sample


def rows_to_draw(values: FloatArray, points: int = POINTS) -> NDArray[np.intp]:
    """Rows of the samples that keep the outline of `values`, shape (m,) with m <= about `points`.

    The recording is cut into equal stretches and the lowest and highest sample of each is kept (min-max),
    so no peak is lost however far one is zoomed out.
    """
    from tsdownsample import MinMaxDownsampler

    points = max(4, points - points % 2)
    if len(values) <= points:
        return np.arange(len(values), dtype=np.intp)
    rows = MinMaxDownsampler().downsample(np.ascontiguousarray(values), n_out=points)
    return np.union1d(rows.astype(np.intp), [0, len(values) - 1])


def liveliest(time_s: FloatArray, energy: FloatArray, length_s: float) -> tuple[float, float]:
    """The stretch of `length_s`, of at least `LEAST` samples, that holds most of `energy`, shape (n,); the first."""
    width = min(len(time_s), max(round(length_s / float(np.median(np.diff(time_s)))), LEAST))
    sums = np.concatenate([[0.0], np.cumsum(energy)])
    start = int(np.argmax(sums[width:] - sums[:-width]))
    return float(time_s[start]), float(time_s[start + width - 1])


def window(time_s: FloatArray, start_s: float | None, end_s: float | None) -> slice:
    """The rows between two times, with one sample on either side so that lines reach the edge."""
    first = 0 if start_s is None else max(0, int(np.searchsorted(time_s, start_s)) - 1)
    last = len(time_s) if end_s is None else min(len(time_s), int(np.searchsorted(time_s, end_s)) + 1)
    return slice(first, max(last, first + 2))
