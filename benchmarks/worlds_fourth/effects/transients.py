"""Overshoot of the conductance, and its shift with the rate. Sizes are of ln G, or shares of its range."""

from __future__ import annotations

from functools import partial

import numpy as np

from worlds_fourth.effects.effect import Effect, Form, form_of
from worlds_fourth.kernels.friction import dahl
from worlds_fourth.operators import highpass, lowpass
from worlds_fourth.randoms import Rng
from worlds_fourth.signals import Array, State
from worlds_fourth.specimen import Specimen

FORMS: list[Form] = []
_overshoot = partial(form_of, FORMS, "electrical_overshoot")
_rate = partial(form_of, FORMS, "rate_resistance")
FAST = 0.15  # strain a second


@_overshoot()
def with_strain(rng: Rng, specimen: Specimen) -> Effect:
    """Beyond its end with every move, and back within seconds."""
    tau_s, b = rng.uniform(0.5, 3), rng.uniform(0, 0.6)
    range_g, sign = specimen.conduction.range, np.sign(specimen.conduction.change)

    def act(s: State, log_g: Array, size: float) -> Array:
        return log_g + sign * size * range_g * (1 + b * s.share) * highpass(s.share, s.record.time_s, tau_s)

    return Effect(f"a of the range, back in {tau_s:.2f} s", 1.0, {"conductance": act})


@_overshoot()
def made_by_motion(rng: Rng, specimen: Specimen) -> Effect:
    """Motion in either direction makes contacts, that part within seconds."""
    tau_s, n = rng.uniform(0.6, 3), rng.uniform(0.7, 1.3)

    def act(s: State, log_g: Array, size: float) -> Array:
        return log_g + size * lowpass((np.abs(s.rate_per_s) / FAST) ** n, s.record.time_s, tau_s, 0.0)

    return Effect(f"a |rate/0.15|^{n:.2f}, follows in {tau_s:.2f} s", 0.4, {"conductance": act})


@_overshoot()
def at_turns(rng: Rng, specimen: Specimen) -> Effect:
    """A kick at every turn of the motion, that fades within seconds."""
    tau_s, reach = rng.uniform(0.6, 2.5), rng.uniform(0.02, 0.06)
    sign = np.sign(specimen.conduction.change)

    def act(s: State, log_g: Array, size: float) -> Array:
        return log_g + sign * size * highpass(dahl(s.share, reach), s.record.time_s, tau_s)

    return Effect(f"a at turns (over {reach:.3f} of the stroke), gone in {tau_s:.2f} s", 0.4, {"conductance": act})


@_rate()
def power_of_speed(rng: Rng, specimen: Specimen) -> Effect:
    """Lower conductance in motion of either direction."""
    n = rng.uniform(0.8, 1.3)

    def act(s: State, log_g: Array, size: float) -> Array:
        return log_g - size * np.abs(s.rate_per_s / FAST) ** n

    return Effect(f"ln R + a |rate/0.15|^{n:.2f}", 0.5, {"conductance": act})


@_rate()
def signed(rng: Rng, specimen: Specimen) -> Effect:
    """Lower on the way out, higher on the way back, the more so the further out."""
    c = rng.uniform(0.3, 1)

    def act(s: State, log_g: Array, size: float) -> Array:
        return log_g - size * s.rate_per_s / FAST * (1 + c * s.share)

    return Effect(f"ln R + a rate/0.15 (1 + {c:.2f} x)", 0.5, {"conductance": act})


@_rate()
def wiped_contacts(rng: Rng, specimen: Specimen) -> Effect:
    """Sliding wipes the contacts: the logarithm of the speed."""
    slow = rng.uniform(0.005, 0.03)

    def act(s: State, log_g: Array, size: float) -> Array:
        return log_g + size * np.log1p(np.abs(s.rate_per_s) / slow)

    return Effect(f"ln R - a ln(1 + |rate|/{slow:.3f})", 0.2, {"conductance": act})


@_rate()
def on_the_way_out(rng: Rng, specimen: Specimen) -> Effect:
    """Lower on the way out alone."""

    def act(s: State, log_g: Array, size: float) -> Array:
        return log_g - size * np.maximum(s.rate_per_s, 0) / FAST

    return Effect("ln R + a rate/0.15 on the way out", 0.5, {"conductance": act})
