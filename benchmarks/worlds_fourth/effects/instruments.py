"""Saturation of a reading, creep of the load cell, and interference. Sizes as said by each."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from worlds_fourth.effects.effect import Effect, Form, form_of
from worlds_fourth.operators import lowpass, softplus
from worlds_fourth.randoms import Rng
from worlds_fourth.signals import Array, Hook, State
from worlds_fourth.specimen import Specimen

FORMS: list[Form] = []
_saturation = partial(form_of, FORMS, "adc_saturation")
_creep = partial(form_of, FORMS, "load_cell_creep")
_interference = partial(form_of, FORMS, "periodic_interference")
FORCE_N, LOG_R = 0.1, 0.08  # amplitude of the interference at size 1


def _clip(text: str, reading: str, act: Hook) -> Effect:
    return Effect(text, 0.6, {reading: act}, clips=reading)


@_saturation()
def force_top(rng: Rng, specimen: Specimen) -> Effect:
    """The force is cut off; `size` is the share of its range that is."""
    low, high = specimen.force_range_N
    text = "the force is cut off at the top - a of its range"
    return _clip(text, "force_reading", lambda s, y, size: np.minimum(y, high - size * (high - low)))


@_saturation()
def resistance_top(rng: Rng, specimen: Specimen) -> Effect:
    """The same of the highest resistance."""
    low, high = specimen.log_r_range
    text = "ln R is cut off at the top - a of its range"
    return _clip(text, "resistance_reading", lambda s, y, size: np.minimum(y, high - size * (high - low)))


@_saturation()
def resistance_bottom(rng: Rng, specimen: Specimen) -> Effect:
    """The same of the lowest resistance."""
    low, high = specimen.log_r_range
    text = "ln R is cut off at the bottom + a of its range"
    return _clip(text, "resistance_reading", lambda s, y, size: np.maximum(y, low + size * (high - low)))


@_saturation()
def soft_force_top(rng: Rng, specimen: Specimen) -> Effect:
    """The amplifier of the force goes softly towards its end."""
    low, high = specimen.force_range_N
    width = rng.uniform(0.005, 0.02) * (high - low)

    def act(s: State, y: Array, size: float) -> Array:
        return y - width * softplus((y - (high - size * (high - low))) / width)

    return Effect(
        f"the force bends over within {width:.3f} N at the top - a of its range", 0.6, {"force_reading": act}
    )


@_creep()
def one_time(rng: Rng, specimen: Specimen) -> Effect:
    """A share of the force comes late."""
    tau_s = rng.uniform(8, 60)

    def act(s: State, y: Array, size: float) -> Array:
        return y + size * lowpass(y - y[0], s.record.time_s, tau_s)

    return Effect(f"a of the force, late by {tau_s:.0f} s", 0.1, {"force_reading": act})


@_creep()
def many_times(rng: Rng, specimen: Specimen) -> Effect:
    """The same in every decade of time."""
    taus_s = np.exp(np.linspace(np.log(2), np.log(rng.uniform(150, 500)), 5))

    def act(s: State, y: Array, size: float) -> Array:
        return y + size * sum(lowpass(y - y[0], s.record.time_s, tau) for tau in taus_s) / 5

    return Effect(f"a of the force, from 2 to {taus_s[-1]:.0f} s", 0.12, {"force_reading": act})


@_creep()
def of_the_backing(rng: Rng, specimen: Specimen) -> Effect:
    """The gauge slides on its backing: the reading sinks, in two times."""
    fast_s, slow_s, share = rng.uniform(3, 10), rng.uniform(60, 200), rng.uniform(0.3, 0.8)

    def act(s: State, y: Array, size: float) -> Array:
        fast, slow = (lowpass(y - y[0], s.record.time_s, tau) for tau in (fast_s, slow_s))
        return y - size * (share * fast + (1 - share) * slow)

    return Effect(
        f"-a of the force, {share:.2f} in {fast_s:.0f} s, the rest in {slow_s:.0f} s", 0.1, {"force_reading": act}
    )


class _Pickup:
    """Which readings pick the interference up, and its frequency and phase."""

    def __init__(self, rng: Rng) -> None:
        self.both = rng.random() < 0.4
        self.ratio = rng.uniform(0.3, 1.0) if self.both else 0.0
        self.hertz = float(np.exp(rng.uniform(np.log(0.3), np.log(18))))
        self.phase = rng.uniform(0, 6.28)
        self.force_first = rng.random() < 0.5

    def effect(self, text: str, wave: Callable[[Array], Array]) -> Effect:
        """Amplitude `size` in the first reading, less in the other; `wave` is over time."""
        hooks: dict[str, Hook] = {}
        if self.both or self.force_first:
            force_N = 1 if self.force_first else self.ratio
            hooks["force_reading"] = lambda s, y, size: y + FORCE_N * size * force_N * wave(s.record.time_s)
        if self.both or not self.force_first:
            share = self.ratio if self.force_first else 1
            hooks["resistance_reading"] = lambda s, y, size: y + LOG_R * size * share * wave(s.record.time_s)
        return Effect(f"{text}, a in 0.1 N and 0.08 of ln R, {' and '.join(hooks)}", 4.0, hooks)


@_interference()
def tone(rng: Rng, specimen: Specimen) -> Effect:
    """A sine."""
    p = _Pickup(rng)
    return p.effect(f"{p.hertz:.2f} Hz", lambda t: np.sin(2 * np.pi * p.hertz * t + p.phase))


@_interference()
def mains(rng: Rng, specimen: Specimen) -> Effect:
    """Hum of the mains, far above the sampling rate: uneven sampling folds it."""
    p = _Pickup(rng)
    hertz = float(rng.choice([50.0, 60.0, 100.0])) + rng.uniform(-0.05, 0.05)
    return p.effect(f"{hertz:.2f} Hz", lambda t: np.sin(2 * np.pi * hertz * t + p.phase))


@_interference()
def compressor(rng: Rng, specimen: Specimen) -> Effect:
    """A machine that goes on and off."""
    p = _Pickup(rng)
    period_s, part, rise_s = rng.uniform(3, 25), rng.uniform(0.3, 0.6), rng.uniform(0.05, 0.4)

    def wave(t: Array) -> Array:
        on = (t + p.phase * period_s / 6.28) % period_s < part * period_s
        return lowpass(on * 2.0 - 1, t, rise_s)

    return p.effect(f"on and off every {period_s:.1f} s", wave)


@_interference()
def beating_tone(rng: Rng, specimen: Specimen) -> Effect:
    """A sine that swells and fades."""
    p = _Pickup(rng)
    beat = rng.uniform(0.02, 0.1)

    def wave(t: Array) -> Array:
        return np.sin(2 * np.pi * p.hertz * t + p.phase) * (0.6 + 0.4 * np.sin(2 * np.pi * beat * t))

    return p.effect(f"{p.hertz:.2f} Hz, beating with {beat:.3f} Hz", wave)
