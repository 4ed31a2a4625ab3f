"""Loops of the resistance that the force does not have: what is added to ln G, of a height of about 1."""

from __future__ import annotations

import numpy as np

from worlds_third import kernels
from worlds_third.laws.law import Law
from worlds_third.signals import Array

CONTACTS = 300  # so many that the step of one is below the noise of a good instrument


def delayed_contact(x: Array, reach: float, lateness: float) -> Array:
    """Contacts arrive late, by a distance, and later still where the knit is open."""
    late = x - kernels.trail(x, reach)
    return -late / reach * (1.0 + lateness * (1.0 - x)) * 0.5


def threshold_bank(x: Array, gap: float, spread: float, centre: float) -> Array:
    """Preisach: a bank of contacts that close above one strain and open below a lower one."""
    even = (np.arange(CONTACTS) + 0.5) / CONTACTS
    golden = (np.arange(CONTACTS) * 0.6180339887498949) % 1.0  # spreads gaps evenly over thresholds, with no draw
    closes = centre + spread * np.log(even / (1.0 - even))
    widths = -gap * np.log(1.0 - golden * 0.98)
    closed = kernels.relays(x, closes, closes - widths, np.full(CONTACTS, 1.0 / CONTACTS))
    return closed - 1.0 / (1.0 + np.exp(-(x - centre + 0.5 * gap) / spread))


def unequal_ways(x: Array, reach: float, belly: float) -> Array:
    """One curve out and another back, widest where `belly` says, closed at both ends of the stroke."""
    y = np.clip(x, 0.0, 1.0)
    width = y**belly * (1.0 - y) ** 0.8
    peak = (belly / (belly + 0.8)) ** belly * (0.8 / (belly + 0.8)) ** 0.8
    return kernels.direction(x, reach) * (width / peak + 0.2) * 0.5


def none(x: Array) -> Array:
    """No loop but that of the force."""
    return np.zeros_like(x)


LOOPS = {
    "delayed_contact": Law(delayed_contact, {"reach": (0.03, 0.12), "lateness": (0.0, 1.0)}),
    "threshold_bank": Law(threshold_bank, {"gap": (0.08, 0.3), "spread": (0.06, 0.2), "centre": (0.25, 0.7)}),
    "unequal_ways": Law(unequal_ways, {"reach": (0.03, 0.12), "belly": (0.5, 1.5)}),
    "none": Law(none),
}
