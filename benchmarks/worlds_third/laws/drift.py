"""Drift of ln G since the clamps were closed: 0 at the start, of a height of about 1 at its end.

A room whose temperature wanders is no base law here: it is the mechanism ``temperature_drift``, and a sensor with
nothing hidden must not have it.
"""

from __future__ import annotations

import numpy as np

from worlds_third import kernels
from worlds_third.laws.law import Law
from worlds_third.signals import Array

FULL_S = 1400.0  # drifts are scaled to 1 at the length of the paper's recordings


def logarithmic(x: Array, step_s: Array, onset_s: float) -> Array:
    """The same for every decade of time."""
    return np.log1p(np.cumsum(step_s) / onset_s) / np.log1p(FULL_S / onset_s)


def power(x: Array, step_s: Array, onset_s: float, exponent: float) -> Array:
    """On and on, as a power of time."""
    return ((1.0 + np.cumsum(step_s) / onset_s) ** exponent - 1.0) / ((1.0 + FULL_S / onset_s) ** exponent - 1.0)


def stirred(x: Array, step_s: Array, rest_s: float, strokes: float) -> Array:
    """Settles to an end, by waiting and by being moved: every stroke helps."""
    moved = np.abs(np.diff(x, prepend=x[0]))
    return kernels.approach(step_s / rest_s + moved / strokes)


def stretched(x: Array, step_s: Array, scale_s: float, exponent: float) -> Array:
    """Kohlrausch: a spread of settling times."""
    return 1.0 - np.exp(-((np.cumsum(step_s) / scale_s) ** exponent))


def none(x: Array, step_s: Array) -> Array:
    """A settled sensor."""
    return np.zeros_like(x)


DRIFT = {
    "logarithmic": Law(logarithmic, {"onset_s": (2.0, 60.0)}),
    "power": Law(power, {"onset_s": (5.0, 60.0), "exponent": (0.1, 0.5)}),
    "stirred": Law(stirred, {"rest_s": (100.0, 1500.0), "strokes": (20.0, 200.0)}),
    "stretched": Law(stretched, {"scale_s": (50.0, 600.0), "exponent": (0.4, 0.9)}),
    "none": Law(none),
}
