"""Sequential operators, compiled: play, stop and running maxima over whole signals.

Each walks once through the samples, which NumPy cannot do; numba makes them 100 times faster than Python.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from testbench.knit.effect import FloatArray


@njit("float64[:,:](float64[:], float64[:])", cache=True, nogil=True)
def play(x: FloatArray, thresholds: FloatArray) -> FloatArray:
    """Play (backlash) operators, started at rest at ``x[0]``.

    Parameters
    ----------
    x : ndarray, shape (n,)
    thresholds : ndarray, shape (k,)
        Half widths, in the unit of `x`.

    Returns
    -------
    ndarray, shape (k, n)
        ``y = min(max(y_before, x - r), x + r)``, with ``y_before = x[0]`` at the start.

    Source: Visintin, Differential Models of Hysteresis (1994), ch. III; Kuhnen, Eur. J. Control 9 (2003) 407.
    """
    out = np.empty((len(thresholds), len(x)))
    for k in range(len(thresholds)):
        r = thresholds[k]
        y = x[0]
        for i in range(len(x)):
            y = min(max(y, x[i] - r), x[i] + r)
            out[k, i] = y
    return out


@njit("float64[:](float64[:])", cache=True, nogil=True)
def running_max(x: FloatArray) -> FloatArray:
    """Largest value so far, shape (n,)."""
    out = np.empty_like(x)
    top = x[0]
    for i in range(len(x)):
        top = max(top, x[i])
        out[i] = top
    return out


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


@njit("float64(float64, float64, float64)", cache=True, nogil=True)
def _bouc_wen_of_exponent_1(z: float, step: float, skew: float) -> float:
    """z after a step of x / threshold, exactly (up to a change of sign of z within it)."""
    ahead = 1.0 if step > 0.0 else -1.0
    side = ahead if z == 0.0 else (1.0 if z > 0.0 else -1.0)
    rate = (1.0 - skew) * ahead + skew * side
    # moved = (1 - exp(-rate step)) / rate, by its series for short steps
    k = rate * step
    moved = step * (1.0 - k / 2.0 * (1.0 - k / 3.0)) if abs(k) < 1e-4 else (1.0 - math.exp(-k)) / rate
    return min(max(z + (1.0 - rate * z) * moved, -1.0), 1.0)


@njit("float64(float64, float64, float64, float64)", cache=True, nogil=True)
def _bouc_wen_slope(z: float, ahead: float, skew: float, exponent: float) -> float:
    """threshold dz/dx; `ahead` is the way that x goes, 1 or -1."""
    size = abs(z) ** exponent
    return 1.0 - size if z * ahead >= 0.0 else 1.0 + (1.0 - 2.0 * skew) * size


@njit("float64(float64, float64, float64, float64)", cache=True, nogil=True)
def _bouc_wen_in_parts(z: float, step: float, skew: float, exponent: float) -> float:
    """z after a step of x / threshold, by Heun's rule over parts that move z by no more than a tenth or two."""
    ahead = 1.0 if step > 0.0 else -1.0
    parts = int(abs(step) / 0.1) + 1
    part = step / parts
    for _ in range(parts):
        first = part * _bouc_wen_slope(z, ahead, skew, exponent)
        there = min(max(z + first, -1.0), 1.0)
        second = part * _bouc_wen_slope(there, ahead, skew, exponent)
        z = min(max(z + 0.5 * (first + second), -1.0), 1.0)
    return z


@njit("float64[:](float64[:], float64, float64, float64)", cache=True, nogil=True)
def bouc_wen(x: FloatArray, threshold: float, skew: float, exponent: float) -> FloatArray:
    """Bouc-Wen hysteretic variable, in [-1, 1], at zero in the beginning.

    dz = (1 - |z|^exponent ((1 - skew) sgn(dx z) + skew)) dx / threshold
    """
    out = np.empty_like(x)
    z = 0.0
    out[0] = z
    for i in range(1, len(x)):
        step = (x[i] - x[i - 1]) / threshold
        if step != 0.0:
            if exponent == 1.0:
                z = _bouc_wen_of_exponent_1(z, step, skew)
            else:
                z = _bouc_wen_in_parts(z, step, skew, exponent)
        out[i] = z
    return out


@njit("float64[:](float64[:], float64)", cache=True, nogil=True)
def travelled(x: FloatArray, dead_band: float) -> FloatArray:
    """Path length of `x` so far, not counting wiggles within +-`dead_band` (noise would add up for ever)."""
    out = np.empty_like(x)
    y = x[0]
    path = 0.0
    out[0] = path
    for i in range(1, len(x)):
        new = min(max(y, x[i] - dead_band), x[i] + dead_band)
        path += abs(new - y)
        y = new
        out[i] = path
    return out


@njit("float64[:](float64[:], float64, float64)", cache=True, nogil=True)
def crossings(x: FloatArray, level: float, rearm: float) -> FloatArray:
    """How many times `x` has risen through `level` so far, having been below `rearm` in between."""
    out = np.empty_like(x)
    count = 0.0
    armed = x[0] < level
    for i in range(len(x)):
        if armed and x[i] >= level:
            count += 1.0
            armed = False
        elif x[i] < rearm:
            armed = True
        out[i] = count
    return out


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


@njit("float64[:](float64[:], float64, float64)", cache=True, nogil=True)
def follower(x: FloatArray, up: float, down: float) -> FloatArray:
    """Follows `x` by closing its gap over a length of travel, `up` when `x` rises and `down` when it falls.

    dq = (x - q) |dx| / travel, exact over each monotonic step.
    """
    out = np.empty_like(x)
    gap = 0.0
    out[0] = x[0]
    for i in range(1, len(x)):
        step = x[i] - x[i - 1]
        travel = up if step > 0.0 else down
        kept = math.exp(-abs(step) / travel)
        gap = gap * kept + math.copysign(travel, step) * (1.0 - kept)
        out[i] = x[i] - gap
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


# NaN never reaches the stops, and the order of their sum is free: only so can the processor take several at once.
_ANY_ORDER = {"reassoc", "nnan", "nsz", "contract"}


@njit("float64[:](float64[:], float64[:], float64[:], float64[:])", cache=True, nogil=True, fastmath=_ANY_ORDER)
def weighted_stops(x: FloatArray, thresholds: FloatArray, weights: FloatArray, growth: FloatArray) -> FloatArray:
    """Sum of normalised stop operators ``(x - play_r(x)) / r``, weighted by ``weights + growth * x``, shape (n,)."""
    # All operators advance together: none has to wait for its own last step.
    used = (weights != 0.0) | (growth != 0.0)
    r = thresholds[used]
    weight, grown = weights[used] / r, growth[used] / r
    y = np.full(len(r), x[0])
    out = np.empty_like(x)
    for i in range(len(x)):
        now, fixed, growing = x[i], 0.0, 0.0
        for k in range(len(r)):
            low, high = now - r[k], now + r[k]
            played = y[k] if y[k] > low else low
            played = played if played < high else high
            y[k] = played
            fixed += weight[k] * (now - played)
            growing += grown[k] * (now - played)
        out[i] = fixed + growing * now
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


@njit("float64[:](float64[:], float64[:])", cache=True, nogil=True)
def mean_stop(x: FloatArray, thresholds: FloatArray) -> FloatArray:
    """Mean of the normalised stop operators ``(x - play_r(x)) / r``, shape (n,)."""
    return weighted_stops(x, thresholds, np.full(len(thresholds), 1.0 / len(thresholds)), np.zeros(len(thresholds)))


@njit("float64[:](float64[:], float64, float64)", cache=True, nogil=True)
def two_way_lowpass(x: FloatArray, keep_up: float, keep_down: float) -> FloatArray:
    """First-order low-pass with one memory while it rises and another while it falls, at rest at ``x[0]``.

    ``keep = exp(-dt / tau)`` for each way.
    """
    out = np.empty_like(x)
    y = x[0]
    for i in range(len(x)):
        keep = keep_up if x[i] > y else keep_down
        y = keep * y + (1.0 - keep) * x[i]
        out[i] = y
    return out


@njit("float64[:](float64[:], float64)", cache=True, nogil=True)
def dahl(x: FloatArray, travel: float) -> FloatArray:
    """Dahl friction over `x`: dz/dx = (1 - z sign(dx)) / travel, exact along straight lines, z = 0 at the start."""
    z = np.empty_like(x)
    state = 0.0
    z[0] = state
    for i in range(1, len(x)):
        dx = x[i] - x[i - 1]
        if dx != 0.0:
            end = 1.0 if dx > 0 else -1.0
            state = end + (state - end) * np.exp(-abs(dx) / travel)
        z[i] = state
    return z


@njit("Tuple((float64[:], float64[:], float64[:]))(float64[:], float64)", cache=True, nogil=True)
def turns(x: FloatArray, back: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Where `x` last turned, where that became known, and how often it has turned, each shape (n,).

    A turn is known once `x` has come back from its extreme by more than `back`; wobbles below are none. When that was
    is told between the samples, so that it moves smoothly with `back`.
    """
    turned, known, count = np.empty_like(x), np.empty_like(x), np.empty_like(x)
    heading, extreme, at = 0.0, x[0], 0
    last_turned, last_known, so_far = 0, 0.0, 0
    for i in range(len(x)):
        if heading == 0.0 and abs(x[i] - x[0]) > back:
            heading = 1.0 if x[i] > x[0] else -1.0
            extreme, at = x[i], i
        elif (x[i] - extreme) * heading > 0.0:
            extreme, at = x[i], i
        elif (extreme - x[i]) * heading > back:
            over, step = (extreme - x[i]) * heading - back, (x[i - 1] - x[i]) * heading
            last_turned, last_known, so_far = at, i - min(over / step, 1.0), so_far + 1
            heading, extreme, at = -heading, x[i], i
        turned[i], known[i], count[i] = last_turned, last_known, so_far
    return turned, known, count


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
