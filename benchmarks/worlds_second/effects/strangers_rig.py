"""Kinds that no catalogue has, in the rig and its read-outs."""

from __future__ import annotations

import numpy as np

from worlds_second.chain import Signals
from worlds_second.draws import lin, log, pick
from worlds_second.effects.kinematics import moments, stairs
from worlds_second.effects.readout import force_span, ln_span
from worlds_second.effects.registry import also, form
from worlds_second.kernels import Array, held_within, ringing, two_ranges

LN, N = "resistance_readout", "force_readout"


@form("dead_band", LN, 0.5, foreign=True)
def held_reading(s: Signals, m: float) -> Array:
    """The meter shows an old value until the new one is far enough away."""
    return held_within(s.ln_read, m * ln_span(s))


@form("sagging_supply", LN, 1.0, foreign=True, period_s=log(15.0, 120.0), share=lin(0.2, 1.0))
def hunting_regulator(s: Signals, m: float, period_s: float, share: float) -> Array:
    """The supply sags and is pulled up again in a saw-tooth; both read-outs are proportional to it."""
    return s.ln_read + np.log1p(-m * _sag(s, period_s))


@also("sagging_supply", "hunting_regulator", N)
def _hunting_force(s: Signals, m: float, period_s: float, share: float) -> Array:
    return s.force_N * (1.0 - share * m * _sag(s, period_s))


def _sag(s: Signals, period_s: float) -> Array:
    phase = s.t / period_s * (1.0 + 0.3 * s.t / s.t[-1])
    return 0.5 * (phase % 1.0) + 0.4 * (phase / 7.3 % 1.0)


@form("crosstalk", LN, 1.0, foreign=True, late_s=lin(0.1, 0.6), share=lin(0.2, 1.0), sign=pick(-1.0, 1.0))
def multiplexer(s: Signals, m: float, late_s: float, share: float, sign: float) -> Array:
    """What the multiplexer showed last rides on what it shows now, both ways."""
    return s.ln_read + sign * m * np.interp(s.t - late_s, s.t, s.f)


@also("crosstalk", "multiplexer", N)
def _multiplexer_force(s: Signals, m: float, late_s: float, share: float, sign: float) -> Array:
    wave = (s.ln_g - s.scales.ln_low) / ln_span(s)
    return s.force_N + sign * share * m * force_span(s) * np.interp(s.t - late_s, s.t, wave)


@form("clock_skew", LN, 0.05, foreign=True, sign=pick(-1.0, 1.0))
def fast_clock(s: Signals, m: float, sign: float) -> Array:
    """The meter's clock is not the rig's: the channels drift apart."""
    return np.interp(s.t * (1.0 + sign * m), s.t, s.ln_read)


@form("loose_wire", LN, 2.0, foreign=True, open_s=log(2.0, 20.0), shut_s=log(10.0, 80.0))
def telegraph(s: Signals, m: float, open_s: float, shut_s: float) -> Array:
    """A crimp switches at random between two resistances."""
    lengths = s.chance.exponential(1.0, int(4 * s.t[-1] / (open_s + shut_s)) + 40)
    lengths[0::2] *= shut_s
    lengths[1::2] *= open_s
    opened = np.searchsorted(np.cumsum(lengths), s.t) % 2
    return s.ln_read - m * opened


@form("range_switching", LN, 1.0, foreign=True, level=lin(0.35, 0.7), band=lin(0.05, 0.2), sign=pick(-1.0, 1.0))
def two_meter_ranges(s: Signals, m: float, level: float, band: float, sign: float) -> Array:
    """An automatic range with another gain, that switches back later than it switched."""
    wave = (s.ln_read - s.scales.ln_low) / ln_span(s)
    return s.ln_read + sign * m * two_ranges(wave, level + band / 2, level - band / 2)


@form("swinging_cell", N, 3.0, foreign=True, frequency_hz=log(0.8, 3.0), damping=log(0.03, 0.2))
def ring(s: Signals, m: float, frequency_hz: float, damping: float) -> Array:
    """A mass on the load cell swings after each abrupt change."""
    return s.force_N + m * (ringing(s.force_N, s.dt, frequency_hz, damping) - s.force_N)


@form("lost_steps", "kinematics", 0.3, foreign=True, mean_s=log(60.0, 240.0))
def motor_slips(s: Signals, m: float, mean_s: float) -> Array:
    """In fast motion the motor loses steps, forwards or backwards, and nobody notices."""
    rate = np.abs(np.diff(s.e, prepend=s.e[0])) / s.dt
    fast = rate > 0.8 * s.scales.rate
    at = moments(s, s.chance, fast, mean_s)
    return s.e + m * stairs(s, at, s.chance.choice([-1.0, 1.0], len(at)))
