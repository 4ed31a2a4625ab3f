"""Loops of the conductance: of the contacts' own, or those that the friction of the force makes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from worlds_fourth.kernels.friction import dahl, plays
from worlds_fourth.kernels.preisach import everett, preisach
from worlds_fourth.randoms import Rng
from worlds_fourth.signals import Array

Change = Callable[[Array], Array]
PLAYS = 8


@dataclass(frozen=True)
class ContactLoops:
    """Loops of the contacts.

    Attributes
    ----------
    name : str
        One of `CONTACT_LOOPS`.
    friction_felt : float
        What the contacts feel of the friction, over what the load cell reads of it.
    on_driver, on_log_g : callable, optional
        Driver to the driver with its loops; share of the stroke to what is added to ln G.
    """

    name: str
    friction_felt: float
    on_driver: Change | None = None
    on_log_g: Change | None = None


def of_plays(rng: Rng) -> Change:
    """Part of the driver is followed by plays (Prandtl and Ishlinskii)."""
    widths = np.linspace(0.01, rng.uniform(0.12, 0.3), PLAYS)
    weights = np.ones(PLAYS) / PLAYS * rng.uniform(0.3, 0.7)
    return lambda driver: (1 - weights.sum()) * driver + plays(driver, widths, weights)


def of_direction(rng: Rng, height: float) -> Change:
    """One curve out and another back, wider towards one end (a Duhem model)."""
    reach, sign = rng.uniform(0.03, 0.15), rng.choice([-1, 1], p=[0.7, 0.3])
    skew = rng.uniform(-0.5, 0.5)
    return lambda x: sign * height * dahl(x, reach) * np.clip(1 + skew * (2 * x - 1), 0.2, 2)


def of_relays(rng: Rng, height: float) -> Change:
    """Preisach's relays, less the mean of the two ways."""
    p, q, sign = rng.uniform(1.4, 2.1), rng.uniform(-0.6, 1.2), rng.choice([-1, 1], p=[0.3, 0.7])
    full = everett(1.0, 0.0, p, q)

    def change(x: Array) -> Array:
        mean = 0.5 * (x**p * (1 + q * x / 2) + full - np.maximum(1 - x, 0) ** p * (1 + q * (1 + x) / 2))
        return sign * 4 * height / full * (preisach(x, p, q) - mean)

    return change


CONTACT_LOOPS = ("plays", "direction", "relays", "force")


def draw_contact_loops(rng: Rng, name: str, log_g_range: float) -> ContactLoops:
    """Draw the numbers of one of `CONTACT_LOOPS`, for a conductance of this range of ln G."""
    felt = rng.uniform(1.6, 3.0) if name == "force" else rng.uniform(0.8, 1.2)
    height = rng.uniform(0.03, 0.12) * log_g_range
    if name == "plays":
        return ContactLoops(name, felt, on_driver=of_plays(rng))
    if name == "direction":
        return ContactLoops(name, felt, on_log_g=of_direction(rng, height))
    return ContactLoops(name, felt, on_log_g=of_relays(rng, height) if name == "relays" else None)
