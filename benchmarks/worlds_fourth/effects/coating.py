"""Wear of the coating, and its cracks: the conductance falls for good. Sizes are of ln R."""

from __future__ import annotations

from functools import partial

import numpy as np

from worlds_fourth.effects.effect import Effect, Form, form_of
from worlds_fourth.operators import largest_so_far, summed, travel
from worlds_fourth.randoms import Rng
from worlds_fourth.signals import Array, State
from worlds_fourth.specimen import Specimen

FORMS: list[Form] = []
_wear = partial(form_of, FORMS, "coating_wear")
_cracks = partial(form_of, FORMS, "coating_cracks")


@_wear()
def by_travel(rng: Rng, specimen: Specimen) -> Effect:
    """Towards an end, with the way; more is lost where the knit is stretched."""
    number, b = rng.uniform(2, 12), rng.uniform(0, 0.8)

    def act(s: State, log_g: Array, size: float) -> Array:
        return log_g - size * (1 + b * s.share) * (1 - np.exp(-travel(s.strain) / 2 / specimen.end / number))

    return Effect(f"ln R + a (1 + {b:.2f} x)(1 - exp(-N/{number:.1f})), N full cycles", 0.6, {"conductance": act})


@_wear()
def archard(rng: Rng, specimen: Specimen) -> Effect:
    """Force times way (Archard, 1953), running in."""
    scale = rng.uniform(0.3, 4)

    def act(s: State, log_g: Array, size: float) -> Array:
        work = summed(s.force_N[1:] / specimen.top_N * np.abs(np.diff(s.strain)) / specimen.end)
        return log_g - size * np.log1p(work / scale)

    return Effect(f"ln R + a ln(1 + W/{scale:.2f}), W force times way", 0.3, {"conductance": act})


@_wear()
def by_loadings(rng: Rng, specimen: Specimen) -> Effect:
    """Stretches beyond a limit, as a power of their number."""
    onset, n, b = rng.uniform(0.3, 0.6), rng.uniform(0.5, 0.8), rng.uniform(0.3, 1.0)

    def act(s: State, log_g: Array, size: float) -> Array:
        number = summed(np.maximum(np.diff(np.maximum(s.share - onset, 0)), 0)) / (1 - onset)
        return log_g - np.log1p(size * number**n * (1 + b * s.share))

    return Effect(f"R (1 + a N^{n:.2f}(1 + {b:.2f} x)), N stretches beyond {onset:.2f}", 0.4, {"conductance": act})


@_cracks()
def with_largest_strain(rng: Rng, specimen: Specimen) -> Effect:
    """A power of the largest strain so far."""
    n = rng.uniform(1, 2.5)

    def act(s: State, log_g: Array, size: float) -> Array:
        return log_g - size * np.maximum(largest_so_far(s.share), 0) ** n

    return Effect(f"ln R + a xmax^{n:.2f}", 1.0, {"conductance": act})


def _density(rng: Rng) -> tuple[float, float, float, float]:
    """Onset, scale and exponent of the cracks' Weibull law, and how much more they count under strain."""
    return rng.uniform(0.1, 0.3), rng.uniform(0.2, 0.5), rng.uniform(1.2, 2.2), rng.uniform(0.2, 1)


def _cracked(share: Array, onset: float, scale: float, power: float) -> Array:
    return 1 - np.exp(-((np.maximum(largest_so_far(share) - onset, 0) / scale) ** power))


@_cracks()
def fragments(rng: Rng, specimen: Specimen) -> Effect:
    """Fragments until they are as short as they can be (Weibull)."""
    onset, scale, power, b = _density(rng)

    def act(s: State, log_g: Array, size: float) -> Array:
        return log_g - size * _cracked(s.share, onset, scale, power) * (1 + b * s.share)

    return Effect(
        f"ln R + a cracks (1 + {b:.2f} x), from {onset:.2f} on, Weibull {power:.1f}", 0.8, {"conductance": act}
    )


@_cracks()
def opening(rng: Rng, specimen: Specimen) -> Effect:
    """The largest strain makes them, the strain opens them."""
    onset, scale, power, _ = _density(rng)
    n = rng.uniform(0.8, 1.6)

    def act(s: State, log_g: Array, size: float) -> Array:
        return log_g - np.log1p(size * _cracked(s.share, onset, scale, power) * np.maximum(s.share, 0) ** n)

    return Effect(f"ln R + ln(1 + a cracks x^{n:.2f}), from {onset:.2f} on", 1.2, {"conductance": act})
