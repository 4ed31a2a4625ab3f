"""A conduction whose ln G rises over strain, falls or bends, as is wanted: drawn again until it does."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from worlds_fourth.laws.conduction import CONDUCTIONS, Law
from worlds_fourth.laws.elasticity import Elasticity
from worlds_fourth.randoms import Rng
from worlds_fourth.signals import Array

COURSES = {"rise": 0.72, "fall": 0.14, "bend": 0.14}  # with their chances
MOST = 4000  # laws drawn
POINTS = 60  # of the curve that is looked at
SMALLEST, LARGEST = 0.3, 1.5  # range of ln G over the stroke
OF_STRAIN_OR_FORCE_ALONE = ("tunnelling", "logistic", "log_mixing", "percolation")


@dataclass(frozen=True)
class Conduction:
    """A law of conduction with its numbers.

    Attributes
    ----------
    name, text : str
        One of `CONDUCTIONS`, and its numbers in words.
    course : str
        ``rise``, ``fall`` or ``bend``.
    strain_share : float
        Of the driver of the contacts: 1 feels the strain alone, 0 the force alone.
    law, length_term : callable, float
        Driver and strain to ln G, and what the longer way of the current takes off it for each strain.
    range, top, middle, change : float
        Of ln G over the stroke: its range, largest value, mean, and last less first value.
    """

    name: str
    text: str
    course: str
    strain_share: float
    law: Law
    length_term: float
    range: float = 0.0
    top: float = 0.0
    middle: float = 0.0
    change: float = 0.0

    def log_g(self, driver: Array, strain: Array) -> Array:
        """ln G of the contacts and of the length."""
        longer = np.log(np.maximum(1 + self.length_term * strain, 0.5))
        return self.law(np.maximum(driver, -0.02), strain) - longer


def draw_conduction(rng: Rng, elasticity: Elasticity, course: str, feels_friction: bool) -> Conduction:
    """Draw laws until one goes the way of `course` and far enough.

    Parameters
    ----------
    rng : Generator
    elasticity : Elasticity
        Of the specimen, for its stroke and its force.
    course : str
        One of `COURSES`.
    feels_friction : bool
        Where the loops of the conductance come from the force alone: half of the driver at least is force.
    """
    strain = np.linspace(0, elasticity.max_strain, POINTS)
    force = elasticity.force_N(strain)
    for _ in range(MOST):
        drawn = _any_law(rng, course, feels_friction)
        w = drawn.strain_share
        curve = drawn.log_g(w * strain / elasticity.max_strain + (1 - w) * force / elasticity.top_N, strain)
        if SMALLEST <= np.ptp(curve) <= LARGEST and _goes(course, curve):
            break
    return replace(
        drawn,
        range=float(np.ptp(curve)),
        top=float(curve.max()),
        middle=float(curve.mean()),
        change=float(curve[-1] - curve[0]),
    )


def _any_law(rng: Rng, course: str, feels_friction: bool) -> Conduction:
    name = str(rng.choice(list(CONDUCTIONS)))
    shares = {
        "holm": rng.uniform(0, 0.3),
        "percolation": rng.uniform(0.5, 1),
        "network": rng.uniform(0, 0.5),
        "any": rng.uniform(0, 1),
    }
    share = shares.get(name, shares["any"])
    if rng.random() < 0.3 and name in OF_STRAIN_OR_FORCE_ALONE:
        share = float(rng.integers(2))
    if feels_friction:
        share = min(share, 0.5)
    length = rng.uniform(0, 4) if rng.random() < 0.45 else 0.0
    sign = -1 if course == "fall" and rng.random() < 0.7 else 1
    law, text = CONDUCTIONS[name](rng, sign)
    text += f", length term {length:.2f}" if length else ""
    return Conduction(name, f"{text}, share of strain {share:.2f}", course, share, law, length)


def _goes(course: str, curve: Array) -> bool:
    steps, change = np.diff(curve), curve[-1] - curve[0]
    back = -0.02 * change / 60 * 10  # allowed in a step
    if course == "rise":
        return bool(change > 0 and steps.min() > back)
    if course == "fall":
        return bool(change < 0 and steps.max() < back)
    least = 0.15 * np.ptp(curve)
    high, low = int(np.argmax(curve)), int(np.argmin(curve))
    ends = curve[0], curve[-1]
    peak = 0 < high < POINTS - 1 and curve[high] - max(ends) > least
    trough = 0 < low < POINTS - 1 and min(ends) - curve[low] > least
    return bool(peak or trough)
