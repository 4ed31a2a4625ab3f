"""Backlash and ripple of the drive: the crosshead is not where the encoder says. Sizes are mm."""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from worlds_fourth.effects.effect import Effect, Form, form_of
from worlds_fourth.kernels import friction
from worlds_fourth.operators import play
from worlds_fourth.randoms import Rng
from worlds_fourth.signals import GAUGE_LENGTH_MM, Array, State
from worlds_fourth.specimen import Specimen

FORMS: list[Form] = []
_backlash = partial(form_of, FORMS, "actuator_backlash")
_ripple = partial(form_of, FORMS, "leadscrew_ripple")
PITCHES_MM = (1.0, 2.0, 2.5, 4.0, 5.0)


@_backlash()
def dead_nut(rng: Rng, specimen: Specimen) -> Effect:
    """A nut with play: nothing follows until the gap is crossed."""
    return Effect("play of half-width a mm", 0.5, {"displacement": lambda s, u, size: play(u, size, 0.0)})


@_backlash()
def soft_play(rng: Rng, specimen: Specimen) -> Effect:
    """Lost motion that builds up over a short way."""
    reach = rng.uniform(0.1, 0.4)

    def act(s: State, u: Array, size: float) -> Array:
        return u - size * friction.dahl(u, reach)

    return Effect(f"a mm of lost motion, built up over {reach:.2f} mm", 0.5, {"displacement": act})


@_backlash()
def play_under_load(rng: Rng, specimen: Specimen) -> Effect:
    """A gap that the load closes."""
    half_N = specimen.top_N * rng.uniform(0.2, 0.6)

    def act(s: State, u: Array, size: float) -> Array:
        gap = size / (1 + specimen.elasticity.force_N(u / GAUGE_LENGTH_MM) / half_N)
        return friction.play(u, gap, 0.0)

    return Effect(f"play of half-width a/(1 + F/{half_N:.2f} N) mm", 0.7, {"displacement": act})


def _screw(rng: Rng) -> tuple[float, float, float]:
    """Pitch in mm and two phases."""
    pitch = float(rng.choice(PITCHES_MM))
    first, second = rng.uniform(0, 6.28, 2)
    return pitch, first, second


@_ripple()
def bent_screw(rng: Rng, specimen: Specimen) -> Effect:
    """A sine of the pitch."""
    pitch, phase, _ = _screw(rng)

    def act(s: State, u: Array, size: float) -> Array:
        return u + size * (np.sin(2 * np.pi * u / pitch + phase) - math.sin(phase))

    return Effect(f"a mm, once in {pitch:g} mm", 0.12, {"displacement": act})


@_ripple()
def worn_screw(rng: Rng, specimen: Specimen) -> Effect:
    """Two harmonics, more here than there along the screw."""
    pitch, first, second = _screw(rng)
    share, uneven, wave = rng.uniform(0.2, 0.5), rng.uniform(0.2, 0.6), rng.uniform(8, 20)

    def ripple(u: Array) -> Array:
        harmonics = np.sin(2 * np.pi * u / pitch + first) + share * np.sin(4 * np.pi * u / pitch + second)
        return (1 + uneven * np.cos(2 * np.pi * u / wave + second)) * harmonics

    text = f"a mm, once and twice ({share:.2f}) in {pitch:g} mm, uneven along the screw"
    return Effect(text, 0.12, {"displacement": lambda s, u, size: u + size * (ripple(u) - ripple(np.array(0.0)))})


@_ripple()
def cogging(rng: Rng, specimen: Specimen) -> Effect:
    """Teeth of a motor that are not even, and every fourth differs."""
    _, phase, second = _screw(rng)
    pitch, skew = rng.uniform(0.8, 1.6), rng.uniform(0.1, 0.3)

    def ripple(u: Array) -> Array:
        q = 2 * np.pi * u / pitch + phase
        return np.sin(q + skew * np.sin(q)) + 0.3 * np.sin(q * 0.25 + second)

    text = f"a mm, once in {pitch:.2f} mm, skewed, and once in four times as much"
    return Effect(text, 0.12, {"displacement": lambda s, u, size: u + size * (ripple(u) - ripple(np.array(0.0)))})
