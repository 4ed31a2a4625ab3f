"""Smooth curves as sums of compiled basis functions: cubic B-splines, and cosines over a range."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from testbench.knit.effect import FloatArray


@njit("float64[:](float64[:], float64[:])", cache=True, nogil=True)
def bspline(x: FloatArray, weights: FloatArray) -> FloatArray:
    """Uniform cubic B-spline over 0 <= x <= 1 with one weight a bump, held flat outside.

    Parameters
    ----------
    x : ndarray, shape (n,)
    weights : ndarray, shape (k,), k >= 4
        Equal weights give that constant (the bumps sum to one).

    Source: de Boor, A Practical Guide to Splines (1978), uniform cubic case.
    """
    spans = len(weights) - 3
    out = np.empty_like(x)
    for i in range(len(x)):
        u = min(max(x[i], 0.0), 1.0) * spans
        cell = min(int(u), spans - 1)
        t = u - cell
        s = 1.0 - t
        out[i] = (
            weights[cell] * s**3
            + weights[cell + 1] * (4 - 6 * t**2 + 3 * t**3)
            + weights[cell + 2] * (4 - 6 * s**2 + 3 * s**3)
            + weights[cell + 3] * t**3
        ) / 6
    return out


_SIDE = 64


@njit("float64[:](float64[:], float64, float64, float64[:])", cache=True, nogil=True)
def cosine_series(x: FloatArray, low: float, span: float, weights: FloatArray) -> FloatArray:
    """w_0 u + w_1 u^2 + sum_k w_(k+1) cos(k pi u) / k^2 with u = (x - low) / span, clipped to 0 <= u <= 1.

    Source: Clenshaw, Math. Tables Aids Comput. 9 (1955) 118 (summing a Chebyshev series).
    """
    terms = len(weights) - 2
    scaled = np.empty(terms)
    for k in range(terms):
        scaled[k] = weights[k + 2] / (k + 1) ** 2
    out = np.empty_like(x)
    # Samples go side by side, for each has to wait for its own last term.
    u, first, now, after = np.empty(_SIDE), np.empty(_SIDE), np.empty(_SIDE), np.empty(_SIDE)
    for start in range(0, len(x), _SIDE):
        count = min(_SIDE, len(x) - start)
        for i in range(count):
            u[i] = min(max((x[start + i] - low) / span, 0.0), 1.0)
            first[i] = math.cos(math.pi * u[i])
            now[i], after[i] = 0.0, 0.0
        for k in range(terms - 1, -1, -1):
            for i in range(count):
                new = scaled[k] + 2.0 * first[i] * now[i] - after[i]
                after[i] = now[i]
                now[i] = new
        for i in range(count):
            out[start + i] = weights[0] * u[i] + weights[1] * u[i] * u[i] + now[i] * first[i] - after[i]
    return out
