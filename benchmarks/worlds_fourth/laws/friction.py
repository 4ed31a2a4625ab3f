"""Friction of the force: six loops over strain, at any speed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from worlds_fourth.kernels.friction import bouc_wen, dahl, sliding_springs
from worlds_fourth.kernels.preisach import everett, preisach
from worlds_fourth.randoms import Rng
from worlds_fourth.signals import Array

Loop = Callable[[Array, Array], Array]  # strain and elastic force in N -> friction in N
SPRINGS = 16


@dataclass(frozen=True)
class Friction:
    """A loop of a specimen: `loop_N` maps strain and elastic force to friction; `text` says its numbers."""

    name: str
    text: str
    loop_N: Loop


@dataclass(frozen=True)
class Height:
    """How high the loop is over strain: even, or growing from a share at rest with a power of the strain."""

    top_N: float
    even: bool
    at_rest: float
    power: float
    max_strain: float

    def over(self, strain: Array) -> Array | float:
        """Height in N."""
        if self.even:
            return self.top_N
        grown = np.clip(strain / self.max_strain, 0, 1.3) ** self.power
        return self.top_N * (self.at_rest + (1 - self.at_rest) * grown)


@dataclass(frozen=True)
class Frame:
    """What every loop is drawn with: its height, the coefficient of friction and the way on which it builds up."""

    height: Height
    coefficient: float
    reach: float

    @property
    def end(self) -> float:
        """Strain at the end of the stroke."""
        return self.height.max_strain


def iwan(rng: Rng, frame: Frame) -> Loop:
    """Sixteen springs that slide one after the other (Iwan, 1966)."""
    low, high = np.log(0.006 * frame.end), np.log(rng.uniform(0.15, 0.4) * frame.end)
    reaches = np.exp(np.linspace(low, high, SPRINGS))
    weights = reaches ** rng.uniform(-1.2, -0.5)
    weights /= (weights * reaches).sum()
    return lambda e, _: frame.height.over(e) * sliding_springs(e, reaches, weights)


def bristle(rng: Rng, frame: Frame) -> Loop:
    """Dahl (1968), as high as the strain says."""
    return lambda e, _: frame.height.over(e) * dahl(e, frame.reach)


def with_load(rng: Rng, frame: Frame) -> Loop:
    """Dahl's friction in proportion to the elastic force (Amontons)."""
    return lambda e, elastic_N: frame.coefficient * elastic_N * dahl(e, frame.reach)


def relays(rng: Rng, frame: Frame) -> Loop:
    """Preisach's relays, less the mean of the two ways."""
    p, q = rng.uniform(1.3, 2.1), rng.uniform(0, 1.5)
    height, full = frame.height, everett(1.0, 0.0, p, q)

    def loop(e: Array, _: Array) -> Array:
        x = np.clip(e / frame.end, 0, 1.2)
        mean = 0.5 * ((x**p) * (1 + q * x / 2) + full - np.maximum(1 - x, 0) ** p * (1 + q * (1 + x) / 2))
        grown = 1 if height.even else np.clip(x + height.at_rest, 0, 1)
        return -2.5 * height.top_N * (preisach(x, p, q) - mean) / full * grown

    return loop


def bouc(rng: Rng, frame: Frame) -> Loop:
    """Bouc (1967) and Wen (1976)."""
    power, loading = rng.uniform(0.8, 2.2), rng.uniform(0.5, 0.85)
    return lambda e, _: frame.height.over(e) * bouc_wen(e, frame.reach, power, loading)


def capstan(rng: Rng, frame: Frame) -> Loop:
    """Yarn round yarn: the force grows exponentially with the friction (Euler and Eytelwein)."""
    return lambda e, elastic_N: elastic_N * np.expm1(frame.coefficient * dahl(e, frame.reach))


FRICTIONS: dict[str, Callable[[Rng, Frame], Loop]] = {
    "iwan": iwan,
    "dahl": bristle,
    "with_load": with_load,
    "preisach": relays,
    "bouc_wen": bouc,
    "capstan": capstan,
}


def draw_friction(rng: Rng, max_strain: float, rest_N: float, top_N: float) -> Friction:
    """Draw a loop and its numbers."""
    name = str(rng.choice(list(FRICTIONS)))
    coefficient = rng.uniform(0.03, 0.10)
    even = bool(rest_N > 0.08 and rng.random() < 0.5)
    high_N = min(0.75 * rest_N, coefficient * top_N) if even else coefficient * top_N
    power = rng.uniform(0.6, 1.4)
    height = Height(high_N, even, min(0.6 * rest_N / high_N, 0.6), power, max_strain)
    frame = Frame(height, coefficient, max_strain * rng.uniform(0.02, 0.09))
    text = f"{name}{', even over strain' if even else ''}, coefficient {coefficient:.3f}, reach {frame.reach:.4f}"
    return Friction(name, text, FRICTIONS[name](rng, frame))
