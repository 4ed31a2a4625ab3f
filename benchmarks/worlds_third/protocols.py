"""Motions of the carriage over the stroke: 0 to 1 over time, starting at 0."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from worlds_third.signals import Array

Protocol = Callable[[Array, np.random.Generator, float], Array]
START_S = 3.0  # the carriage leaves its start gently


def noise_motion(t: Array, rng: np.random.Generator, stroke_s: float) -> Array:
    """Perlin's noise: smooth slopes through zeros at lattice points, three octaves."""
    total = np.zeros_like(t)
    for octave in range(3):
        place = t * 2.0**octave / stroke_s + rng.uniform(0, 1)
        slopes = rng.normal(size=int(place[-1]) + 3)
        cell = place.astype(int)
        s = place - cell
        fade = s**3 * (s * (6 * s - 15) + 10)
        total += 0.5**octave * ((1 - fade) * slopes[cell] * s + fade * slopes[cell + 1] * (s - 1))
    return _gently(t, _spanned(total))


def ramp_hold(t: Array, rng: np.random.Generator, stroke_s: float) -> Array:
    """Ramps of one speed to drawn levels, each held; every third or so goes back to rest."""
    holds = max(t[-1] / 14.0, 0.5 * stroke_s)
    times, levels = [0.0], [0.0]
    while times[-1] < t[-1]:
        target = 0.0 if rng.uniform() < 0.3 and levels[-1] > 0 else float(rng.uniform(0.2, 1.0))
        target = 1.0 if len(levels) == 5 else target
        times += [times[-1] + stroke_s * abs(target - levels[-1]) + 0.05]
        times += [times[-1] + float(rng.uniform(0.4, 1.4)) * holds]
        levels += [target, target]
    return np.interp(t, times, levels)


def cyclic(t: Array, rng: np.random.Generator, stroke_s: float) -> Array:
    """Triangles, in blocks of one height and speed, now and then not back to rest."""
    times, levels = [0.0], [0.0]
    while times[-1] < t[-1]:
        peak = 1.0 if len(levels) == 1 else float(rng.uniform(0.4, 1.0))
        foot, pace = float(rng.choice([0.0, 0.0, 0.25])) * peak, stroke_s * float(rng.uniform(0.6, 1.8))
        for _ in range(int(rng.integers(3, 9))):
            for target in (peak, foot):
                times.append(times[-1] + pace * abs(target - levels[-1]))
                levels.append(target)
    return np.interp(t, times, levels)


def multisine(t: Array, rng: np.random.Generator, stroke_s: float) -> Array:
    """A dozen sines of any phase, evenly over two decades of frequency, slower ones larger."""
    hz = np.geomspace(0.02, 1.0, 12) / stroke_s
    sines = [np.sin(2 * np.pi * (f * t + rng.uniform())) * (0.3 / stroke_s / (f + 0.1 / stroke_s)) ** 0.7 for f in hz]
    return _gently(t, _spanned(np.sum(sines, axis=0)))


def _spanned(y: Array) -> Array:
    """Scaled to 0 to 1 and spread towards both ends, as a carriage that uses its whole stroke."""
    s = (y - y.min()) / (y.max() - y.min())
    return s * s * (3 - 2 * s)


def _gently(t: Array, u: Array) -> Array:
    s = np.clip(t / START_S, 0.0, 1.0)
    return u * s * s * (3 - 2 * s)


PROTOCOLS: dict[str, Protocol] = {
    "perlin": noise_motion,
    "ramp_hold": ramp_hold,
    "cyclic": cyclic,
    "multisine": multisine,
}
