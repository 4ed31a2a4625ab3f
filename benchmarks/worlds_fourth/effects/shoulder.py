"""A second peak of the resistance within the stroke. Sizes are of ln R."""

from __future__ import annotations

from functools import partial

import numpy as np

from worlds_fourth.effects.effect import Effect, Form, form_of
from worlds_fourth.kernels.friction import dahl
from worlds_fourth.operators import play
from worlds_fourth.randoms import Rng
from worlds_fourth.signals import Array, State
from worlds_fourth.specimen import Specimen

FORMS: list[Form] = []
_shoulder = partial(form_of, FORMS, "shoulder_peak")


def _place(rng: Rng) -> tuple[float, float]:
    """Share of the stroke at which it stands, and its width."""
    return rng.uniform(0.3, 0.7), rng.uniform(0.05, 0.12)


@_shoulder()
def bump(rng: Rng, specimen: Specimen) -> Effect:
    """At one strain, smaller on the way back."""
    centre, width = _place(rng)
    back = rng.uniform(0, 0.5)

    def act(s: State, log_g: Array, size: float) -> Array:
        shape = np.exp(-0.5 * ((s.share - centre) / width) ** 2)
        return log_g - size * shape * (0.5 * (1 + back) + 0.5 * (1 - back) * dahl(s.share, 0.05))

    text = f"a at x = {centre:.2f}, width {width:.2f}, {back:.2f} of it on the way back"
    return Effect(text, 0.5, {"conductance": act})


@_shoulder()
def late_bump(rng: Rng, specimen: Specimen) -> Effect:
    """At a strain that lags behind after a turn."""
    centre, width = _place(rng)
    lag = rng.uniform(0.04, 0.12)
    centre = min(centre, 0.65)

    def act(s: State, log_g: Array, size: float) -> Array:
        return log_g - size * np.exp(-0.5 * ((play(s.share, lag, 0.0) - centre) / width) ** 2)

    return Effect(f"a at x = {centre:.2f} +- {lag:.2f}, width {width:.2f}", 0.5, {"conductance": act})


@_shoulder()
def competing_contacts(rng: Rng, specimen: Specimen) -> Effect:
    """Contacts open at one level of strain or force, and others close at a higher one."""
    _, width = _place(rng)
    steep = width * rng.uniform(0.3, 0.6)
    opens = rng.uniform(0.25, 0.5)
    by_force = specimen.conduction.strain_share < 0.5

    def act(s: State, log_g: Array, size: float) -> Array:
        q = s.force_N / specimen.top_N if by_force else s.share
        opened = 1 / (1 + np.exp(-(q - opens) / steep))
        closed = 1 / (1 + np.exp(-(q - opens - 2.2 * width) / steep))
        return log_g - size * (opened - closed)

    text = f"opens at {opens:.2f}, closes {2.2 * width:.2f} later, of the {'force' if by_force else 'strain'}"
    return Effect(text, 0.4, {"conductance": act})
