"""Effects of the instruments: of the readings, not of the specimen. Sizes as said by each."""

from __future__ import annotations

from functools import partial

import numpy as np

from worlds_third import kernels
from worlds_third.effects.form import Form, form_of
from worlds_third.signals import Signals

FORMS: list[Form] = []
_resistance = partial(form_of, FORMS, stage="readout", main="conductance")
_force = partial(form_of, FORMS, stage="readout", main="force")
Rng = np.random.Generator


@_resistance("channel_lag", limit=5.0)
def slow_filter(s: Signals, size: float, rng: Rng) -> None:
    """A first-order filter; `size` is its time in s."""
    s.log_g = kernels.follow(s.log_g, s.step_s, size + 1e-9, size + 1e-9, s.log_g[0])


@_resistance("channel_lag", limit=5.0)
def late_samples(s: Signals, size: float, rng: Rng) -> None:
    """A pure delay of `size` s."""
    s.log_g = np.interp(s.time_s - size, s.time_s, s.log_g)


@_force("channel_lag", limit=5.0)
def averaged_force(s: Signals, size: float, rng: Rng) -> None:
    """The mean over the last `size` s."""
    area = np.concatenate([[0.0], np.cumsum(0.5 * (s.force[1:] + s.force[:-1]) * s.step_s[1:])])
    start = np.maximum(s.time_s - size, 0.0)
    span = s.time_s - start
    mean = (area - np.interp(start, s.time_s, area)) / np.maximum(span, 1e-9)
    s.force = np.where(span > 1e-6, mean, s.force)


@_resistance("adc_saturation", limit=0.9)
def clipped_low_resistance(s: Signals, size: float, rng: Rng) -> None:
    """No reading beyond a level: `size` is the share of the range of ln G that is cut off at its top."""
    _, low, top = s.tops
    s.log_g = np.minimum(s.log_g, top - (size - 0.02) * (top - low))


@_resistance("adc_saturation", limit=0.9)
def clipped_high_resistance(s: Signals, size: float, rng: Rng) -> None:
    """The same at the other end, where the resistance is highest."""
    _, low, top = s.tops
    s.log_g = np.maximum(s.log_g, low + (size - 0.02) * (top - low))


@_force("adc_saturation", limit=0.9)
def clipped_force(s: Signals, size: float, rng: Rng) -> None:
    """The amplifier of the load cell ends `size` below the largest force."""
    s.force = np.minimum(s.force, s.tops[0] * (1.02 - size))


@_force("load_cell_creep", limit=0.3, tau_s=(5.0, 120.0), sign=(-1.0, 2.0))
def one_glue_line(s: Signals, size: float, rng: Rng, tau_s: float, sign: float) -> None:
    """The glue of the strain gauges creeps: a share of the load comes late."""
    late = kernels.follow(s.force, s.step_s, tau_s, tau_s, s.force[0])
    s.force = s.force + (1.0 if sign > 0 else -1.0) * size * late


@_force("load_cell_creep", limit=0.3, onset_s=(0.5, 5.0))
def decades_of_creep(s: Signals, size: float, rng: Rng, onset_s: float) -> None:
    """The same for every decade of time."""
    taus = onset_s * 4.0 ** np.arange(4)
    s.force = s.force + size * np.mean([kernels.follow(s.force, s.step_s, t, t, 0.0) for t in taus], axis=0)


@_resistance("periodic_interference", limit=2.0, hertz=(0.05, 0.3))
def hum(s: Signals, size: float, rng: Rng, hertz: float) -> None:
    """A sine; `hertz` is over the sampling rate."""
    s.log_g = s.log_g + size * np.sin(2 * np.pi * (hertz * s.rate_hz * s.time_s + rng.uniform()))


@_resistance("periodic_interference", limit=2.0, hertz=(0.02, 0.1), second=(0.2, 0.8), third=(0.1, 0.6))
def motor_hum(s: Signals, size: float, rng: Rng, hertz: float, second: float, third: float) -> None:
    """A wave of three harmonics."""
    angle = 2 * np.pi * (hertz * s.rate_hz * s.time_s + rng.uniform())
    s.log_g = s.log_g + size * (np.sin(angle) + second * np.sin(2 * angle + 1.0) + third * np.sin(3 * angle + 2.0))


@_force("periodic_interference", limit=2.0, hertz=(0.05, 0.3))
def shaking_table(s: Signals, size: float, rng: Rng, hertz: float) -> None:
    """A machine next door shakes the load cell."""
    s.force = s.force + size * np.sin(2 * np.pi * (hertz * s.rate_hz * s.time_s + rng.uniform()))
