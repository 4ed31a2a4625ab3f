"""Slip in the clamps. Sizes are mm, mm/s, or a share of the force, as said by each."""

from __future__ import annotations

from functools import partial

import numpy as np

from worlds_fourth.effects.effect import Effect, Form, form_of
from worlds_fourth.kernels.jaws import slip_above, slip_creeping, slip_in_jumps
from worlds_fourth.randoms import Rng
from worlds_fourth.signals import GAUGE_LENGTH_MM, Array, State
from worlds_fourth.specimen import Specimen

FORMS: list[Form] = []
_slip = partial(form_of, FORMS, "clamp_slip")
MOST_JUMPS = 4000
REST_S = 0.15  # between two jumps


def _grid(specimen: Specimen) -> tuple[Array, Array]:
    """Strains and the elastic force there."""
    strains = np.linspace(-0.5, specimen.end * 1.1, 3000)
    return strains, specimen.elasticity.force_N(strains)


def _strain(position_mm: Array, slipped_mm: Array) -> Array:
    return (position_mm - slipped_mm) / (GAUGE_LENGTH_MM + slipped_mm)


@_slip()
def jumps(rng: Rng, specimen: Specimen) -> Effect:
    """Jumps above a force, that grows a little with every jump; `size` is their mean in mm."""
    strains, forces = _grid(specimen)
    first, harder = rng.uniform(0.45, 0.7), rng.uniform(0.02, 0.05)

    def act(s: State, e: Array, size: float) -> Array:
        own = s.record.stream("slip")
        lengths, uneven = own.exponential(1.0, MOST_JUMPS), own.normal(0, 0.04, MOST_JUMPS)
        held_N = specimen.top_N * (first + harder * np.arange(MOST_JUMPS) + uneven)
        limits, u = np.interp(held_N, forces, strains), s.displacement_mm
        slipped = slip_in_jumps(u, s.record.time_s, GAUGE_LENGTH_MM, limits, size * lengths, REST_S)
        return _strain(u, slipped)

    return Effect(f"jumps of about a mm above {first:.2f} + {harder:.3f} a jump of the force", 0.6, {"strain": act})


@_slip()
def creeping(rng: Rng, specimen: Specimen) -> Effect:
    """Slides for as long as the force is above what the jaw holds; `size` in mm/s at the largest force."""
    strains, forces = _grid(specimen)
    first, n = rng.uniform(0.35, 0.6), rng.uniform(1.5, 4)
    table = (np.maximum(forces / specimen.top_N - first, 0) / (1 - first)) ** n

    def act(s: State, e: Array, size: float) -> Array:
        steps_s, u = np.gradient(s.record.time_s), s.displacement_mm
        slipped = slip_creeping(u, size * steps_s, GAUGE_LENGTH_MM, strains[0], strains[1] - strains[0], table)
        return _strain(u, slipped)

    return Effect(f"slides by a (force beyond {first:.2f} of the top)^{n:.2f} mm/s", 0.3, {"strain": act})


@_slip()
def coulomb_jaw(rng: Rng, specimen: Specimen) -> Effect:
    """Gives way as far as it must to keep the elastic force at or below a share 1 - `size` of its largest.

    As it was first written, the jaw was to hold more with every mm of slip, but never did; it is kept as it acted.
    """
    strains, forces = _grid(specimen)

    def act(s: State, e: Array, size: float) -> Array:
        limit = float(np.interp(specimen.top_N * (1 - size), forces, strains))
        return _strain(s.displacement_mm, slip_above(s.displacement_mm, GAUGE_LENGTH_MM, limit))

    return Effect("slips above 1 - a of the largest elastic force", 0.75, {"strain": act})
