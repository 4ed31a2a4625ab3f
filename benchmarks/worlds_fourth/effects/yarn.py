"""The yarn itself is stretched, and its resistance grows. Sizes are of ln R or a gauge factor, as said by each."""

from __future__ import annotations

from functools import partial

import numpy as np

from worlds_fourth.effects.effect import Effect, Form, form_of
from worlds_fourth.operators import softplus
from worlds_fourth.randoms import Rng
from worlds_fourth.signals import Array, State
from worlds_fourth.specimen import Specimen

FORMS: list[Form] = []
_yarn = partial(form_of, FORMS, "yarn_elongation")


def _straight(rng: Rng, specimen: Specimen) -> tuple[float, float]:
    """Strain from which the loops are straight, and how far that is rounded."""
    return specimen.end * rng.uniform(0.45, 0.75), specimen.end * rng.uniform(0.01, 0.04)


@_yarn()
def straight_loops(rng: Rng, specimen: Specimen) -> Effect:
    """A gauge factor from the strain on at which the loops are straight."""
    onset, width = _straight(rng, specimen)

    def act(s: State, log_g: Array, size: float) -> Array:
        return log_g - np.log1p(size * width * softplus((s.strain - onset) / width) / specimen.end)

    return Effect(f"R (1 + a (strain beyond {onset:.3f})/end)", 3.0, {"conductance": act})


@_yarn()
def by_tension(rng: Rng, specimen: Specimen) -> Effect:
    """Longer and thinner by the tension: the square of its stretch."""
    _straight(rng, specimen)
    n = rng.uniform(1.5, 3)

    def act(s: State, log_g: Array, size: float) -> Array:
        return log_g - 2 * np.log1p(size * (s.force_N / specimen.top_N) ** n)

    return Effect(f"ln R + 2 ln(1 + a (F/top)^{n:.2f})", 0.8, {"conductance": act})


@_yarn()
def thinner_filaments(rng: Rng, specimen: Specimen) -> Effect:
    """A power of the strain beyond which the loops are straight."""
    onset, _ = _straight(rng, specimen)
    n, end = rng.uniform(2, 5), specimen.end

    def act(s: State, log_g: Array, size: float) -> Array:
        return log_g - size * (np.maximum(s.strain - onset, 0) / (end - onset)) ** n

    return Effect(f"ln R + a (strain beyond {onset:.3f})^{n:.2f}, 1 at the end", 0.8, {"conductance": act})
