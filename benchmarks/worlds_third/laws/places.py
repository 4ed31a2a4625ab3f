"""What presses the contacts, and what the drift acts on."""

from __future__ import annotations

import numpy as np

from worlds_third.laws.law import Law
from worlds_third.signals import Array


def by_force(force: Array, x: Array) -> Array:
    """The force, friction and all."""
    return force


def by_strain(force: Array, x: Array) -> Array:
    """The strain alone: the contacts do not feel what the force loses."""
    return x


def by_both(force: Array, x: Array, share: float) -> Array:
    """A part of each: the ground knit carries force that the contacts never feel."""
    return share * force + (1.0 - share) * x


def on_all(drift: Array, pressure: Array) -> Array:
    """The whole resistance drifts by one factor."""
    return drift


def on_loose(drift: Array, pressure: Array, share: float) -> Array:
    """Loose contacts settle, tight ones have."""
    return drift * (1.0 - share * np.clip(pressure, 0.0, 1.2))


DRIVES = {"by_force": Law(by_force), "by_strain": Law(by_strain), "by_both": Law(by_both, {"share": (0.3, 0.8)})}
PLACES = {"on_all": Law(on_all), "on_loose": Law(on_loose, {"share": (0.3, 0.9)})}
