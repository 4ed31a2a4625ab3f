"""Memory with a loop over the samples, compiled: plays, friction states, lags in time and in travel, turns.

Every kernel takes arrays of shape (n,) and starts fresh at the first sample.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[Any]


@njit(cache=True)
def play_stack(x, radii, weights):
    """Weighted sum of play operators: each follows `x` only when pushed by an edge of its band."""
    y = np.zeros(len(x))
    p = np.full(len(radii), x[0])
    for i in range(len(x)):
        total = 0.0
        for j in range(len(radii)):
            p[j] = min(max(p[j], x[i] - radii[j]), x[i] + radii[j])
            total += weights[j] * p[j]
        y[i] = total
    return y


def play(x: Array, radius: float) -> Array:
    """One play operator of a half width `radius`."""
    return play_stack(x, np.array([radius]), np.ones(1))


@njit(cache=True)
def bouc_wen(x, power, reach, roundness):
    """State z of Bouc and Wen within -1..1, that turns over about `reach` of travel (Wen 1976)."""
    out = np.zeros(len(x))
    z = 0.0
    for i in range(1, len(x)):
        whole = x[i] - x[i - 1]
        count = int(abs(whole) / (0.1 * reach)) + 1
        dx = whole / count
        for _ in range(count):
            held = roundness * (1.0 if z * dx > 0 else -1.0) + 1.0 - roundness
            z += dx / reach * (1.0 - abs(z) ** power * held)
            z = min(max(z, -1.0), 1.0)
        out[i] = z
    return out


@njit(cache=True)
def dahl(x, reach, alpha):
    """Friction state of Dahl (1968) within -1..1; `alpha` bends the way into sliding."""
    out = np.zeros(len(x))
    z = 0.0
    for i in range(1, len(x)):
        whole = x[i] - x[i - 1]
        count = int(abs(whole) / (0.1 * reach)) + 1
        dx = whole / count
        side = 1.0 if dx > 0 else -1.0
        for _ in range(count):
            z += dx / reach * max(1.0 - side * z, 0.0) ** alpha
            z = min(max(z, -1.0), 1.0)
        out[i] = z
    return out


@njit(cache=True)
def travel_lag(x, up, down):
    """A follower that closes its gap over a length of travel, another length on the way down."""
    out = np.empty(len(x))
    q = x[0]
    out[0] = q
    for i in range(1, len(x)):
        dx = x[i] - x[i - 1]
        q += (x[i] - q) * (1.0 - np.exp(-abs(dx) / (up if dx > 0 else down)))
        out[i] = q
    return out


@njit(cache=True)
def _lag(x, dt, tau, start):
    out = np.empty(len(x))
    y = start
    out[0] = y
    for i in range(1, len(x)):
        keep = np.exp(-dt[i] / tau[i])
        ramp = (1.0 - keep) * tau[i] / dt[i]
        y = keep * y + (1.0 - ramp) * x[i] + (ramp - keep) * x[i - 1]
        out[i] = y
    return out


def lag(x: Array, dt: Array, tau: float | Array, start: float | None = None) -> Array:
    """First-order lag of time constant `tau` (s), exact between samples; `tau` may change from sample to sample."""
    taus = np.full(len(x), tau) if np.ndim(tau) == 0 else np.asarray(tau)
    return _lag(x, dt, taus, float(x[0] if start is None else start))


@njit(cache=True)
def kinetics(gain, loss, dt):
    """State n of ``n' = gain (1 - n) - loss n`` from n = 0, with rates in 1/s that change over time."""
    out = np.zeros(len(dt))
    n = 0.0
    for i in range(1, len(dt)):
        total = gain[i] + loss[i]
        if total > 0.0:
            rest = gain[i] / total
            n = rest + (n - rest) * np.exp(-total * dt[i])
        out[i] = n
    return out


@njit(cache=True)
def turns(x, threshold):
    """Turns of the motion larger than `threshold`: half cycles so far (summed swing), last upper turn, direction.

    Returns three arrays: the sum of the swings that are finished, the value at the last upper turn (the running
    maximum before the first) and the direction of motion (+1, -1).
    """
    n = len(x)
    swings, upper, side = np.zeros(n), np.empty(n), np.ones(n)
    low = high = last = top = x[0]
    d, total = 1.0, 0.0
    for i in range(n):
        low, high = min(low, x[i]), max(high, x[i])
        if d > 0 and x[i] < high - threshold:
            d, total, top, last, low = -1.0, total + abs(high - last), high, high, x[i]
        elif d < 0 and x[i] > low + threshold:
            d, total, last, high = 1.0, total + abs(low - last), low, x[i]
        swings[i], side[i] = total, d
        upper[i] = max(top, x[i]) if d > 0 else top
    return swings, upper, side


@njit(cache=True)
def breakaway(x, grip):
    """Stick-slip: distance from a held point that lets go, and holds anew where it is, at `grip`."""
    out = np.zeros(len(x))
    held = x[0]
    for i in range(len(x)):
        if abs(x[i] - held) > grip:
            held = x[i]
        out[i] = x[i] - held
    return out


@njit(cache=True)
def ringing(x, dt, frequency_hz, damping):
    """A second-order follower below critical damping, exact for an input held over each sample."""
    out = np.empty(len(x))
    w = 2.0 * np.pi * frequency_hz
    wd = w * np.sqrt(1.0 - damping**2)
    y, v = x[0], 0.0
    out[0] = y
    for i in range(1, len(x)):
        a = y - 0.5 * (x[i] + x[i - 1])
        b = (v + damping * w * a) / wd
        fade = np.exp(-damping * w * dt[i])
        c, s = np.cos(wd * dt[i]), np.sin(wd * dt[i])
        y_next = fade * (a * c + b * s)
        v = fade * ((b * wd - damping * w * a) * c - (a * wd + damping * w * b) * s)
        y = y_next + 0.5 * (x[i] + x[i - 1])
        out[i] = y
    return out


@njit(cache=True)
def held_within(x, band):
    """A read-out that shows its old value until the new one is further away than `band`."""
    out = np.empty(len(x))
    shown = x[0]
    for i in range(len(x)):
        if abs(x[i] - shown) > band:
            shown = x[i]
        out[i] = shown
    return out


@njit(cache=True)
def two_ranges(x, up, down):
    """1 where a meter is in its upper range: switched on above `up` and off below `down`."""
    out = np.zeros(len(x))
    state = 1.0 if x[0] > up else 0.0
    for i in range(len(x)):
        if x[i] > up:
            state = 1.0
        elif x[i] < down:
            state = 0.0
        out[i] = state
    return out


@njit(cache=True)
def joule_heat(ln_power, dt, tau, feedback):
    """Temperature (relative) of a body heated by its own current, whose power falls as it warms."""
    out = np.zeros(len(dt))
    warm = 0.0
    for i in range(1, len(dt)):
        keep = np.exp(-dt[i] / tau)
        warm = keep * warm + (1.0 - keep) * np.exp(ln_power[i] - feedback * warm)
        out[i] = warm
    return out
