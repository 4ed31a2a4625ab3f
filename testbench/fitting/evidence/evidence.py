"""Log evidence of a linear-Gaussian model whose scales are found by maximum evidence.

r = J d + e,   e ~ N(0, sigma_c^2),   d ~ N(mean, 1 / precision);   a group of weights has one precision, found by
MacKay's update, as have the sigma_c. Source: MacKay, Neural Computation 4 (1992) 415.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from scipy.linalg import blas, lapack

from testbench.knit.effect import FloatArray

Rows = Mapping[str, FloatArray]  # channel -> columns at the samples that count, shape (m, k)
SMALLEST, LARGEST = 1e-2, 1e8  # of a group's precision, in that of its declared prior
ANY_SIZE = float(np.log(LARGEST / SMALLEST))  # width of the prior of ln(precision) where any size is as likely
OPEN = 1e2  # a start from which MacKay's updates reach either limit; from `LARGEST` they do not come back


@dataclass(frozen=True)
class NormalEquations:
    """Inner products of the residual (column 0) and the sensitivities, one channel at a time.

    Attributes
    ----------
    products : mapping of channel to ndarray, shape (q, q)
    count : float
        Independent samples of each channel.
    share : float
        Independent samples that each sample in the products stands for.
    least : mapping of channel to float
        Standard deviation that a residual counts as having at least: a closer fit earns nothing.
    mean, precision : ndarray, shape (q - 1,)
        Prior of the coefficients.
    group : ndarray of int, shape (q - 1,)
        Which group's scale a coefficient shares; -1: its precision is as declared.
    typical_groups : frozenset of int
        Groups whose declared width is a typical size: their standard deviation has Cauchy's prior of that scale. The
        size of the others is for the data to say.
    still : ndarray of int
        Coefficients that stay zero. What the data tell of them counts, as if they were best there.
    """

    products: Mapping[str, FloatArray]
    count: float
    share: float
    least: Mapping[str, float]
    mean: FloatArray
    precision: FloatArray
    group: np.ndarray
    typical_groups: frozenset[int] = frozenset()
    still: np.ndarray = field(default_factory=lambda: np.zeros(0, int))

    def information(self, sigma: Mapping[str, float]) -> dict[str, float]:
        """Independent samples that each sample stands for, over the variance of the noise, per channel."""
        return {c: self.share / sigma[c] ** 2 for c in self.products}

    def over_noise(self, sigma: Mapping[str, float]) -> FloatArray:
        """Inner products over the variance of the noise, of all channels together, shape (q, q)."""
        total = np.zeros((len(self.mean) + 1, len(self.mean) + 1))
        for c, information in self.information(sigma).items():
            total += self.products[c] * information
        return total

    def extended(self, base: Rows, rows: Rows, mean, precision, group) -> NormalEquations:
        """The same with more columns (`base`, those that are there, and `rows` already weighted robustly)."""
        products = {}
        for c, gram in self.products.items():
            cross = rows[c] @ base[c].T
            products[c] = np.block([[gram, cross.T], [cross, rows[c] @ rows[c].T]])
        return replace(
            self,
            products=products,
            mean=np.r_[self.mean, mean],
            precision=np.r_[self.precision, precision],
            group=np.r_[self.group, np.asarray(group, int)],
        )


@dataclass(frozen=True)
class LogEvidence:
    """Where the evidence of a linear model is largest.

    Attributes
    ----------
    value : float
        ln Z.
    coefficients : ndarray, shape (q - 1,)
    sigma : dict of channel to float
    scale : ndarray
        Factor on the precision of each group.
    cholesky : ndarray, shape (q - 1, q - 1)
        Lower Cholesky factor of the precision matrix of the coefficients.
    """

    value: float
    coefficients: FloatArray
    sigma: Mapping[str, float]
    scale: FloatArray
    cholesky: FloatArray

    @cached_property
    def covariance(self) -> FloatArray:
        """Covariance of the coefficients, shape (q - 1, q - 1)."""
        lower, _ = lapack.dpotri(self.cholesky, lower=1)
        return np.tril(lower) + np.tril(lower, -1).T


def maximised(
    normal: NormalEquations,
    sigma: Mapping[str, float] | None = None,
    iterations: int = 12,
    scale: FloatArray | None = None,
    sigma_is_known: bool = False,
) -> LogEvidence:
    """Maximise ln Z over the scales of the groups and the noise of the channels.

    Groups that are switched off (their scale is `LARGEST`) are taken to first order, each coefficient by itself: they
    come back where the data pull at them hard enough.

    Parameters
    ----------
    sigma : mapping of channel to float, optional
        Noise to start from, standard deviation.
    iterations : int
        At most; one judges with the noise and the scales as they are given.
    scale : ndarray, optional
        Factor on the precision of each group to start from.
    sigma_is_known : bool
        Only the scales of the groups are found.
    """
    declared, group, mean = normal.precision, normal.group, normal.mean
    scale = np.ones(int(group.max(initial=-1)) + 1) if scale is None else scale.copy()
    left = {c: float(np.sqrt(g[0, 0] * normal.share / normal.count)) for c, g in normal.products.items()}
    sigma = dict(sigma or {c: max(size, normal.least[c]) for c, size in left.items()})
    members = [np.flatnonzero(group == g) for g in range(len(scale))]
    value = -np.inf
    for _ in range(iterations):
        free = is_on(group, scale)
        precision = scaled(declared, group, scale)
        moved, known, chol = _solved(normal.over_noise(sigma), precision, mean, free, normal.still)
        x = mean + np.where(free, moved, 0.0)
        vector = np.r_[1.0, -x]
        left = {c: max(float(vector @ g @ vector), 1e-300) * normal.share for c, g in normal.products.items()}
        squares = {c: max(one, normal.count * normal.least[c] ** 2) for c, one in left.items()}
        before, value = value, _log_evidence(squares, sigma, normal.count, x, mean, precision, chol)
        determined = [float(known[where].sum()) for where in members]
        value -= _cost_of_scales(determined, scale, normal.typical_groups)
        if not sigma_is_known:
            sigma = {c: np.sqrt(one / normal.count) for c, one in squares.items()}
        for g, where in enumerate(members):
            if len(where):
                more = (1 - scale[g]) / (1 + scale[g]) if g in normal.typical_groups else 0.0
                size = max(float(declared[where] @ moved[where] ** 2), 1e-12)
                scale[g] = np.clip(max(determined[g] + more, 1e-3) / size, SMALLEST, LARGEST)
        if abs(value - before) < 0.05:
            break
    return LogEvidence(float(value), x, sigma, scale, chol)


def scaled(precision: FloatArray, group: np.ndarray, scale: FloatArray) -> FloatArray:
    """Declared precisions times the scales of their groups, each shape (q - 1,)."""
    return precision * np.where(group >= 0, scale[group], 1.0) if len(scale) else precision


def is_on(group: np.ndarray, scale: FloatArray) -> np.ndarray:
    """Whether each coefficient, of these groups, is free, shape (q - 1,): the others are at their prior means."""
    return (group < 0) | (scale[group] < LARGEST) if len(scale) else np.ones(len(group), bool)


def _solved(
    total: FloatArray, precision: FloatArray, mean: FloatArray, free: np.ndarray, still: np.ndarray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Coefficients of the linear model, less their prior means; those that are off each beside the others alone.

    Parameters
    ----------
    total : ndarray, shape (q, q)
        Inner products over the variance of the noise, of all channels.

    Returns
    -------
    moved, known : ndarray, shape (q - 1,)
        The coefficients, and how far the data determine each: 1, or nothing: 0.
    factor : ndarray, shape (q - 1, q - 1)
        Lower Cholesky factor of their precision matrix.
    """
    on, off = np.flatnonzero(free), np.flatnonzero(~free)
    inner = total[1:, 1:]
    pull = total[1:, 0] - inner @ mean
    matrix = inner[on][:, on]
    matrix[np.diag_indices_from(matrix)] += precision[on]
    chol, failed = lapack.dpotrf(matrix, lower=1)
    if failed:
        matrix[np.diag_indices_from(matrix)] *= 1 + 1e-9
        chol, failed = lapack.dpotrf(matrix, lower=1)
    if not len(on):  # which LAPACK refuses
        step, inverse = pull[on], chol
    else:
        step = _beside(matrix, pull, mean, on, still) if len(still) else lapack.dpotrs(chol, pull[on], lower=1)[0]
        inverse = lapack.dtrtri(chol, lower=1)[0]  # above the diagonal, zeros as in `chol`
    cross = inner[on][:, off]
    taken = blas.dtrmm(1.0, inverse, cross, lower=1) if len(off) else cross
    alone = np.maximum(np.diag(inner)[off] - np.einsum("ki,ki->i", taken, taken), 0.0) + precision[off]
    moved, known, factor = np.zeros(len(mean)), np.zeros(len(mean)), np.zeros(inner.shape)
    moved[on], known[on] = step, 1 - precision[on] * np.einsum("ki,ki->i", inverse, inverse)
    moved[off], known[off] = (pull[off] - step @ cross) / alone, 1 - precision[off] / alone
    factor[np.ix_(on, on)], factor[off, off] = chol, np.sqrt(alone)
    return moved, known, factor


def _beside(matrix: FloatArray, pull: FloatArray, mean: FloatArray, on: np.ndarray, still: np.ndarray) -> FloatArray:
    """Coefficients that are on, less their prior means, where some of them stay zero; shape (len(on),)."""
    stays = np.isin(on, still)
    moves, step = ~stays, np.where(stays, -mean[on], 0.0)
    goal = pull[on][moves] - matrix[np.ix_(moves, stays)] @ step[stays]
    if len(goal):
        step[moves] = lapack.dposv(matrix[np.ix_(moves, moves)], goal, lower=1)[1]
    return step


def switched_on(scale: FloatArray) -> FloatArray:
    """Scales to start from in another model: what was switched off in this one may be needed there."""
    return np.minimum(scale, OPEN)


def _cost_of_scales(known: Sequence[float], scale: FloatArray, typical_groups: frozenset[int]) -> float:
    """What it costs, in nats, that the scales of the groups were not known but found.

    k coefficients that the data determine tell ln(precision) within sqrt(2 / k); a group that is switched off costs
    nothing. Source: MacKay, Neural Computation 4 (1992) 415, section 4.4 (error bars of the regularising constant).
    A width is one over the prior density of ln(precision): with Cauchy's prior of a standard deviation s in typical
    sizes, s / (pi (1 + s^2)).
    """
    widths = (
        np.pi * (1 + scale[g]) / np.sqrt(scale[g]) if g in typical_groups else ANY_SIZE for g in range(len(known))
    )
    return sum(
        float(np.log1p(width * np.sqrt(max(k, 0.0) / (4 * np.pi)))) for width, k in zip(widths, known, strict=True)
    )


def _log_evidence(
    squares: Mapping[str, float],
    sigma: Mapping[str, float],
    count: float,
    x: FloatArray,
    mean: FloatArray,
    precision: FloatArray,
    chol: FloatArray,
) -> float:
    misfit = sum(squares[c] / sigma[c] ** 2 + 2 * count * np.log(sigma[c]) for c in squares)
    prior = float(precision @ (x - mean) ** 2) - float(np.log(precision).sum())
    return -0.5 * (misfit + prior) - float(np.log(np.diag(chol)).sum())
