"""Log evidence of a linear-Gaussian model whose scales are found by maximum evidence.

r = J d + e,   e ~ N(0, sigma_c^2),   d ~ N(mean, 1 / precision);   a group of weights has one precision, found by
MacKay's update, as have the sigma_c. Source: MacKay, Neural Computation 4 (1992) 415.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import lapack

from testbench.knit.effect import FloatArray

SMALLEST, LARGEST = 1e-2, 1e8  # of a group's precision, in that of its declared prior
ANY_SIZE = float(np.log(LARGEST / SMALLEST))  # width of the prior of ln(precision) where any size is as likely
TYPICAL_SIZE = 2 * np.pi  # the same width for Cauchy's prior on a standard deviation, at its centre
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
    typical : frozenset of int
        Groups whose declared width is a typical size: their standard deviation has Cauchy's prior of that scale. The
        size of the others is for the data to say.
    """

    products: Mapping[str, FloatArray]
    count: float
    share: float
    least: Mapping[str, float]
    mean: FloatArray
    precision: FloatArray
    group: np.ndarray
    typical: frozenset[int] = frozenset()


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
    factor : ndarray, shape (q - 1, q - 1)
        Lower Cholesky factor of the precision matrix of the coefficients.
    """

    value: float
    coefficients: FloatArray
    sigma: Mapping[str, float]
    scale: FloatArray
    factor: FloatArray

    @cached_property
    def covariance(self) -> FloatArray:
        """Covariance of the coefficients, shape (q - 1, q - 1)."""
        lower, _ = lapack.dpotri(self.factor, lower=1)
        return np.tril(lower) + np.tril(lower, -1).T


@dataclass(frozen=True)
class _Part:
    """The normal equations of the coefficients that are not switched off; the others are at their prior means.

    Attributes
    ----------
    products : mapping of channel to ndarray, shape (m + 1, m + 1)
        Of what those others leave of the residual, and of the sensitivities that remain.
    share : float
        As in `NormalEquations`.
    count : int
        m.
    """

    products: Mapping[str, FloatArray]
    share: float
    count: int

    @classmethod
    def of(cls, normal: NormalEquations, on: np.ndarray) -> _Part:
        if len(on) == len(normal.mean):
            return cls(normal.products, normal.share, len(on))
        off, picked = np.r_[1.0, -normal.mean], np.r_[0, on + 1]
        off[on + 1] = 0.0
        products = {}
        for c, gram in normal.products.items():
            part = gram[np.ix_(picked, picked)]
            if off[1:].any():
                left = off @ gram
                part[0], part[:, 0] = left[picked], left[picked]
                part[0, 0] = left @ off
            products[c] = part
        return cls(products, normal.share, len(on))

    def solved(
        self, sigma: Mapping[str, float], precision: FloatArray, mean: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Coefficients, shape (m,), and the lower Cholesky factor of their precision matrix, shape (m, m)."""
        total = np.zeros((self.count + 1, self.count + 1))
        for c, gram in self.products.items():
            total += gram * (self.share / sigma[c] ** 2)
        matrix = total[1:, 1:].copy()
        matrix[np.diag_indices_from(matrix)] += precision
        chol, failed = lapack.dpotrf(matrix, lower=1)
        if failed:
            matrix[np.diag_indices_from(matrix)] *= 1 + 1e-9
            chol, failed = lapack.dpotrf(matrix, lower=1)
        return lapack.dpotrs(chol, total[1:, 0] + precision * mean, lower=1)[0], chol

    def left(self, x: FloatArray) -> dict[str, float]:
        """Squares of what the coefficients leave, per channel."""
        vector = np.r_[1.0, -x]
        return {c: max(float(vector @ g @ vector), 1e-300) * self.share for c, g in self.products.items()}


def maximised(
    normal: NormalEquations,
    start: LogEvidence | None = None,
    iterations: int = 12,
    scale: FloatArray | None = None,
) -> LogEvidence:
    """Maximise ln Z over the scales of the groups and the noise of the channels.

    A group that is switched off (its scale is `LARGEST`) stays so: its coefficients are what the prior says, and add
    nothing to ln Z.
    """
    declared, group = normal.precision, normal.group
    factor = np.ones(int(group.max(initial=-1)) + 1) if scale is None else scale.copy()
    sizes = {c: float(np.sqrt(g[0, 0] * normal.share / normal.count)) for c, g in normal.products.items()}
    sigma = dict(start.sigma) if start else sizes
    members = [np.flatnonzero(group == g) for g in range(len(factor))]
    value, part = -np.inf, _Part.of(normal, np.arange(len(group)))
    for _ in range(iterations):
        scaled = declared * np.where(group >= 0, factor[group], 1.0) if len(factor) else declared
        on = np.flatnonzero((group < 0) | (factor[group] < LARGEST)) if len(factor) else np.arange(len(group))
        if len(on) != part.count:
            part = _Part.of(normal, on)
        x, chol = part.solved(sigma, scaled[on], normal.mean[on])
        squares = {c: max(one, normal.count * normal.least[c] ** 2) for c, one in part.left(x).items()}
        known = _known(members, scaled, on, chol)
        before, value = value, _value(squares, sigma, normal.count, x, normal.mean[on], scaled[on], chol)
        value -= sum(float(np.log1p(1 / factor[g])) for g in normal.typical)
        value -= _found_scales(known, normal.typical)
        sigma = {c: np.sqrt(one / normal.count) for c, one in squares.items()}
        coefficients = normal.mean.copy()
        coefficients[on] = x
        square = declared * (coefficients - normal.mean) ** 2
        for g, where in enumerate(members):
            if len(where):
                more = 2 / (1 + factor[g]) if g in normal.typical else 0.0
                size = max(float(square[where].sum()), 1e-12)
                factor[g] = np.clip(max(known[g] + more, 1e-3) / size, SMALLEST, LARGEST)
        if abs(value - before) < 0.05:
            break
    whole = np.diag(np.sqrt(scaled))
    whole[np.ix_(on, on)] = chol
    return LogEvidence(float(value), coefficients, sigma, factor, whole)


def _known(members: Sequence[np.ndarray], precision: FloatArray, on: np.ndarray, chol: FloatArray) -> list[float]:
    """Coefficients of each group that the data determine; none of a group that is switched off."""
    inverse, _ = lapack.dtrtri(chol, lower=1)
    variance = 1 / precision
    variance[on] = np.einsum("ki,ki->i", inverse, inverse)
    return [len(where) - float(precision[where] @ variance[where]) for where in members]


def opened(scale: FloatArray) -> FloatArray:
    """Scales to start from in another model: what was switched off in this one may be needed there."""
    return np.minimum(scale, OPEN)


def _found_scales(known: Sequence[float], typical: frozenset[int]) -> float:
    """What it costs, in nats, that the scales of the groups were not known but found.

    k coefficients that the data determine tell ln(precision) within sqrt(2 / k); a group that is switched off costs
    nothing. Source: MacKay, Neural Computation 4 (1992) 415, section 4.4 (error bars of the regularising constant).
    """
    widths = (TYPICAL_SIZE if g in typical else ANY_SIZE for g in range(len(known)))
    return sum(
        float(np.log1p(width * np.sqrt(max(k, 0.0) / (4 * np.pi)))) for width, k in zip(widths, known, strict=True)
    )


def _value(
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
