"""Smooth curves as sums of compiled basis functions: cubic B-splines, and cosines over a range."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from testbench.knit.effect import FloatArray


@njit(cache=True, nogil=True)
def _bumps_at(x: float, spans: int) -> tuple[int, float, float, float, float]:
    """First of the four cubic bumps that reach x, held within 0 <= x <= 1, and six times the height of each there."""
    u = min(max(x, 0.0), 1.0) * spans
    cell = min(int(u), spans - 1)
    t = u - cell
    s = 1.0 - t
    return cell, s**3, 4 - 6 * t**2 + 3 * t**3, 4 - 6 * s**2 + 3 * s**3, t**3


def bspline(x: FloatArray, weights: FloatArray) -> FloatArray:
    """Uniform cubic B-spline over 0 <= x <= 1 with one weight a bump, held flat outside.

    Parameters
    ----------
    x : ndarray, shape (n,)
    weights : ndarray, shape (k,), k >= 4
        Equal weights give that constant (the bumps sum to one).

    Source: de Boor, A Practical Guide to Splines (1978), uniform cubic case.
    """
    return bsplines_over(x, weights[:, None], np.ones((1, len(x))))


@njit("float64[:](float64[:], float64[:, :], float64[:, :])", cache=True, nogil=True)
def bsplines_over(x: FloatArray, weights: FloatArray, factors: FloatArray) -> FloatArray:
    """sum_k f_k B_k(x), where B_k is the B-spline of the weights in column k: as `bspline`, for all at once.

    Parameters
    ----------
    x : ndarray, shape (n,)
    weights : ndarray, shape (bumps, m)
    factors : ndarray, shape (m, n)
    """
    spans, many = weights.shape[0] - 3, weights.shape[1]
    out = np.empty_like(x)
    for i in range(len(x)):
        cell, first, second, third, last = _bumps_at(x[i], spans)
        total = 0.0
        for k in range(many):
            own = weights[cell, k] * first + weights[cell + 1, k] * second
            total += factors[k, i] * (own + weights[cell + 2, k] * third + weights[cell + 3, k] * last)
        out[i] = total / 6
    return out


CELLS = 256  # of the table of a cosine series: with 30 terms it is off by 1e-7 of the weights


@njit("float64[:](float64[:], float64, float64, float64[:])", cache=True, nogil=True)
def cosine_series(x: FloatArray, low: float, span: float, weights: FloatArray) -> FloatArray:
    """w_0 u + w_1 u^2 + sum_k w_(k+1) cos(k pi u) / k^2 with u = (x - low) / span, clipped to 0 <= u <= 1.

    Between the points of a table of values and slopes it goes as a cubic (Hermite interpolation; de Boor, A Practical
    Guide to Splines (1978), ch. 4).
    """
    value, slope = np.empty(CELLS + 1), np.empty(CELLS + 1)
    for j in range(CELLS + 1):
        u = j / CELLS
        value[j] = weights[0] * u + weights[1] * u * u
        slope[j] = weights[0] + 2 * weights[1] * u
        c, s = math.cos(math.pi * u), math.sin(math.pi * u)
        cosine, sine = c, s
        for k in range(1, len(weights) - 1):
            value[j] += weights[k + 1] * cosine / (k * k)
            slope[j] -= weights[k + 1] * sine * math.pi / k
            cosine, sine = c * cosine - s * sine, s * cosine + c * sine
        slope[j] /= CELLS
    out = np.empty_like(x)
    for i in range(len(x)):
        u = min(max((x[i] - low) / span, 0.0), 1.0) * CELLS
        cell = min(int(u), CELLS - 1)
        t = u - cell
        rise = value[cell + 1] - value[cell]
        first, last = slope[cell], slope[cell + 1]
        out[i] = value[cell] + t * (first + t * (3 * rise - 2 * first - last + t * (first + last - 2 * rise)))
    return out


@njit("float64[:, :](float64[:], float64, float64, int64)", cache=True, nogil=True)
def cosines(x: FloatArray, low: float, span: float, count: int) -> FloatArray:
    """The terms that `cosine_series` sums, each with weight 1, shape (count, n)."""
    out = np.empty((count, len(x)))
    for i in range(len(x)):
        u = min(max((x[i] - low) / span, 0.0), 1.0)
        out[0, i], out[1, i] = u, u * u
        twice = 2 * math.cos(math.pi * u)
        before, now = 1.0, twice / 2
        for k in range(1, count - 1):
            out[k + 1, i] = now / (k * k)
            before, now = now, twice * now - before
    return out
