"""Drift of ln R over a recording: of the whole resistance, or of the contacts, less where they are tight."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from worlds_fourth.operators import lowpass
from worlds_fourth.randoms import Rng
from worlds_fourth.signals import Array

PLACES = ("all", "contacts")


def walk(rng: Rng, time_s: Array, height: float) -> Array:
    """A random walk without corners; `height` is about its spread after four minutes."""
    steps = rng.normal(size=len(time_s)) * np.sqrt(np.gradient(time_s)) / math.sqrt(60.0)
    return lowpass(np.cumsum(steps) * height * 0.5, time_s, 1.5)


def logarithmic(rng: Rng, time_s: Array, height: float) -> Array:
    """The same in every decade of time, up or down."""
    sign, onset_s = rng.choice([-1, 1]), rng.uniform(5, 60)
    return height * sign * np.log1p(time_s / onset_s) / np.log1p(time_s[-1] / 20)


def exponential(rng: Rng, time_s: Array, height: float) -> Array:
    """Towards an end, up or down."""
    return height * rng.choice([-1, 1]) * (1 - np.exp(-time_s / rng.uniform(20, 200)))


def small(rng: Rng, time_s: Array, height: float) -> Array:
    """Hardly any: a tenth of the others."""
    return height * 0.1 * np.cumsum(rng.normal(size=len(time_s))) / math.sqrt(len(time_s))


DRIFTS: dict[str, Callable[[Rng, Array, float], Array]] = {
    "walk": walk,
    "logarithmic": logarithmic,
    "exponential": exponential,
    "small": small,
}


def drift_of(name: str, place: str, height: float, rng: Rng, time_s: Array, share: Array) -> Array:
    """Drift of ln R over one recording, shape (n,).

    Parameters
    ----------
    name, place : str
        One of `DRIFTS` and one of `PLACES`.
    height : float
        In ln R.
    rng : Generator
        Of the recording.
    time_s, share : ndarray, shape (n,)
        Time and share of the stroke.
    """
    drift = DRIFTS[name](rng, time_s, height)
    return drift * (np.clip(1.3 - 0.6 * share, 0.3, 2) if place == "contacts" else 1)
