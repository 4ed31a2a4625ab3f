"""When samples are taken, and the finer steps between them that the physics is computed at."""

from __future__ import annotations

import numpy as np

from worlds_third.signals import Array

FINEST_HZ = 10.0  # below this rate, the physics takes steps of its own between samples
JITTER = 0.03  # of a step; the paper's rig, of several parts, was not even either


def sample_times(rng: np.random.Generator, minutes: float, rate_hz: float) -> Array:
    """Shape (n,): increasing times in s from 0."""
    count = round(minutes * 60 * rate_hz) + 1
    steps = (1.0 + JITTER * np.clip(rng.normal(size=count - 1), -3, 3)) / rate_hz
    return np.concatenate([[0.0], np.cumsum(steps)])


def steps_between(rate_hz: float) -> int:
    """Steps of the physics for each sample."""
    return max(1, int(np.ceil(FINEST_HZ / rate_hz)))


def refined(time_s: Array, parts: int) -> Array:
    """Times of the physics: `parts` even steps for each step between samples."""
    return np.interp(np.arange((len(time_s) - 1) * parts + 1) / parts, np.arange(len(time_s)), time_s)
