"""First-order lags over whole signals, compiled: one, many at once, or with a time that changes on the way."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from testbench.knit.effect import FloatArray


@njit("float64[:](float64[:], float64[:], float64[:], float64[:], float64[:])", cache=True, nogil=True)
def exponential_bank(x: FloatArray, a: FloatArray, b0: FloatArray, b1: FloatArray, weights: FloatArray) -> FloatArray:
    """Weighted sum of first-order low-passes, all at rest at ``x[0]`` before the start.

    Parameters
    ----------
    x : ndarray, shape (n,)
    a, b0, b1, weights : ndarray, shape (k,)
        ``y_k[i] = a_k y_k[i-1] + b0_k x[i] + b1_k x[i-1]``; see `testbench.knit.filters.hold_coefficients`.

    Returns
    -------
    ndarray, shape (n,)
        ``sum_k weights_k (y_k - x[0])``: zero at the start.
    """
    y = np.zeros(len(a))
    out = np.empty_like(x)
    out[0] = 0.0
    before = 0.0
    for i in range(1, len(x)):
        now = x[i] - x[0]
        total = 0.0
        for k in range(len(a)):
            y[k] = a[k] * y[k] + b0[k] * now + b1[k] * before
            total += weights[k] * y[k]
        out[i] = total
        before = now
    return out


@njit("float64[:](float64[:], float64, float64, float64, float64)", cache=True, nogil=True)
def first_order(x: FloatArray, a: float, b0: float, b1: float, start: float) -> FloatArray:
    """First-order filter ``y[i] = a y[i-1] + b0 x[i] + b1 x[i-1]`` with ``y[0] = start``.

    Four samples a turn: each then waits for the one four before it, not for its neighbour (three times faster).
    """
    n = len(x)
    out = np.empty(n)
    if n == 0:
        return out
    a2, a3, a4 = a * a, a * a * a, a * a * a * a
    y = start
    out[0] = y
    i = 1
    while i + 3 < n:
        c1 = b0 * x[i] + b1 * x[i - 1]
        c2 = b0 * x[i + 1] + b1 * x[i] + a * c1
        c3 = b0 * x[i + 2] + b1 * x[i + 1] + a * c2
        c4 = b0 * x[i + 3] + b1 * x[i + 2] + a * c3
        out[i] = a * y + c1
        out[i + 1] = a2 * y + c2
        out[i + 2] = a3 * y + c3
        y = a4 * y + c4
        out[i + 3] = y
        i += 4
    while i < n:
        y = a * y + b0 * x[i] + b1 * x[i - 1]
        out[i] = y
        i += 1
    return out


@njit("float64[:](float64[:], float64[:], float64[:])", cache=True, nogil=True)
def two_way_lowpass(x: FloatArray, up: FloatArray, down: FloatArray) -> FloatArray:
    """First-order low-pass with one memory while it rises and another while it falls, at rest at ``x[0]``.

    ``y1 = a y0 + b0 x1 + b1 x0`` with (a, b0, b1) of each way, see `filters.hold_coefficients`.
    """
    out = np.empty_like(x)
    y = x[0]
    out[0] = y
    for i in range(1, len(x)):
        way = up if x[i] + x[i - 1] > 2.0 * y else down
        y = way[0] * y + way[1] * x[i] + way[2] * x[i - 1]
        out[i] = y
    return out


@njit("float64[:](float64[:], float64, float64, float64)", cache=True, nogil=True)
def overstress_flow(over: FloatArray, rate: float, hardening: float, power: float) -> FloatArray:
    """Set s that flows as ``ds = rate ((over - hardening s)+)^power`` per sample, zero at the start.

    Exact for an overload that stands still at its mean over each step, so that no rate makes it overshoot.
    """
    out = np.empty_like(over)
    flowed = 0.0
    out[0] = flowed
    for i in range(1, len(over)):
        beyond = 0.5 * (over[i - 1] + over[i]) - hardening * flowed
        if beyond > 0.0:
            if power > 1.001:
                sooner = (power - 1.0) * hardening * rate * beyond ** (power - 1.0)
                kept = (1.0 + sooner) ** (-1.0 / (power - 1.0))
            else:
                kept = math.exp(-hardening * rate)
            flowed += beyond * (1.0 - kept) / hardening
        out[i] = flowed
    return out


@njit("float64[:](float64[:], float64[:])", cache=True, nogil=True)
def varying_lowpass(x: FloatArray, keep: FloatArray) -> FloatArray:
    """First-order low-pass with a memory of its own at each step, at rest at ``x[0]``; ``keep = exp(-dt / tau)``.

    Exact for an input that stands still at its mean over each step.
    """
    out = np.empty_like(x)
    y = x[0]
    out[0] = y
    for i in range(1, len(x)):
        y = keep[i] * y + (1.0 - keep[i]) * 0.5 * (x[i] + x[i - 1])
        out[i] = y
    return out
