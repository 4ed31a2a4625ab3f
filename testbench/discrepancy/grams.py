"""Inner products of residual, sensitivities and traces.

Once these small matrices are known, every question of the screening (fit on these blocks, judge on those) is linear
algebra on a few hundred numbers, however long the recordings are.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit

from testbench.discrepancy.measurement import Measurement
from testbench.discrepancy.noise import whitened
from testbench.knit.effect import FloatArray

BLOCKS = 40


@dataclass(frozen=True)
class Grams:
    """Inner products of whitened columns over one recording, every other of its `BLOCKS` blocks apart.

    Attributes
    ----------
    even, odd : ndarray, shape (q, q)
        Column 0 is the residual, the next `base` columns are the base's sensitivities, the rest traces.
    base : int
        Number of sensitivities.
    """

    even: FloatArray
    odd: FloatArray
    base: int

    @property
    def total(self) -> FloatArray:
        """Over the whole recording, shape (q, q)."""
        return self.even + self.odd


Rows = Sequence[FloatArray | None]  # one channel's columns; None where a column does not touch the channel


@dataclass(frozen=True)
class Weighting:
    """How the samples of a recording count.

    Attributes
    ----------
    filters, scale : mapping of channel
        Whitening filter and the spread of the whitened residual.
    stride : int
        Use every so many samples only; neighbours say nearly the same.
    """

    filters: Mapping[str, FloatArray]
    scale: Mapping[str, float]
    stride: int = 1


def grams(columns: Mapping[str, Rows], measurement: Measurement, weighting: Weighting, base: int) -> Grams:
    """Whiten the columns of each channel, centre them over the recording, and multiply them.

    Parameters
    ----------
    columns : mapping of channel to sequence of ndarray or None, each shape (n,)
        Residual, sensitivities, and what is to be weighed.
    weighting : Weighting
    base : int
        Number of sensitivities among the columns.
    """
    blocks = np.array_split(np.flatnonzero(measurement.counts)[:: weighting.stride], BLOCKS)
    order, half = np.concatenate([*blocks[::2], *blocks[1::2]]), sum(map(len, blocks[::2]))
    count = len(next(iter(columns.values())))
    even, odd = np.zeros((count, count)), np.zeros((count, count))
    for channel, values in columns.items():
        touching = [index for index, row in enumerate(values) if row is not None]
        white = np.empty((len(touching), len(order)))
        for place, row in enumerate(row for row in values if row is not None):
            picked = whitened(row, weighting.filters[channel])[order] / weighting.scale[channel]
            # Force zero and conductance gain belong to the mounting of each recording: they are free.
            white[place] = picked - picked.mean()
        square = np.ix_(touching, touching)
        for gram, piece in ((even, white[:, :half]), (odd, white[:, half:])):
            gram[square] += piece @ piece.T
    return Grams(even, odd, base)


@dataclass(frozen=True)
class Reduced:
    """A least-squares problem in the traces alone, the base having had its say.

    Attributes
    ----------
    fit : ndarray, shape (m, m)
        Inner products of residual (index 0) and traces on the blocks to fit on, base eliminated.
    judge : ndarray, shape (m, m)
        Inner products on the blocks to judge on, with the base as it was fitted.
    """

    fit: FloatArray
    judge: FloatArray

    def amounts(self, chosen: Sequence[int], signed: Sequence[bool]) -> FloatArray:
        """Best amounts of the chosen traces (indices count from 1), shape (len(chosen),)."""
        rows = np.asarray(chosen, int)
        return nonnegative(self.fit[np.ix_(rows, rows)], self.fit[rows, 0], np.asarray(signed, bool))

    def shrunk(self, chosen: Sequence[int], ridge: float) -> FloatArray:
        """Amounts of the chosen columns under a ridge, in thousandths of each column's own inner product."""
        rows = np.asarray(chosen, int)
        matrix = self.fit[np.ix_(rows, rows)].copy()
        diagonal = np.maximum(np.diag(matrix), 1e-12 * np.max(np.diag(matrix), initial=1e-300))
        matrix[np.diag_indices_from(matrix)] = diagonal * (1 + 1e-3 * ridge)
        return np.linalg.solve(matrix, self.fit[rows, 0])

    def judged(self, chosen: Sequence[int], amounts: FloatArray) -> float:
        """Squared misfit on the judging blocks."""
        rows = np.r_[0, np.asarray(chosen, int)]
        vector = np.r_[1.0, -amounts]
        return float(vector @ self.judge[np.ix_(rows, rows)] @ vector)


def reduce_to_traces(
    fit_on: FloatArray, judge_on: FloatArray, base: int, ridge: FloatArray, kept: np.ndarray, weights: FloatArray
) -> Reduced:
    """Eliminate the base from the inner products.

    Parameters
    ----------
    fit_on, judge_on : ndarray, shape (q, q)
        Sums over the blocks to fit and to judge on.
    base : int
        Number of sensitivities; they follow the residual.
    ridge : ndarray, shape (base,)
        Prior precision of their coefficients.
    kept : ndarray of bool, shape (base,)
        Sensitivities that this base has.
    weights : ndarray, shape (base,)
        Present values of those it has not: without them the residual is larger by their contribution.
    """
    inner, rest = 1 + np.flatnonzero(kept), np.r_[0, np.arange(base + 1, len(fit_on))]
    residual = np.zeros(len(fit_on))
    residual[0] = 1.0
    residual[1 + np.flatnonzero(~kept)] = weights[~kept]
    outer, cross, own = _split(fit_on, residual, inner, rest)
    # The ridge enters the fit as a penalty on the base's own coefficients.
    amounts = np.linalg.solve(own + np.diag(ridge[kept]), cross)
    judged_outer, judged_cross, judged_own = _split(judge_on, residual, inner, rest)
    mixed = amounts.T @ judged_cross
    judge = judged_outer - mixed - mixed.T + amounts.T @ (judged_own @ amounts)
    return Reduced(outer - cross.T @ amounts, judge)


def _split(
    total: FloatArray, residual: FloatArray, inner: np.ndarray, rest: np.ndarray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Inner products among residual and traces, of the base with these, and within the base."""
    with_all = total @ residual
    outer = total[np.ix_(rest, rest)]
    outer[0] = outer[:, 0] = with_all[rest]
    outer[0, 0] = residual @ with_all
    cross = total[np.ix_(inner, rest)]
    cross[:, 0] = with_all[inner]
    return outer, cross, total[np.ix_(inner, inner)]


@njit("float64[::1](float64[:,::1], float64[::1], boolean[::1])", cache=True, nogil=True)
def _descend(normal: FloatArray, goal: FloatArray, signed: np.ndarray) -> FloatArray:
    x = np.zeros(len(goal))
    for _ in range(300):
        moved, largest = 0.0, 1e-12
        for i in range(len(x)):
            value = x[i] + (goal[i] - normal[i] @ x) / normal[i, i]
            if not signed[i]:
                value = max(value, 0.0)
            moved, largest = max(moved, abs(value - x[i])), max(largest, abs(value))
            x[i] = value
        if moved < 1e-6 * largest:
            break
    return x


def nonnegative(matrix: FloatArray, target: FloatArray, signed: np.ndarray) -> FloatArray:
    """Least squares with some coefficients held at or above zero, by coordinate descent.

    A small ridge keeps near-copies (neighbouring points of a grid) from fighting each other.
    """
    scale = 1 / np.sqrt(np.maximum(np.diag(matrix), 1e-300))
    normal = np.ascontiguousarray(matrix * np.outer(scale, scale))
    normal[np.diag_indices_from(normal)] = 1.0 + 1e-3
    return _descend(normal, np.ascontiguousarray(target * scale), np.ascontiguousarray(signed)) * scale
