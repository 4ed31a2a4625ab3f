"""Loops of ln G at the contacts that do not depend on the rate, beyond those that the force brings along."""

from __future__ import annotations

import numpy as np

from worlds_second.draws import lin, log, pick
from worlds_second.kernels import Array, bouc_wen, play_stack, travel_lag
from worlds_second.laws.registry import law

PLAYS = 12


def _lagging(x: Array, reach: float, fall: float) -> Array:
    radii = reach * (np.arange(PLAYS) + 0.5) / PLAYS
    weights = np.exp(-fall * radii / reach)
    return play_stack(x, radii, weights / weights.sum())


@law("resistance_loops", height=log(0.05, 0.4), reach=log(0.05, 0.3), fall=lin(0.0, 3.0), sign=pick(-1.0, 1.0))
def play_force(e: Array, f: Array, height: float, reach: float, fall: float, sign: float) -> Array:
    """Contacts that follow the force with plays."""
    return sign * height * (_lagging(f, reach, fall) - f)


@law("resistance_loops", height=log(0.05, 0.4), reach=log(0.05, 0.3), fall=lin(0.0, 3.0), sign=pick(-1.0, 1.0))
def play_strain(e: Array, f: Array, height: float, reach: float, fall: float, sign: float) -> Array:
    """Contacts that follow the strain with plays."""
    return sign * height * (_lagging(e, reach, fall) - e)


@law(
    "resistance_loops",
    height=log(0.005, 0.05),
    reach=log(0.03, 0.25),
    power=lin(0.8, 2.0),
    roundness=lin(0.5, 0.85),
    sign=pick(-1.0, 1.0),
)
def bouc_wen_strain(
    e: Array, f: Array, height: float, reach: float, power: float, roundness: float, sign: float
) -> Array:
    """Contacts that rub as the loops slide: a friction state of strain."""
    return sign * height * bouc_wen(e, power, reach, roundness)


@law("resistance_loops", height=log(0.05, 0.4), up=log(0.03, 0.15), down=log(0.06, 0.4))
def asymmetric(e: Array, f: Array, height: float, up: float, down: float) -> Array:
    """Contacts that close over a short travel and open over a long one."""
    return height * (travel_lag(e, up, down) - e)


@law("resistance_loops")
def none(e: Array, f: Array) -> Array:
    """No loop."""
    return np.zeros_like(e)
