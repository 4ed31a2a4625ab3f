"""Operators with a memory of where a signal has been, compiled: play, stop, Bouc-Wen, travel and turns.

They depend on no rate. Each walks once through the samples; numba makes that 100 times faster than Python.
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
    y = np.full(len(thresholds), x[0])
    # All operators advance together: none has to wait for its own last step.
    for i in range(len(x)):
        for k in range(len(thresholds)):
            y[k] = min(max(y[k], x[i] - thresholds[k]), x[i] + thresholds[k])
            out[k, i] = y[k]
    return out


@njit("boolean[:](float64[:], float64)", cache=True, nogil=True)
def moves(x: FloatArray, step: float) -> FloatArray:
    """Where x has come more than `step` away from where it last moved to, shape (n,)."""
    out = np.zeros(len(x), np.bool_)
    at = x[0]
    for i in range(len(x)):
        if abs(x[i] - at) > step:
            at, out[i] = x[i], True
    return out


@njit("float64(float64, float64, float64)", cache=True, nogil=True)
def _exact_step(z: float, step: float, skew: float) -> float:
    """z after a step of x / threshold, exactly."""
    ahead = 1.0 if step > 0.0 else -1.0
    if z * ahead < 0.0:
        # On the way to zero |z| falls by 1 + (1 - 2 skew) |z|; beyond zero it turns by another law.
        slope = 1.0 - 2.0 * skew
        size = abs(z)
        way = size if abs(slope) < 1e-6 else math.log1p(slope * size) / slope
        if way < abs(step):
            z, step = 0.0, step - ahead * way
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


@njit("float64[:](float64[:], float64, float64, float64, boolean, float64)", cache=True, nogil=True)
def _bouc_wen(x: FloatArray, threshold: float, skew: float, exponent: float, exact: bool, z: float) -> FloatArray:
    out = np.empty_like(x)
    out[0] = z
    for i in range(1, len(x)):
        step = (x[i] - x[i - 1]) / threshold
        if step != 0.0:
            z = _exact_step(z, step, skew) if exact else _bouc_wen_in_parts(z, step, skew, exponent)
        out[i] = z
    return out


def bouc_wen(x: FloatArray, threshold: float, skew: float, exponent: float) -> FloatArray:
    """Bouc-Wen hysteretic variable, in [-1, 1], at zero in the beginning, shape (n,).

    dz = (1 - |z|^exponent ((1 - skew) sgn(dx z) + skew)) dx / threshold
    """
    return _bouc_wen(x, threshold, skew, exponent, False, 0.0)


def bouc_wen_of_exponent_1(x: FloatArray, threshold: float, skew: float, start: float = 0.0) -> FloatArray:
    """The same at exponent 1, where each step is known exactly, from `start` on; without skew it is Dahl friction."""
    return _bouc_wen(x, threshold, skew, 1.0, True, start)


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


@njit("float64[:](float64[:], float64[:])", cache=True, nogil=True)
def mean_stop(x: FloatArray, thresholds: FloatArray) -> FloatArray:
    """Mean of the normalised stop operators ``(x - play_r(x)) / r``, shape (n,)."""
    return weighted_stops(x, thresholds, np.full(len(thresholds), 1.0 / len(thresholds)), np.zeros(len(thresholds)))


@njit("Tuple((float64[:], float64[:], float64[:]))(float64[:], float64)", cache=True, nogil=True)
def turns(x: FloatArray, back: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Where `x` last turned, where that became known, and how often it has turned, each shape (n,).

    A turn is known once `x` has come back from its extreme by more than `back`; wobbles below are none. When that was
    is told between the samples, so that it moves smoothly with `back`. The first way, too, begins at an extreme, not
    at the first sample; since no more than a wobble may have led there, that is no turn.
    """
    turned, known, count = np.empty_like(x), np.empty_like(x), np.empty_like(x)
    heading, extreme, at = 0.0, x[0], 0
    lowest, highest = x[0], x[0]  # before the first way is known
    last_turned, last_known, so_far = 0, 0.0, 0
    for i in range(len(x)):
        if heading == 0.0:
            lowest, highest = min(lowest, x[i]), max(highest, x[i])
            if highest - lowest > back:
                heading = 1.0 if x[i] == highest else -1.0
                extreme, at = x[i], i
        elif (x[i] - extreme) * heading > 0.0:
            extreme, at = x[i], i
        elif (extreme - x[i]) * heading > back:
            over, step = (extreme - x[i]) * heading - back, (x[i - 1] - x[i]) * heading
            last_turned, last_known, so_far = at, i - min(over / step, 1.0), so_far + 1
            heading, extreme, at = -heading, x[i], i
        turned[i], known[i], count[i] = last_turned, last_known, so_far
    return turned, known, count


def last_turn(x: FloatArray, back: float) -> np.ndarray:
    """Sample at which `x` last turned, as far as that is known by then, shape (n,); the first before any turn."""
    return turns(np.ascontiguousarray(x), back)[0].astype(int)
