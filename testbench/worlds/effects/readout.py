"""Hidden effects of the instruments: they change what is read and nothing else.

The magnitude of a converter's range is the share of the swing that lies beyond it.
"""

from __future__ import annotations

import numpy as np

from testbench.worlds.chain import Scene, Shape
from testbench.worlds.effects.registry import form
from testbench.worlds.kernels import lowpass


@form("channel_lag", "filtered_resistance", "readout", 3.0)
def lag_filter(s: Scene, a: float, p: Shape) -> None:
    s.ln_g = -np.log(lowpass(s.t, np.exp(-(s.ln_g - s.ln_g[0])), a)) + s.ln_g[0]


@form("channel_lag", "late_resistance", "readout", 3.0)
def lag_delay(s: Scene, a: float, p: Shape) -> None:
    s.ln_g = np.interp(s.t - a, s.t, s.ln_g)


@form("channel_lag", "late_force", "readout", 3.0)
def lag_force(s: Scene, a: float, p: Shape) -> None:
    s.force = np.interp(s.t - a, s.t, s.force)


@form("adc_saturation", "resistance_clipped", "readout", 0.7, side=[0, 1])
def clip_resistance(s: Scene, a: float, p: Shape) -> None:
    low, high = s.usual.ln_g
    cut = a * (high - low)
    s.ln_g = np.minimum(s.ln_g, high - cut) if p["side"] else np.maximum(s.ln_g, low + cut)


@form("adc_saturation", "force_clipped", "readout", 0.7)
def clip_force(s: Scene, a: float, p: Shape) -> None:
    low, high = s.usual.force
    s.force = np.minimum(s.force, high - a * (high - low))


@form("adc_saturation", "amplifier_bends_near_rail", "readout", 1.4, width=(0.005, 0.02))
def amplifier(s: Scene, a: float, p: Shape) -> None:
    low, high = s.usual.ln_g
    swing = high - low
    rail, width = high - 0.5 * a * swing, p["width"] * swing * a / (a + 0.02)
    s.ln_g = s.ln_g - width * np.logaddexp(0, (s.ln_g - rail) / width)


@form("load_cell_creep", "one_time", "readout", 0.5, tau=(100, 600))
def creep_one(s: Scene, a: float, p: Shape) -> None:
    s.force = s.force + a * lowpass(s.t, s.force, p["tau"])


@form("load_cell_creep", "zero_wanders", "readout", 0.3, onset=(5, 60))
def creep_zero(s: Scene, a: float, p: Shape) -> None:
    s.force = s.force + 0.3 * a * s.top_N * np.log1p(s.t / p["onset"])


@form("load_cell_creep", "two_times", "readout", 0.5, fast=(20, 60), slow=(300, 1200))
def creep_two(s: Scene, a: float, p: Shape) -> None:
    loaded = 0.4 * lowpass(s.t, s.force, p["fast"]) + 0.6 * lowpass(s.t, s.force, p["slow"])
    s.force = s.force + a * loaded


@form("periodic_interference", "force_hum", "readout", 0.5, hz=(0.3, 12))
def hum_force(s: Scene, a: float, p: Shape) -> None:
    phase = s.rng().uniform(0, 2 * np.pi)
    s.force = s.force + a * s.top_N * np.sin(2 * np.pi * p["hz"] * s.t + phase)


@form("periodic_interference", "resistance_hum_with_harmonics", "readout", 0.5, hz=(0.1, 4), third=(0.2, 0.5))
def hum_resistance(s: Scene, a: float, p: Shape) -> None:
    angle = 2 * np.pi * p["hz"] * s.t + s.rng().uniform(0, 2 * np.pi)
    s.ln_g = s.ln_g + a * (np.sin(angle) + p["third"] * np.sin(3 * angle))


@form("periodic_interference", "beating_in_both", "readout", 0.5, hz=(0.5, 8), beat_s=(40, 200))
def hum_both(s: Scene, a: float, p: Shape) -> None:
    rng = s.rng()
    beat = 0.6 + 0.4 * np.sin(2 * np.pi * s.t / p["beat_s"] + rng.uniform(0, 6))
    wave = beat * np.sin(2 * np.pi * p["hz"] * s.t + rng.uniform(0, 6))
    s.force = s.force + 0.5 * a * s.top_N * wave
    s.ln_g = s.ln_g + 0.3 * a * wave
