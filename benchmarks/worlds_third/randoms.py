"""Numbers drawn between two bounds."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

Ranges = Mapping[str, tuple[float, float]]
Values = dict[str, float]
WIDE = 4.0  # bounds further apart than this ratio are decades, not lengths: drawn evenly in the logarithm


def between(rng: np.random.Generator, low: float, high: float) -> float:
    """A number between two bounds, evenly, or evenly in its logarithm where they are far apart."""
    if low > 0 and high / low > WIDE:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))
    return float(rng.uniform(low, high))


def draw(rng: np.random.Generator, ranges: Ranges) -> Values:
    """One value for every name."""
    return {name: between(rng, low, high) for name, (low, high) in ranges.items()}
