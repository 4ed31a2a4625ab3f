"""Elastic force over strain: eight curves, each scaled to a force at rest and a force at the end of the stroke."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from worlds_fourth.operators import softplus
from worlds_fourth.randoms import Rng
from worlds_fourth.signals import Array

Curve = Callable[[Any], Any]  # strain, at or above 0 -> force in any unit
NEAR_ZERO = 1e-4  # strain over which the stiffness at rest is taken


@dataclass(frozen=True)
class Elasticity:
    """A curve of a specimen.

    Attributes
    ----------
    name : str
        One of `CURVES`.
    curve : callable
        Strain to force in any unit.
    max_strain, rest_N, top_N : float
        The force is `rest_N` at strain 0 and `top_N` at `max_strain`.
    """

    name: str
    curve: Curve
    max_strain: float
    rest_N: float
    top_N: float

    def force_N(self, strain: Array) -> Array:
        """Force at each strain; below 0 the pretension goes exponentially, as the specimen hangs limp."""
        low, high = float(self.curve(np.float64(0.0))), float(self.curve(np.float64(self.max_strain)))
        near = (float(self.curve(np.float64(NEAR_ZERO))) - low) / NEAR_ZERO
        stiffness_N = max(1e-3, near / (high - low) * (self.top_N - self.rest_N))
        pulled = self.rest_N + (self.top_N - self.rest_N) * (self.curve(np.maximum(strain, 0)) - low) / (high - low)
        limp = self.rest_N * np.exp(np.maximum(stiffness_N * np.minimum(strain, 0) / self.rest_N, -30))
        return np.where(strain < 0, limp, pulled)


def fung(rng: Rng, end: float) -> Curve:
    """Exponential (Fung, 1967)."""
    b = rng.uniform(1.5, 4.5) / end
    return lambda e: np.expm1(b * e)


def mooney(rng: Rng, end: float) -> Curve:
    """Rubber of two constants (Mooney, 1940; Rivlin, 1948), pulled along one axis."""
    r = rng.uniform(0, 0.6)

    def curve(e: Any) -> Any:
        stretch = 1 + e
        return (1 - r) * (stretch - stretch**-2) + r * (1 - stretch**-3)

    return curve


def gent(rng: Rng, end: float) -> Curve:
    """Rubber whose chains end at a limit of the first invariant (Gent, 1996)."""
    top = (1 + end) ** 2 + 2 / (1 + end) - 3
    limit = top / rng.uniform(0.35, 0.8)

    def curve(e: Any) -> Any:
        stretch = 1 + e
        share = np.minimum((stretch * stretch + 2 / stretch - 3) / limit, 0.97)
        return (stretch - stretch**-2) / np.maximum(0.05, 1 - share)

    return curve


def two_slopes(rng: Rng, end: float) -> Curve:
    """Loops bend, then the yarn is pulled: two slopes with a rounded knee."""
    r, knee, width = rng.uniform(0.08, 0.5), end * rng.uniform(0.35, 0.75), end * rng.uniform(0.12, 0.3)
    return lambda e: r * e + (1 - r) * width * (softplus((e - knee) / width) - softplus(-knee / width))


def power(rng: Rng, end: float) -> Curve:
    """A straight line and a power."""
    n, q = rng.uniform(1.8, 3.5), rng.uniform(0.15, 0.7)
    return lambda e: q * e / end + (1 - q) * np.abs(e / end) ** n


def worm_like_chain(rng: Rng, end: float) -> Curve:
    """The worm-like chain in the interpolation of Marko and Siggia (1995)."""
    limit = rng.uniform(0.55, 0.8)

    def curve(e: Any) -> Any:
        x = np.minimum(limit * e / end, 0.93)
        return 0.25 / (1 - x) ** 2 - 0.25 + x

    return curve


def ogden(rng: Rng, end: float) -> Curve:
    """Rubber of one exponent (Ogden, 1972), pulled along one axis."""
    alpha = rng.uniform(2.5, 7.0)
    return lambda e: (1 + e) ** (alpha - 1) - (1 + e) ** (-alpha / 2 - 1)


def straightening(rng: Rng, end: float) -> Curve:
    """Loops straighten: the stiffness falls at first and then rises."""
    reach, n, r = end * rng.uniform(0.08, 0.2), rng.uniform(2.2, 3.5), rng.uniform(0.1, 0.25)
    return lambda e: r * (1 - np.exp(-e / reach)) + (1 - r) * (0.3 * e / end + 0.7 * np.abs(e / end) ** n)


CURVES: dict[str, Callable[[Rng, float], Curve]] = {
    "fung": fung,
    "mooney": mooney,
    "gent": gent,
    "two_slopes": two_slopes,
    "power": power,
    "worm_like_chain": worm_like_chain,
    "ogden": ogden,
    "straightening": straightening,
}


def draw_elasticity(rng: Rng, max_strain: float, rest_N: float, top_N: float) -> Elasticity:
    """Draw a curve and its numbers."""
    name = str(rng.choice(list(CURVES)))
    return Elasticity(name, CURVES[name](rng, max_strain), max_strain, rest_N, top_N)
