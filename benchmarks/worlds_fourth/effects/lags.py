"""A reading that comes late. Sizes are s."""

from __future__ import annotations

from functools import partial

import numpy as np

from worlds_fourth.effects.effect import READINGS, Effect, Form, form_of
from worlds_fourth.operators import lowpass
from worlds_fourth.randoms import Rng
from worlds_fourth.signals import Array, State
from worlds_fourth.specimen import Specimen

FORMS: list[Form] = []
_lag = partial(form_of, FORMS, "channel_lag")
SHORTEST_S = 1e-4


def _which(rng: Rng) -> str:
    return READINGS[int(rng.integers(2))]


@_lag()
def first_order(rng: Rng, specimen: Specimen) -> Effect:
    """A first-order filter."""
    reading = _which(rng)

    def act(s: State, y: Array, size: float) -> Array:
        return lowpass(y, s.record.time_s, size + SHORTEST_S)

    return Effect(f"first-order filter of a s, {reading}", 0.6, {reading: act})


@_lag()
def delay(rng: Rng, specimen: Specimen) -> Effect:
    """A pure delay."""
    reading = _which(rng)

    def act(s: State, y: Array, size: float) -> Array:
        return np.interp(s.record.time_s - size, s.record.time_s, y)

    return Effect(f"delay of a s, {reading}", 0.5, {reading: act})


@_lag()
def rounded(rng: Rng, specimen: Specimen) -> Effect:
    """Two filters in series, or the mean over the last seconds: turns are rounder, too."""
    reading = _which(rng)
    if rng.random() < 0.5:
        return Effect(f"two filters of a/2 s each, {reading}", 0.7, {reading: _two_filters})
    return Effect(f"mean over a s, {reading}", 1.0, {reading: _mean})


def _two_filters(s: State, y: Array, size: float) -> Array:
    tau_s = size / 2 + SHORTEST_S
    return lowpass(lowpass(y, s.record.time_s, tau_s), s.record.time_s, tau_s)


def _mean(s: State, y: Array, size: float) -> Array:
    t, span = s.record.time_s, size + 1e-3
    area = np.r_[0, np.cumsum(0.5 * (y[1:] + y[:-1]) * np.diff(t))]
    before = y[0] * np.maximum(span - t, 0)
    return np.where(t > 1e-9, (area - np.interp(np.maximum(t - span, 0), t, area) + before) / span, y)
