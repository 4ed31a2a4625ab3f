"""Readings averaged onto a uniform grid."""

from __future__ import annotations

import numpy as np

from testbench.knit.effect import FloatArray

EDGE = 1e-3  # of a bin: times since 1970 are known to 0.2 microseconds


def read_at(grid_s: FloatArray, time_s: FloatArray, step_s: float) -> np.ndarray:
    """Whether a sample lies within `step_s` of each grid point: what was interpolated over a gap is no reading."""
    after = np.searchsorted(time_s, grid_s).clip(1, len(time_s) - 1)
    off_s = np.abs(time_s[[after - 1, after]] - grid_s).min(axis=0)
    return np.asarray(off_s <= step_s)


class Bins:
    """Means of the samples around each grid point, moved from their mean time to the grid point.

    Where samples are rarer than the grid, neighbours are interpolated.

    Parameters
    ----------
    time_s : ndarray, shape (samples,)
        From zero.
    rate_hz : float
        Of the grid.
    """

    def __init__(self, time_s: FloatArray, rate_hz: float) -> None:
        self._time_s = time_s
        # A sample on an edge, but for rounding, is behind it; one on the last edge has no bin of its own.
        place = (time_s * rate_hz + EDGE).astype(np.int64)
        count = int(place[-1])
        self._bin = np.minimum(place, count - 1)
        self._filled = np.bincount(self._bin, minlength=count)
        # Averages are only worth it where nearly every bin has a sample of its own.
        self._average = bool(np.mean(self._filled == 0) < 0.2 and len(time_s) > 1.5 * count)
        self.grid_s = np.arange(count) / rate_hz
        self._off_s = np.zeros(count)
        if self._average:
            # As samples at even times lie in all bins alike: nothing is moved then, not even over a sharp turn.
            self.grid_s += np.median((self._means(time_s) - self.grid_s)[self._filled > 0])
            self._off_s = self._means(time_s) - self.grid_s  # none where a bin is empty: interpolated at its point

    @property
    def is_read(self) -> np.ndarray:
        """See `read_at`, shape (grid points,)."""
        return read_at(self.grid_s, self._time_s, self.grid_s[1] - self.grid_s[0])

    @property
    def averaged(self) -> float:
        """Samples whose mean is as noisy as a grid point: the harmonic mean over the bins."""
        return 1 / float(np.mean(1 / np.maximum(self._filled, 1))) if self._average else 1.0

    def __call__(self, values: FloatArray) -> FloatArray:
        if not self._average:
            return np.interp(self.grid_s, self._time_s, values)
        means = self._means(values)
        return means - self._off_s * _gentler_slope(means, self.grid_s + self._off_s)

    def _means(self, values: FloatArray) -> FloatArray:
        sums = np.bincount(self._bin, weights=values, minlength=len(self.grid_s))
        gaps = np.interp(self.grid_s, self._time_s, values)
        return np.where(self._filled > 0, sums / np.maximum(self._filled, 1), gaps)


def _gentler_slope(values: FloatArray, time_s: FloatArray) -> FloatArray:
    """The slope to the neighbour that is less steep, and none at a turn: what is moved along it never overshoots.

    Source: van Leer, J. Comput. Phys. 32 (1979) 101 (slope limiters; Roe's minmod).
    """
    steps = np.diff(values) / np.diff(time_s)
    before, after = np.append(steps[:1], steps), np.append(steps, steps[-1:])
    return np.where(before * after > 0, np.sign(before) * np.minimum(np.abs(before), np.abs(after)), 0.0)
