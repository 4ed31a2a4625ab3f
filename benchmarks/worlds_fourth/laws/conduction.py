"""ln G over a driver and strain: six laws of contacts and yarns.

The driver of the contacts is a mixture of strain and force, each over its value at the end of the stroke.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from worlds_fourth.randoms import Rng
from worlds_fourth.signals import Array

Law = Callable[[Array, Array], Array]  # driver (0 to 1) and strain -> ln G
Drawn = tuple[Law, str]  # with its numbers in words


def holm(rng: Rng, sign: int) -> Drawn:
    """Contacts as a power of their pressure beside the yarn's own resistance (Holm, 1967)."""
    m, p0, bulk = rng.uniform(0.25, 1.0), rng.uniform(0.03, 0.4), rng.uniform(0, 0.4)

    def law(d: Array, e: Array) -> Array:
        return -np.log(bulk + ((np.maximum(d, 0) + p0) / (1 + p0)) ** -m)

    return law, f"Holm's contacts, exponent {m:.2f}, pressure at rest {p0:.2f}, bulk {bulk:.2f}"


def percolation(rng: Rng, sign: int) -> Drawn:
    """A power of the distance to the threshold (Kirkpatrick, 1973)."""
    t = rng.uniform(1.3, 2.2)
    k = rng.uniform(0.15, 1.2) if sign > 0 else -rng.uniform(0.15, 0.55)
    return lambda d, e: t * np.log(np.maximum(1 + k * d, 0.08)), f"percolation, exponent {t:.2f}, slope {k:.2f}"


def tunnelling(rng: Rng, sign: int) -> Drawn:
    """Gaps that close, towards an end."""
    kappa, d0 = sign * rng.uniform(0.4, 1.6), rng.uniform(0.3, 2.0)

    def law(d: Array, e: Array) -> Array:
        return kappa * (1 - np.exp(-d / d0)) / (1 - np.exp(-1 / d0))

    return law, f"tunnelling, height {kappa:.2f}, reach {d0:.2f}"


def network(rng: Rng, sign: int) -> Drawn:
    """Legs in series with heads and contacts side by side, as in a course and wale network."""
    stretch, head, contact = rng.uniform(0.3, 5), rng.uniform(0.5, 6), rng.uniform(0.3, 3)
    m, p0, leg = rng.uniform(0.4, 1.0), rng.uniform(0.03, 0.3), rng.uniform(0.05, 1.0)

    def law(d: Array, e: Array) -> Array:
        beside = 1 / (1 / (head * (1 + 0.5 * stretch * e)) + (np.maximum(d, 0) + p0) ** m / contact)
        return -np.log(leg * (1 + stretch * e) / 1.0 + beside)

    text = f"network of legs {leg:.2f}, heads {head:.2f} and contacts {contact:.2f}"
    return law, f"{text}, exponent {m:.2f}, stretch {stretch:.2f}"


def logistic(rng: Rng, sign: int) -> Drawn:
    """Contacts that close (or open) about one level, beside what always conducts."""
    always, middle, width = rng.uniform(0.15, 1.5), rng.uniform(0.2, 0.8), rng.uniform(0.1, 0.3)

    def law(d: Array, e: Array) -> Array:
        return np.log(always + 1 / (1 + np.exp(-sign * (d - middle) / width)))

    return law, f"logistic contacts about {middle:.2f}, width {width:.2f}, beside {always:.2f}"


def log_mixing(rng: Rng, sign: int) -> Drawn:
    """ln G as a power of the driver (Lichtenecker's mixture)."""
    high, n = sign * rng.uniform(0.3, 1.5), rng.uniform(0.6, 2.0)

    def law(d: Array, e: Array) -> Array:
        return high * ((np.maximum(d, 0) + 0.03) ** n - 0.03**n)

    return law, f"logarithmic mixture, height {high:.2f}, exponent {n:.2f}"


CONDUCTIONS: dict[str, Callable[[Rng, int], Drawn]] = {
    "holm": holm,
    "percolation": percolation,
    "tunnelling": tunnelling,
    "network": network,
    "logistic": logistic,
    "log_mixing": log_mixing,
}
