"""What the tester does: strain trajectories like those of a laboratory, seeded."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from gcode.support.arrays import FloatArray

MEAN_SPEED_MM_PER_S = 1.0
TOP_STRAIN = 0.3
GAUGE_LENGTH_MM = 25.0


def gradient_noise(x: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Gradient noise with quintic fading (Perlin, SIGGRAPH 2002): three octaves, each 0.6 of the one before."""
    total = np.zeros_like(x)
    for octave in range(3):
        u = x * 2.0**octave + rng.uniform(0, 1)
        cell = np.floor(u).astype(np.int64)
        slopes = rng.uniform(-1, 1, int(cell[-1]) + 2)
        f = u - cell
        fade = f**3 * (f * (6 * f - 15) + 10)
        left, right = slopes[cell] * f, slopes[cell + 1] * (f - 1)
        total += 0.6**octave * (left + fade * (right - left))
    return total


def _perlin(t: FloatArray, rng: np.random.Generator) -> FloatArray:
    """0-30 % random strain with a mean speed of about 1 mm/s at a 25 mm gauge length."""
    seed = int(rng.integers(2**31))
    frequency = 0.08
    for _ in range(3):
        raw = gradient_noise(t * frequency, np.random.default_rng(seed))
        low, high = np.quantile(raw, [0.01, 0.99])
        strain = TOP_STRAIN * np.clip((raw - low) / (high - low), 0, 1)
        path_mm = np.abs(np.diff(strain)).sum() * GAUGE_LENGTH_MM
        frequency *= MEAN_SPEED_MM_PER_S * t[-1] / path_mm
    # the sensor is mounted at rest
    return np.maximum(strain - strain[0] * np.exp(-t / 2.0), 0.0)


def _through(t: FloatArray, corners: list[float], holds: list[float], speeds: list[float]) -> FloatArray:
    """Straight lines through `corners` at `speeds` [strain/s] with a rest at each, repeated as far as they go."""
    times, strains = [0.0], [0.0]
    for corner, hold, speed in zip(corners, holds, speeds, strict=True):
        times.append(times[-1] + max(abs(corner - strains[-1]) / speed, 0.05))
        strains.append(corner)
        if hold > 0:
            times.append(times[-1] + hold)
            strains.append(corner)
    return np.interp(t, times, strains)


def _many(t: FloatArray) -> int:
    return int(t[-1] / 2) + 4


def _holds(t: FloatArray, rng: np.random.Generator) -> FloatArray:
    n = _many(t)
    corners = rng.uniform(0.02, TOP_STRAIN, n)
    return _through(t, list(corners), list(rng.uniform(10, 60, n)), list(rng.uniform(0.02, 0.12, n)))


def _triangles(t: FloatArray, rng: np.random.Generator) -> FloatArray:
    n = _many(t)
    corners = np.zeros(n)
    corners[::2] = TOP_STRAIN * rng.choice([1 / 3, 2 / 3, 1], n)[::2]
    return _through(t, list(corners), [0.0] * n, list(np.repeat(rng.uniform(0.01, 0.1, n), 2)[:n]))


def _return_to_zero(t: FloatArray, rng: np.random.Generator) -> FloatArray:
    n = _many(t)
    corners = np.zeros(n)
    corners[::2] = rng.uniform(0.05, TOP_STRAIN, n)[::2]
    rests = np.where(np.arange(n) % 2 == 0, 5.0, 20.0) * rng.uniform(0.5, 1.5, n)
    return _through(t, list(corners), list(rests), list(rng.uniform(0.02, 0.1, n)))


def _mix(t: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Thirds of random motion, holds and returns to zero."""
    parts = np.array_split(t, 3)
    pieces = [
        maker(part - part[0], rng) for maker, part in zip((_perlin, _holds, _return_to_zero), parts, strict=True)
    ]
    return _limit_speed(t, np.concatenate(pieces), 0.2)


def _limit_speed(t: FloatArray, strain: FloatArray, most: float) -> FloatArray:
    """Bridge the joints of pieces with straight lines no faster than `most` [strain/s]."""
    out = strain.copy()
    joints = np.flatnonzero(np.abs(np.diff(strain)) > most * 3 * np.diff(t))
    for joint in joints:
        end = np.searchsorted(t, t[joint] + TOP_STRAIN / most)
        end = min(int(end), len(t) - 1)
        out[joint : end + 1] = np.interp(t[joint : end + 1], [t[joint], t[end]], [strain[joint], strain[end]])
    return out


PROTOCOLS: dict[str, Callable[[FloatArray, np.random.Generator], FloatArray]] = {
    "perlin": _perlin,
    "holds": _holds,
    "triangles": _triangles,
    "return_to_zero": _return_to_zero,
    "mix": _mix,
}


def sample_times(minutes: float, rate_hz: float, rng: np.random.Generator, jitter: float = 0.05) -> FloatArray:
    """Instants of a sampling clock whose steps scatter by `jitter` (relative)."""
    count = max(int(minutes * 60 * rate_hz), 2)
    steps = np.clip(1 + jitter * rng.standard_normal(count - 1), 0.3, 3) / rate_hz
    return np.concatenate([[0.0], np.round(np.cumsum(steps), 6)])
