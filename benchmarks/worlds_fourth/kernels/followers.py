"""States that follow something in time, from sample to sample."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from worlds_fourth.signals import Array


@njit(cache=True)
def follow(target: Array, share: Array, start: float) -> Array:
    """First-order follower: at each step it goes by a share of the way to the target. One value more than steps."""
    out = np.empty(len(target) + 1)
    y = start
    out[0] = y
    for k in range(len(target)):
        y += (target[k] - y) * share[k]
        out[k + 1] = y
    return out


@njit(cache=True)
def grow_towards(target: Array, step_s: Array, tau_s: float) -> Array:
    """Follows a target that is above it, and keeps what it has while the target is below."""
    out = np.empty(len(target))
    p = 0.0
    for k in range(len(target)):
        if target[k] > p:
            p += (target[k] - p) * (1 - math.exp(-step_s[k] / tau_s))
        out[k] = p
    return out


@njit(cache=True)
def wander(push: Array, tau: float) -> Array:
    """A random walk that is drawn back (Ornstein-Uhlenbeck), in steps of one; `push` is white noise of unit RMS."""
    out = np.empty(len(push))
    y = 0.0
    for k in range(len(push)):
        y += -y / tau + push[k] * math.sqrt(2 / tau)
        out[k] = y
    return out


@njit(cache=True)
def age(speed: Array, step_s: Array) -> Array:
    """Age of contacts in s (Dieterich, 1979): ``d theta/dt = 1 - theta speed``, speed in slip lengths a second."""
    out = np.empty(len(speed))
    theta = 1.0
    for k in range(len(speed)):
        h, q = step_s[k], speed[k]
        if q * h > 1e-6:
            theta = 1 / q + (theta - 1 / q) * math.exp(-q * h)
        else:
            theta += h
        out[k] = theta
    return out


@njit(cache=True)
def heat(log_g: Array, step_s: Array, speed: Array, tau_s: float, cooling: float, mode: float, gain: float) -> Array:
    """Temperature of a conductor that its current heats and that changes its ln G by `gain` a unit.

    Heated by ``exp(mode ln G)``: mode 1 is a constant voltage, -1 a constant current. Motion cools it.
    """
    out = np.empty(len(log_g))
    warm = 0.0
    for k in range(len(log_g)):
        power = math.exp(min(2.5, max(-2.5, mode * (log_g[k] + gain * warm))))
        loss = 1 + cooling * speed[k]
        warm += (power / loss - warm) * (1 - math.exp(-step_s[k] * (loss / tau_s)))
        out[k] = warm
    return out


@njit(cache=True)
def crystals(x: Array, step_s: Array, grows_above: float, melts_below: float, grow_s: float, melt_s: float) -> Array:
    """Share of crystallites that grow above one strain and melt below another, lower one."""
    out = np.empty(len(x))
    s = 0.0
    for k in range(len(x)):
        if x[k] > grows_above:
            s += (1 - s) * (1 - math.exp(-step_s[k] / grow_s * (x[k] - grows_above) / 0.2))
        elif x[k] < melts_below:
            s *= math.exp(-step_s[k] / melt_s)
        out[k] = s
    return out


@njit(cache=True)
def curl(x: Array, step_s: Array, rolls_below: float, roll_s: float, reach: float) -> Array:
    """Share of the edge that is rolled up: grows in time below a strain, unrolls over a way of stretching."""
    out = np.empty(len(x))
    s, before = 0.0, 0.0
    for k in range(len(x)):
        if x[k] < rolls_below:
            s += (1 - s) * (1 - math.exp(-step_s[k] / roll_s))
        elif x[k] > before:
            s *= math.exp(-(x[k] - before) / reach)
        before = x[k]
        out[k] = s
    return out
