"""Jamming: loops touch their neighbours, and the force rises much faster. Sizes are over the force at the end."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from worlds_fourth.effects.effect import Effect, Form, form_of
from worlds_fourth.operators import softplus
from worlds_fourth.randoms import Rng
from worlds_fourth.signals import Array, State
from worlds_fourth.specimen import Specimen

FORMS: list[Form] = []
_jamming = partial(form_of, FORMS, "jamming_stiffening")


def _onset(rng: Rng, specimen: Specimen) -> tuple[float, float]:
    """Strain at which the loops touch, and how far it is rounded."""
    return specimen.end * rng.uniform(0.6, 0.8), specimen.end * rng.uniform(0.008, 0.03)


def _added(specimen: Specimen, text: str, rise: Callable[[Array], Array]) -> Effect:
    def act(s: State, force: Array, size: float) -> Array:
        return force + size * specimen.top_N * rise(s.strain)

    return Effect(f"{text}, a of the top there", 1.2, {"force": act})


@_jamming()
def second_spring(rng: Rng, specimen: Specimen) -> Effect:
    """A second stiffness from one strain on."""
    onset, width = _onset(rng, specimen)
    end = specimen.end
    text = f"a second stiffness above {onset:.3f}, rounded over {width:.4f}"
    return _added(specimen, text, lambda e: width * softplus((e - onset) / width) / (end - onset))


@_jamming()
def locking(rng: Rng, specimen: Specimen) -> Effect:
    """Towards a strain that cannot be passed."""
    onset, _ = _onset(rng, specimen)
    end, locked = specimen.end, specimen.end * rng.uniform(1.08, 1.25)

    def rise(e: Array) -> Array:
        q = np.clip((e - onset) / (locked - onset), 0, 0.93)
        return q / (1 - q) * (locked - end) / (end - onset)

    return _added(specimen, f"from {onset:.3f} towards {locked:.3f}", rise)


@_jamming()
def exponential(rng: Rng, specimen: Specimen) -> Effect:
    """An exponential from one strain on."""
    onset, _ = _onset(rng, specimen)
    rng.uniform(1.4, 2.0)  # not used, drawn so that the numbers stay those of the first writing
    end, b = specimen.end, rng.uniform(2, 4)

    def rise(e: Array) -> Array:
        return np.expm1(b * np.clip((e - onset) / (end - onset), 0, 1.3)) / np.expm1(b)

    return _added(specimen, f"exponential rise above {onset:.3f}, steepness {b:.1f}", rise)
