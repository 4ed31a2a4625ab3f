"""Random draws: ranges that a law or an effect declares, and one random stream for each purpose.

A stream is named by words, so a draw never depends on what else was drawn: with one family of laws restricted,
or another effect put in, everything else of the sensor stays as it was.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from zlib import crc32

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


def stream(seed: int, *words: str) -> np.random.Generator:
    """The random stream of a sensor that has these words as its name."""
    return np.random.default_rng([seed, crc32("/".join(words).encode())])


def draw_all(ranges: Mapping[str, Range], rng: np.random.Generator) -> dict[str, float]:
    """One value for each range."""
    return {name: values.draw(rng) for name, values in ranges.items()}
