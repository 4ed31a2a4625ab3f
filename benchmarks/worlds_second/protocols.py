"""How the clamps move: five protocols over relative stroke 0..1, each drawn anew for every recording.

The rig moves in straight lines from sample to sample, so the recorded displacement says all of the motion, also at
a low rate; there the whole protocol is slowed down, so that a swing still has some samples.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from worlds_second.kernels import Array

FINEST_HZ = 20.0  # the physics runs at least this fast
JITTER = 0.02  # of the sampling period
SLOWEST_PACE_HZ = 2.0  # below this rate the protocol slows down with it
START_S = 4.0
PLAY = 0.02  # of the clamps, relative to stroke and full scale


@dataclass(frozen=True)
class Motion:
    """The clamps' way on a fine grid, and which of its points were sampled.

    Attributes
    ----------
    t, dt, x : ndarray, shape (n,)
        Time (s), its steps (s) and relative stroke (0..1).
    every : int
        Each so-manieth point is a sample.
    room_K : ndarray, shape (n,)
        How much warmer the room is than at a calm start.
    shift : float
        Relative stroke by which a sensor that was clamped anew sits elsewhere; not in the recorded displacement.
    zero : float
        Zero error of the force after clamping anew, relative to full scale.
    index : int
        0 for the calibration, 1 for the held-out recording.
    """

    t: Array
    dt: Array
    x: Array
    every: int
    room_K: Array
    shift: float = 0.0
    zero: float = 0.0
    index: int = 0


def draw_motion(
    rng: np.random.Generator, protocol: str, minutes: float, rate_hz: float, index: int, reclamped: bool = False
) -> Motion:
    """Draw one recording's motion, room temperature and, if clamped anew, its zeros."""
    count = round(minutes * 60.0 * rate_hz)
    at = (np.arange(count) + JITTER * rng.uniform(0.0, 1.0, count)) / rate_hz
    at -= at[0]
    pace = max(1.0, SLOWEST_PACE_HZ / rate_hz)
    sampled = np.clip(PROTOCOLS[protocol](rng, at / pace), 0.0, 1.0) * np.clip(at / pace / START_S, 0.0, 1.0)
    every = int(np.ceil(FINEST_HZ / rate_hz)) if rate_hz < FINEST_HZ else 1
    t = np.interp(np.arange((count - 1) * every + 1) / every, np.arange(count), at)
    dt = np.diff(t, prepend=t[0] - (t[1] - t[0]))
    room_K = room(rng, t)
    shift, zero = rng.uniform(-PLAY, PLAY, 2) if reclamped and index else (0.0, 0.0)
    return Motion(t, dt, np.interp(t, at, sampled), every, room_K, float(shift), float(zero), index)


def _knots(rng: np.random.Generator, t: Array, spacing_s: float) -> Array:
    """Gradient noise in one dimension (Perlin 1985)."""
    u = t / spacing_s + rng.uniform(0.0, 1.0)
    cell = u.astype(int)
    slope = rng.uniform(-1.0, 1.0, cell[-1] + 2)
    v = u - cell
    fade = v**3 * (v * (6.0 * v - 15.0) + 10.0)
    return (1.0 - fade) * slope[cell] * v + fade * slope[cell + 1] * (v - 1.0)


def _whole_stroke(y: Array) -> Array:
    return (y - y.min()) / np.ptp(y)


def perlin(rng: np.random.Generator, t: Array) -> Array:
    """Gradient noise of two or three octaves."""
    spacing = rng.uniform(5.0, 20.0)
    octaves = range(int(rng.integers(2, 4)))
    return _whole_stroke(np.sum([0.5**k * _knots(rng, t, spacing / 2.1**k) for k in octaves], axis=0))


def _through(times: list[float], levels: list[float], t: Array) -> Array:
    return np.interp(t, np.cumsum(times), levels)


def ramp_hold(rng: np.random.Generator, t: Array) -> Array:
    """Ramps of random speed to random levels, each followed by a hold of random length."""
    times, levels, hold = [0.0], [0.0], rng.uniform(20.0, 60.0)
    while sum(times) < t[-1]:
        level = 1.0 if len(levels) < 3 else rng.uniform(0.0, 1.0)
        times += [abs(level - levels[-1]) / np.exp(rng.uniform(np.log(0.03), np.log(0.5))) + 0.1]
        times += [hold * rng.uniform(0.3, 1.7)]
        levels += [level, level]
    return _through(times, levels, t)


def cyclic(rng: np.random.Generator, t: Array) -> Array:
    """Blocks of triangles or sines, each with its own amplitude, centre and period."""
    times, levels = [0.0], [0.0]
    rounded = rng.random() < 0.5
    while sum(times) < t[-1]:
        swing = rng.uniform(0.25, 1.0)
        low = rng.uniform(0.0, 1.0 - swing)
        period = np.exp(rng.uniform(np.log(4.0), np.log(30.0)))
        for _ in range(int(rng.integers(3, 12))):
            times += [0.5 * period, 0.5 * period]
            levels += [low + swing, low]
    way = _through(times, list(np.arange(len(levels), dtype=float)), t)
    cell = np.minimum(way.astype(int), len(levels) - 2)
    v = way - cell
    v = 0.5 - 0.5 * np.cos(np.pi * v) if rounded else v
    ends = np.asarray(levels)
    return (1.0 - v) * ends[cell] + v * ends[cell + 1]


def staircase(rng: np.random.Generator, t: Array) -> Array:
    """Up and down equal steps with equal holds; every flight has its own top and number of steps."""
    times, levels, hold, ramp = [0.0], [0.0], rng.uniform(10.0, 35.0), rng.uniform(0.3, 2.0)
    while sum(times) < t[-1]:
        steps = int(rng.integers(3, 8))
        flight = np.linspace(0.0, 1.0 if len(levels) < 3 else rng.uniform(0.4, 1.0), steps + 1)
        for level in [*flight[1:], *flight[-2::-1]]:
            times += [ramp, hold]
            levels += [float(level)] * 2
    return _through(times, levels, t)


def multisine(rng: np.random.Generator, t: Array) -> Array:
    """Six to ten sines of random phase between 4 s and 100 s."""
    count = int(rng.integers(6, 11))
    periods = np.exp(np.linspace(np.log(4.0), np.log(100.0), count) + rng.uniform(-0.1, 0.1, count))
    phases = rng.uniform(0.0, 2 * np.pi, count)
    sines = [p**0.3 * np.sin(2 * np.pi * t / p + phi) for p, phi in zip(periods, phases, strict=True)]
    return _whole_stroke(np.sum(sines, axis=0))


def room(rng: np.random.Generator, t: Array) -> Array:
    """Temperature of the room: a trend, a heating that cycles, and a slow wander (K)."""
    hours = t / 3600.0
    cycle = rng.uniform(0.2, 0.8) * np.sin(2 * np.pi * t / rng.uniform(240.0, 900.0) + rng.uniform(0.0, 6.3))
    return rng.uniform(-3.0, 3.0) * hours + cycle + 2.5 * _knots(rng, t, rng.uniform(150.0, 500.0))


PROTOCOLS: dict[str, Callable[[np.random.Generator, Array], Array]] = {
    f.__name__: f for f in (perlin, ramp_hold, cyclic, staircase, multisine)
}
