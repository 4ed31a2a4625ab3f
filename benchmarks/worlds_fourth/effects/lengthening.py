"""Permanent set: the specimen grows longer for good. Sizes are strains."""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from worlds_fourth.effects.effect import Effect, Form, form_of
from worlds_fourth.kernels.followers import grow_towards
from worlds_fourth.operators import largest_so_far, summed
from worlds_fourth.randoms import Rng
from worlds_fourth.signals import Array, State
from worlds_fourth.specimen import Specimen

FORMS: list[Form] = []
_set = partial(form_of, FORMS, "permanent_set")


def _of_longer(strain: Array, longer: Array) -> Array:
    """Strain of a specimen that has become longer by a strain."""
    return (strain - longer) / (1 + longer)


@_set()
def of_largest_strain(rng: Rng, specimen: Specimen) -> Effect:
    """A power of the largest strain so far, beyond a yield strain."""
    end, onset, n = specimen.end, specimen.end * rng.uniform(0.05, 0.3), rng.uniform(0.7, 1.5)

    def act(s: State, e: Array, size: float) -> Array:
        return _of_longer(e, size * np.maximum(largest_so_far(e) - onset, 0) ** n / (end - onset) ** n)

    return Effect(f"a (largest strain beyond {onset:.3f})^{n:.2f}, 1 at the top", 0.25 * end, {"strain": act})


@_set()
def viscoplastic(rng: Rng, specimen: Specimen) -> Effect:
    """Flows towards what the strain asks for, and never back."""
    end, n, tau_s = specimen.end, rng.uniform(1, 2.5), rng.uniform(5, 40)

    def act(s: State, e: Array, size: float) -> Array:
        target = size * np.clip(e / end, 0, 1) ** n
        return _of_longer(e, grow_towards(target, np.gradient(s.record.time_s), tau_s))

    return Effect(f"follows a x^{n:.2f} upwards within {tau_s:.1f} s", 0.25 * end, {"strain": act})


@_set()
def ratcheting(rng: Rng, specimen: Specimen) -> Effect:
    """Every stretch adds a little, less and less."""
    end, scale, n = specimen.end, specimen.end * rng.uniform(2, 12), rng.uniform(1, 3)

    def act(s: State, e: Array, size: float) -> Array:
        work = summed(np.maximum(np.diff(e), 0) * (e[1:] / end) ** n)
        return _of_longer(e, size * np.log1p(work / scale) / math.log(6))

    return Effect(f"a ln(1 + W/{scale:.2f})/ln 6, W the way out times x^{n:.2f}", 0.12 * end, {"strain": act})
