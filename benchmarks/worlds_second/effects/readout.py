"""What the load cell, the meter and the converters do to both channels."""

from __future__ import annotations

import numpy as np

from worlds_second.chain import Signals
from worlds_second.draws import lin, log, pick
from worlds_second.effects.registry import form
from worlds_second.kernels import Array, lag

LN, N = "resistance_readout", "force_readout"


def force_span(s: Signals) -> float:
    """Range of the force without an effect, in N."""
    return s.scales.force_high_N - s.scales.force_low_N


def ln_span(s: Signals) -> float:
    """Range of ln conductance without an effect."""
    return s.scales.ln_high - s.scales.ln_low


@form("channel_lag", LN, 5.0)
def filtered_resistance(s: Signals, m: float) -> Array:
    """The meter's filter."""
    return lag(s.ln_read, s.dt, m)


@form("channel_lag", LN, 5.0)
def late_resistance(s: Signals, m: float) -> Array:
    """The meter's buffer: the same curve, later."""
    return np.interp(s.t - m, s.t, s.ln_read)


@form("channel_lag", LN, 5.0, order=pick(2.0, 3.0))
def smoothed_resistance(s: Signals, m: float, order: float) -> Array:
    """A filter of higher order."""
    out = s.ln_read
    for _ in range(int(order)):
        out = lag(out, s.dt, m / order)
    return out


@form("channel_lag", N, 5.0)
def filtered_force(s: Signals, m: float) -> Array:
    """The load cell's filter."""
    return lag(s.force_N, s.dt, m)


@form("adc_saturation", "resistance_adc", 0.8)
def conductance_clipped_high(s: Signals, m: float) -> Array:
    """No conductance above one value is shown."""
    return np.minimum(s.ln_read, s.scales.ln_high - m * ln_span(s))


@form("adc_saturation", "resistance_adc", 0.8)
def conductance_clipped_low(s: Signals, m: float) -> Array:
    """No conductance below one value is shown."""
    return np.maximum(s.ln_read, s.scales.ln_low + m * ln_span(s))


@form("adc_saturation", "force_adc", 0.8)
def force_clipped(s: Signals, m: float) -> Array:
    """No force above one value is shown."""
    return np.minimum(s.force_N, s.scales.force_high_N - m * force_span(s))


@form("adc_saturation", LN, 0.8, knee=log(0.01, 0.04))
def conductance_compressed(s: Signals, m: float, knee: float) -> Array:
    """The amplifier flattens out just below its rail."""
    rail, width = s.scales.ln_high - m * ln_span(s), knee * ln_span(s)
    return rail - width * np.logaddexp(0.0, (rail - s.ln_read) / width)


@form("load_cell_creep", N, 0.3, time_s=log(10.0, 300.0), sign=pick(-1.0, 1.0))
def one_creep(s: Signals, m: float, time_s: float, sign: float) -> Array:
    """A share of the reading comes late, or is taken back."""
    return s.force_N + sign * m * lag(s.force_N, s.dt, time_s, start=0.0)


@form("load_cell_creep", N, 0.3, first_s=log(2.0, 15.0), decades=lin(1.2, 2.5), sign=pick(-1.0, 1.0))
def creep_over_decades(s: Signals, m: float, first_s: float, decades: float, sign: float) -> Array:
    """The glue under the gauges creeps ever more slowly."""
    arms = [lag(s.force_N, s.dt, first_s * 10.0 ** (decades * k), start=0.0) for k in np.linspace(0.0, 1.0, 6)]
    return s.force_N + sign * m * np.mean(arms, axis=0)


@form("load_cell_creep", N, 0.3, fast_s=log(3.0, 15.0), slow_s=log(60.0, 400.0), share=lin(0.3, 0.7))
def body_and_glue(s: Signals, m: float, fast_s: float, slow_s: float, share: float) -> Array:
    """The spring body creeps on while the glue relaxes."""
    body, glue = lag(s.force_N, s.dt, slow_s, start=0.0), lag(s.force_N, s.dt, fast_s, start=0.0)
    return s.force_N + m * (share * body - (1.0 - share) * glue)


def _phase(s: Signals, frequency_hz: float, phase: float) -> Array:
    step = float(np.median(s.dt)) * s.motion.every
    seen = min(frequency_hz, 0.4 / step)
    return 2 * np.pi * seen * s.t + phase + s.motion.index


HZ, PHASE = log(0.15, 12.0), lin(0.0, 6.283)


@form("periodic_interference", LN, 2.0, frequency_hz=HZ, phase=PHASE)
def hum(s: Signals, m: float, frequency_hz: float, phase: float) -> Array:
    """A sine on the conductance."""
    return s.ln_read + m * np.sin(_phase(s, frequency_hz, phase))


@form("periodic_interference", LN, 2.0, frequency_hz=log(0.15, 3.0), phase=PHASE, duty=lin(0.2, 0.5))
def switching_load(s: Signals, m: float, frequency_hz: float, phase: float, duty: float) -> Array:
    """A neighbour that switches on and off: rounded rectangles on the conductance."""
    angle = _phase(s, frequency_hz, phase)
    return s.ln_read + m * np.tanh(4.0 * (np.cos(angle) - np.cos(np.pi * duty)))


@form("periodic_interference", N, 2.0, frequency_hz=HZ, phase=PHASE)
def shaken_cell(s: Signals, m: float, frequency_hz: float, phase: float) -> Array:
    """A sine on the force."""
    return s.force_N + m * s.sensor.force_full_N * np.sin(_phase(s, frequency_hz, phase))
