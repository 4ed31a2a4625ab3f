"""Slack: the specimen hangs limp near the start. Sizes are strains."""

from __future__ import annotations

from functools import partial

import numpy as np

from worlds_fourth.effects.effect import Effect, Form, form_of
from worlds_fourth.randoms import Rng
from worlds_fourth.signals import Array, State
from worlds_fourth.specimen import Specimen

FORMS: list[Form] = []
_slack = partial(form_of, FORMS, "slack")


@_slack()
def too_long(rng: Rng, specimen: Specimen) -> Effect:
    """Longer than the way between the clamps: hardly any force until it is taut."""
    return Effect(
        "too long by a strain of a", 0.3 * specimen.end, {"strain": lambda s, e, size: (e - size) / (1 + size)}
    )


def _sag(specimen: Specimen, text: str, taken_out: Array, strains: Array) -> Effect:
    """Carriage's strain = strain of the knit + `size` times what its force has taken out of the sag."""

    def act(s: State, e: Array, size: float) -> Array:
        return np.interp(e, strains + size * taken_out, strains)

    return Effect(text, 0.35 * specimen.end, {"strain": act})


def _pulled(specimen: Specimen) -> tuple[Array, Array]:
    """Strains of the stroke and the force above that at rest."""
    strains = np.linspace(0, specimen.end, 1500)
    return strains, specimen.elasticity.force_N(strains) - specimen.elasticity.rest_N


@_slack()
def sag(rng: Rng, specimen: Specimen) -> Effect:
    """A sag that the force takes out exponentially."""
    strains, force = _pulled(specimen)
    scale_N = specimen.top_N * rng.uniform(0.03, 0.12)
    return _sag(specimen, f"sag a (1 - exp(-F/{scale_N:.3f} N))", 1 - np.exp(-force / scale_N), strains)


@_slack()
def catenary(rng: Rng, specimen: Specimen) -> Effect:
    """A sag that the force takes out as that of a hanging chain, by a power."""
    strains, force = _pulled(specimen)
    scale_N, n = specimen.top_N * rng.uniform(0.05, 0.15), rng.uniform(1.5, 2.5)
    return _sag(specimen, f"sag a (1 - (1 + F/{scale_N:.3f} N)^-{n:.2f})", 1 - (1 + force / scale_N) ** -n, strains)
