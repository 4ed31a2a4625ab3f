"""Conductance of contacts and yarn: ln G over the pressure of the contacts (0 to 1) and the strain, 0 at (1, 1)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from worlds_third.laws.law import Law
from worlds_third.signals import Array

END = np.array([1.0])


def _firm(p: Array) -> Array:
    """Pressure that is never negative; rounded over a hundredth, so that a touch has no corner."""
    return 0.5 * (p + np.sqrt(p**2 + 1e-4))


def _from_end(law: Callable[[Array, Array], Array], p: Array, x: Array) -> Array:
    return np.log(law(_firm(p), x)) - np.log(law(_firm(END), END))


def percolation(p: Array, x: Array, exponent: float, above: float) -> Array:
    """Touching clusters: G grows as a power of the distance from a threshold that lies `above` below rest."""
    return _from_end(lambda q, _: (q + above) ** exponent, p, x)


def holm_growing(p: Array, x: Array, spots: float, growth: float, exponent: float, series: float) -> Array:
    """Holm contacts, each with R ~ (force on it)^-1/2, more of them the harder they are pressed, behind yarn."""

    def conductance(q: Array, _: Array) -> Array:
        count = 1.0 + spots * q**growth
        contact = 1.0 / (count * np.sqrt((q + 0.05) / count) ** (2 * exponent))
        return 1.0 / (contact + series / (1.0 + spots))

    return _from_end(conductance, p, x)


def ladder(p: Array, x: Array, bridges: float, leads: float, gauge: float) -> Array:
    """A network of loops: legs in series, lengthened by the stretch, bridged by contacts that press together."""

    def conductance(q: Array, y: Array) -> Array:
        bridge = 1.0 / (0.1 + bridges * q**0.7)
        legs = 1.0 + gauge * y
        return 1.0 / (leads * legs + legs * bridge / (legs + bridge))

    return _from_end(conductance, p, x)


def tunnelling(p: Array, x: Array, decay: float, leak: float) -> Array:
    """Gaps that close: G grows exponentially, beside a leak that is always there."""
    return _from_end(lambda q, _: leak + (np.exp(decay * q) - 1.0) / (np.exp(decay) - 1.0), p, x)


def opening_gaps(p: Array, x: Array, gauge: float, curvature: float) -> Array:
    """A filled coating: the resistance grows with what pulls the filler apart, first evenly, then ever faster."""
    y = np.maximum(p, -0.2)
    return -(np.log1p(gauge * y) + curvature * y**2) + (np.log1p(gauge) + curvature)


CONDUCTANCE = {
    "percolation": Law(percolation, {"exponent": (0.5, 1.8), "above": (0.2, 1.0)}),
    "holm_growing": Law(
        holm_growing, {"spots": (1.0, 8.0), "growth": (0.6, 1.4), "exponent": (0.4, 0.6), "series": (0.05, 0.8)}
    ),
    "ladder": Law(ladder, {"bridges": (1.0, 8.0), "leads": (0.1, 0.6), "gauge": (0.0, 0.25)}),
    "tunnelling": Law(tunnelling, {"decay": (0.5, 2.5), "leak": (0.15, 0.6)}),
    "opening_gaps": Law(opening_gaps, {"gauge": (0.3, 1.5), "curvature": (0.0, 0.4)}),
}
