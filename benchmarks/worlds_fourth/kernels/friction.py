"""States that remember the way, at any speed: play, sliding springs and bristles."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from worlds_fourth.signals import Array


@njit(cache=True)
def play(x: Array, half_width: Array, start: float) -> Array:
    """Lost motion: the follower moves only when an end of the gap pushes it; the gap may change."""
    out = np.empty(len(x))
    y = start
    for k in range(len(x)):
        b, r = x[k], half_width[k]
        if b - r > y:
            y = b - r
        elif b + r < y:
            y = b + r
        out[k] = y
    return out


@njit(cache=True)
def plays(x: Array, half_widths: Array, weights: Array) -> Array:
    """Weighted sum of plays that all begin at 0 (Prandtl and Ishlinskii)."""
    out = np.empty(len(x))
    y = np.zeros(len(half_widths))
    for k in range(len(x)):
        y = np.minimum(x[k] + half_widths, np.maximum(x[k] - half_widths, y))
        out[k] = np.dot(y, weights)
    return out


@njit(cache=True)
def sliding_springs(x: Array, reaches: Array, weights: Array) -> Array:
    """Springs in parallel, each of which slides at its own reach (Iwan, 1966; Jenkins elements)."""
    out = np.empty(len(x))
    q = np.zeros(len(reaches))
    before = x[0]
    for k in range(len(x)):
        q = np.minimum(reaches, np.maximum(-reaches, q + (x[k] - before)))
        before = x[k]
        out[k] = np.dot(q, weights)
    return out


@njit(cache=True)
def dahl(x: Array, reach: float) -> Array:
    """Dahl's friction (1968) ``dz/dx = (sgn(dx) - z)/reach``, exact; starts at 0, stays within -1 and 1."""
    out = np.empty(len(x))
    z, before = 0.0, x[0]
    for k in range(len(x)):
        d = x[k] - before
        if d > 0:
            z = 1 + (z - 1) * math.exp(-d / reach)
        elif d < 0:
            z = -1 + (z + 1) * math.exp(d / reach)
        before = x[k]
        out[k] = z
    return out


@njit(cache=True)
def bouc_wen(x: Array, reach: float, power: float, loading: float) -> Array:
    """Bouc (1967) and Wen (1976): ``dz = (1 - |z|^n (1 - g + g sgn(z dx))) dx/reach``, in steps of a hundredth."""
    out = np.empty(len(x))
    z, before = 0.0, x[0]
    longest = 0.01 * reach
    for k in range(len(x)):
        d = x[k] - before
        before = x[k]
        parts = int(abs(d) / longest) + 1
        h = d / parts / reach
        for _ in range(parts):
            size = abs(z) ** power
            if z * h > 0:
                z += h * (1 - size * (1 - loading + loading * 1.0))
            else:
                z += h * (1 + size * (2 * loading - 1))
        z = min(1.0, max(-1.0, z))
        out[k] = z
    return out


@njit(cache=True)
def stick_slip(x: Array, jumps: Array, reach: float, left: float) -> Array:
    """A spring that is stretched by the way and lets go at the next of `jumps`, down to the share `left`."""
    out = np.empty(len(x))
    z, before, count = 0.0, 0.0, 0
    for k in range(len(x)):
        z += (x[k] - before) / reach
        before = x[k]
        if abs(z) > jumps[count]:
            z *= left
            count = (count + 1) % len(jumps)
        out[k] = z
    return out


@njit(cache=True)
def switched(x: Array, up: float, down: float, start: float) -> Array:
    """A relay: 1 above one level, 0 below another, as it was between."""
    out = np.empty(len(x))
    s = start
    for k in range(len(x)):
        if x[k] > up:
            s = 1.0
        elif x[k] < down:
            s = 0.0
        out[k] = s
    return out
