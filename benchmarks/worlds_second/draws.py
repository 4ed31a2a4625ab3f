"""Random draws: ranges that a law or an effect declares."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Range:
    """Where a parameter may lie: uniform, or uniform in its logarithm, or one of a few values."""

    kind: str
    values: tuple[float, ...]

    def draw(self, rng: np.random.Generator) -> float:
        """One value."""
        if self.kind == "pick":
            return float(rng.choice(self.values))
        low, high = self.values
        if self.kind == "log":
            return float(np.exp(rng.uniform(np.log(low), np.log(high))))
        return float(rng.uniform(low, high))


def lin(low: float, high: float) -> Range:
    """Uniform between two limits."""
    return Range("lin", (low, high))


def log(low: float, high: float) -> Range:
    """Uniform in the logarithm between two positive limits."""
    return Range("log", (low, high))


def pick(*values: float) -> Range:
    """One of these values."""
    return Range("pick", values)


def draw_all(ranges: Mapping[str, Range], rng: np.random.Generator) -> dict[str, float]:
    """One value for each range."""
    return {name: values.draw(rng) for name, values in ranges.items()}
