"""Hidden effects that stand in no catalogue: a diagnosis should say `unknown`, not name a neighbour."""

from __future__ import annotations

import numpy as np

from testbench.worlds.chain import Scene, Shape
from testbench.worlds.effects.registry import form
from testbench.worlds.kernels import lowpass, oscillator, relay, seconds_near


@form("force_crosstalk", "square_of_force_rate", "readout", 3.0, unknown=True, tau=(0.2, 1))
def crosstalk(s: Scene, a: float, p: Shape) -> None:
    """The amplifier's supply sags with the square of the force rate and lifts the reading of conductance."""
    rate = np.gradient(lowpass(s.t, s.force, p["tau"]), s.t) / s.top_N
    s.ln_g = s.ln_g + a * np.minimum((rate / 0.15) ** 2, 9)


@form("dwell_memory", "prefers_where_it_was", "electrical", 3.0, unknown=True, memory=(60, 300), width=(0.02, 0.06))
def dwell_memory(s: Scene, a: float, p: Shape) -> None:
    """Contacts bed in where the sensor has dwelt: conductance peaks near the mean position of the last minutes."""
    home = lowpass(s.t, s.e, p["memory"])
    s.ln_g = s.ln_g + a * np.exp(-0.5 * ((s.e - home) / p["width"]) ** 2)


@form("resonance", "moving_clamp_rings", "mechanics", 3.0, unknown=True, hz=(0.4, 2.0), damping=(0.02, 0.15))
def resonance(s: Scene, a: float, p: Shape) -> None:
    ringing = oscillator(s.t, s.e, p["hz"], p["damping"]) - s.e
    s.force = s.force + 3 * a * s.top_N * ringing / 0.3


@form("threshold_switch", "second_path_closes", "electrical", 2.0, unknown=True, middle=(0.1, 0.2), gap=(0.03, 0.08))
def threshold_switch(s: Scene, a: float, p: Shape) -> None:
    closed = relay(s.e, p["middle"] - p["gap"], p["middle"] + p["gap"], 0.0)
    s.ln_g = s.ln_g + a * lowpass(s.t, closed, 0.3)


@form("threshold_switch", "loops_snap_through", "mechanics", 1.0, unknown=True, middle=(0.1, 0.2), gap=(0.03, 0.08))
def snap_through(s: Scene, a: float, p: Shape) -> None:
    snapped = relay(s.e, p["middle"] - p["gap"], p["middle"] + p["gap"], 0.0)
    s.force = s.force - a * s.top_N * lowpass(s.t, snapped, 0.2)


@form("electrode_detachment", "bursts", "electrical", 3.0, unknown=True, every_s=(40, 150), lasts_s=(2, 12))
def detachment(s: Scene, a: float, p: Shape) -> None:
    rng = s.rng()
    open_now = np.zeros_like(s.t)
    start = 0.0
    while (start := start + rng.exponential(p["every_s"])) < s.t[-1]:
        length = rng.exponential(p["lasts_s"])
        open_now[(s.t >= start) & (s.t < start + length)] = rng.uniform(0.4, 1)
        start += length
    s.ln_g = s.ln_g - a * open_now


@form("stitch_slip", "courses_slip_one_by_one", "mechanics", 1.0, unknown=True, period=(0.02, 0.05))
def stitch_slip(s: Scene, a: float, p: Shape) -> None:
    """Courses slip one after another, farther apart the more the knit is stretched, and only on the way out."""
    outward = lowpass(s.t, (s.rate() > 0.002).astype(float), 0.3)
    phase = 2 * np.pi * np.log1p(4 * np.maximum(s.e, 0)) / (4 * p["period"])
    s.force = s.force + 0.5 * a * s.top_N * outward * np.sin(phase) * np.clip(s.e / 0.1, 0, 1)


@form("gauge_factor_fades", "with_time", "electrical", 2.0, unknown=True, tau=(200, 1500))
def gauge_factor_fades(s: Scene, a: float, p: Shape) -> None:
    """Sensitivity to strain fades with time while the resting value stays: wear of the contacts that move."""
    s.ln_g = s.ln_g + a * (s.e / 0.3) * np.expm1(-s.t / p["tau"])


@form("curl_flip", "edges_unroll_after_rest", "electrical", 2.0, unknown=True, width=(0.01, 0.03), patience=(0.5, 3))
def curl_flip(s: Scene, a: float, p: Shape) -> None:
    """The longer a position is kept, the more the edges curl; the next move unrolls them at once."""
    kept = seconds_near(s.t, s.e, p["width"])
    s.ln_g = s.ln_g + a * lowpass(s.t, np.tanh(kept / p["patience"]), 0.2)
