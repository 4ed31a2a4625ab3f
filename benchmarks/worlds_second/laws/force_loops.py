"""Loops of the force that do not depend on the rate, added to the elastic force (both relative to full scale)."""

from __future__ import annotations

import numpy as np

from worlds_second.draws import lin, log
from worlds_second.kernels import Array, bouc_wen, dahl, play_stack
from worlds_second.laws.registry import law

SLIDERS = 14


@law("force_loops", height=log(0.015, 0.1), reach=log(0.03, 0.2), power=lin(0.8, 2.0), roundness=lin(0.5, 0.85))
def bouc_wen_friction(e: Array, elastic: Array, height: float, reach: float, power: float, roundness: float) -> Array:
    """A friction state of Bouc and Wen."""
    return height * bouc_wen(e, power, reach, roundness)


@law("force_loops", height=log(0.02, 0.12), reach=log(0.1, 0.6), skew=lin(-0.6, 1.0))
def iwan(e: Array, elastic: Array, height: float, reach: float, skew: float) -> Array:
    """Springs in parallel, each with a slider that yields at its own strain (Iwan 1966)."""
    yields = reach * (np.arange(SLIDERS) + 0.5) / SLIDERS
    stiffness = yields**skew
    stiffness *= height / np.sum(stiffness * yields)
    return np.sum(stiffness) * e - play_stack(e, yields, stiffness)


@law("force_loops", height=log(0.015, 0.1), reach=log(0.02, 0.15), alpha=lin(0.7, 1.8))
def dahl_friction(e: Array, elastic: Array, height: float, reach: float, alpha: float) -> Array:
    """Bristles that bend before they slide (Dahl)."""
    return height * dahl(e, reach, alpha)


@law("force_loops", height=log(0.03, 0.15), reach=log(0.1, 0.5), bend=lin(0.5, 2.5))
def preisach_plays(e: Array, elastic: Array, height: float, reach: float, bend: float) -> Array:
    """Plays of strain under a bent output curve: the loop widens with strain."""
    radii = reach * (np.arange(SLIDERS) + 0.5) / SLIDERS
    weights = np.exp(-2.0 * radii / reach)
    lagging = play_stack(e, radii, weights / weights.sum())
    return height * (np.expm1(bend * e) - np.expm1(bend * lagging)) / bend / reach


@law("force_loops", friction=log(0.02, 0.15), reach=log(0.03, 0.2))
def capstan(e: Array, elastic: Array, friction: float, reach: float) -> Array:
    """Yarn around yarn: friction multiplies the tension by an exponential (Euler and Eytelwein)."""
    return elastic * np.expm1(friction * dahl(e, reach, 1.0))


@law("force_loops")
def none(e: Array, elastic: Array) -> Array:
    """No loop."""
    return np.zeros_like(e)
