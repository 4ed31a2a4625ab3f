"""Kinds that no catalogue has, in the fabric and its contacts."""

from __future__ import annotations

import numpy as np

from worlds_second.chain import Signals
from worlds_second.draws import lin, log, pick
from worlds_second.effects.kinematics import above, moments, stairs
from worlds_second.effects.mechanics import SMALLEST_SWING
from worlds_second.effects.registry import also, form
from worlds_second.kernels import Array, bouc_wen, breakaway, kinetics, turns

SIGN = pick(-1.0, 1.0)


@form("stick_slip", "mechanics", 1.0, foreign=True, grip=log(0.02, 0.08))
def sawtooth(s: Signals, m: float, grip: float) -> Array:
    """Yarns stick, and let go all at once: teeth of the force with travel."""
    return s.f + m * breakaway(s.e, grip) / grip


@form(
    "snapping_yarns", "mechanics", 0.5, foreign=True, edge=lin(0.5, 0.7), mean_s=log(15.0, 90.0), share=lin(0.3, 2.0)
)
def snaps(s: Signals, m: float, edge: float, mean_s: float, share: float) -> Array:
    """Single yarns snap at high strain; each takes a share of the force of long stretches with it."""
    return s.f * np.exp(-m * _snapped(s, edge, mean_s) * s.e)


@also("snapping_yarns", "snaps", "electrical")
def _snaps_electrical(s: Signals, m: float, edge: float, mean_s: float, share: float) -> Array:
    return s.ln_g - share * m * _snapped(s, edge, mean_s)


def _snapped(s: Signals, edge: float, mean_s: float) -> Array:
    """How many have snapped, the same for both channels."""
    rng = np.random.default_rng([int(1e6 * edge), s.motion.index])
    at = moments(s, rng, s.e > edge, mean_s)
    return stairs(s, at, np.ones(len(at)))


@form(
    "strain_dependent_recovery", "mechanics", 1.0, foreign=True, fast_s=log(1.0, 10.0), slow_s=log(10.0, 100.0),
    edge=lin(0.1, 0.35), share=lin(0.3, 2.0), sign=SIGN,
)  # fmt: skip
def heals_when_short(
    s: Signals, m: float, fast_s: float, slow_s: float, edge: float, share: float, sign: float
) -> Array:
    """Softness gathers at high strain and goes away only near rest."""
    return s.f * (1.0 - m * _gathered(s, fast_s, slow_s, edge))


@also("strain_dependent_recovery", "heals_when_short", "electrical")
def _heals_electrical(
    s: Signals, m: float, fast_s: float, slow_s: float, edge: float, share: float, sign: float
) -> Array:
    return s.ln_g + sign * share * m * _gathered(s, fast_s, slow_s, edge)


def _gathered(s: Signals, fast_s: float, slow_s: float, edge: float) -> Array:
    return kinetics(above(s.e, 0.6) * 2.5 / slow_s, (s.e < edge) / fast_s, s.dt)


@form(
    "network_break_and_heal", "electrical", 3.0, foreign=True,
    break_s=log(0.3, 3.0), heal_s=log(8.0, 80.0), edge=lin(0.45, 0.75),
)  # fmt: skip
def percolating(s: Signals, m: float, break_s: float, heal_s: float, edge: float) -> Array:
    """Bridges break within seconds at high strain and grow again over minutes."""
    broken = kinetics(10.0 * above(s.e, edge) ** 2 / break_s, np.full(len(s.e), 1.0 / heal_s), s.dt)
    return s.ln_g - m * broken


@form("fading_gauge_loop", "electrical", 2.0, foreign=True, reach=log(0.1, 0.4), fade_s=log(100.0, 500.0), sign=SIGN)
def fading(s: Signals, m: float, reach: float, fade_s: float, sign: float) -> Array:
    """A loop of the conductance over strain that fades with the minutes."""
    return s.ln_g + sign * m * s.e * bouc_wen(s.e, 1.0, reach, 0.6) * np.exp(-s.t / fade_s)


@form("localising_strain", "electrical", 2.0, foreign=True, edge=lin(0.3, 0.6), time_s=log(20.0, 150.0), sign=SIGN)
def necking(s: Signals, m: float, edge: float, time_s: float, sign: float) -> Array:
    """Strain gathers in one zone with time at high strain and evens out with each turn."""
    gain = above(s.e, edge) * 4.0 / time_s
    turned = np.diff(turns(s.e, SMALLEST_SWING)[0], prepend=0.0) / s.dt
    gathered = kinetics(gain, turned, s.dt)
    return s.ln_g + sign * m * gathered * s.e**2


@form("turn_memory", "mechanics", 1.0, foreign=True, width=log(0.02, 0.06), sign=SIGN)
def bump_at_last_top(s: Signals, m: float, width: float, sign: float) -> Array:
    """A bump of the force where the last upper turn was."""
    top = turns(s.e, SMALLEST_SWING)[1]
    return s.f + sign * m * np.exp(-0.5 * ((s.e - 0.93 * top) / width) ** 2)


@form("moisture_bursts", "electrical", 1.0, foreign=True, mean_s=log(60.0, 200.0), fade_s=log(8.0, 50.0))
def breaths(s: Signals, m: float, mean_s: float, fade_s: float) -> Array:
    """Now and then moisture arrives within a second and dries off."""
    out = np.zeros(len(s.t))
    for at in moments(s, s.chance, s.t > 0.0, mean_s):
        age = s.t[at:] - s.t[at : at + 1]
        out[at:] += s.chance.exponential(1.0) * np.exp(-age / fade_s) * -np.expm1(-age / 0.7)
    return s.ln_g + m * out
