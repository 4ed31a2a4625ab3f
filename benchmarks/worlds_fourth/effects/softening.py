"""Softening with the largest stretch (Mullins), and with every cycle (fatigue). Sizes are shares of the force."""

from __future__ import annotations

from functools import partial

import numpy as np
from scipy.special import erf

from worlds_fourth.effects.effect import Effect, Form, form_of
from worlds_fourth.operators import largest_so_far, summed, travel
from worlds_fourth.randoms import Rng
from worlds_fourth.signals import Array, State
from worlds_fourth.specimen import Specimen

FORMS: list[Form] = []
_mullins = partial(form_of, FORMS, "mullins_softening")
_fatigue = partial(form_of, FORMS, "cyclic_fatigue")


class _Energy:
    """Elastic energy over strain, over that at the end of the stroke."""

    def __init__(self, specimen: Specimen) -> None:
        self.strains = np.linspace(-0.5, specimen.end * 1.3, 2000)
        forces = np.where(self.strains > 0, specimen.elasticity.force_N(self.strains), 0)
        self.energies = np.cumsum(forces) * (self.strains[1] - self.strains[0])
        self.top = np.interp(specimen.end, self.strains, self.energies)

    def at(self, strain: Array) -> Array:
        return np.interp(strain, self.strains, self.energies)


@_mullins()
def pseudo_elastic(rng: Rng, specimen: Specimen) -> Effect:
    """Softer below the largest energy so far (Ogden and Roxburgh, 1999)."""
    energy, m, b = _Energy(specimen), rng.uniform(0.05, 0.3), rng.uniform(0, 0.5)

    def act(s: State, force: Array, size: float) -> Array:
        now = energy.at(s.strain) / energy.top
        largest = largest_so_far(now)
        return force * (1 - size * erf((largest - now) / (m + b * largest)))

    return Effect(f"F (1 - a erf((Wmax - W)/({m:.2f} + {b:.2f} Wmax)))", 0.45, {"force": act})


@_mullins()
def damage(rng: Rng, specimen: Specimen) -> Effect:
    """A share of the stiffness goes with the largest energy so far (Simo, 1987)."""
    energy, scale = _Energy(specimen), rng.uniform(0.1, 0.6)

    def act(s: State, force: Array, size: float) -> Array:
        return force * (1 - size * (1 - np.exp(-largest_so_far(energy.at(s.strain)) / energy.top / scale)))

    return Effect(f"F (1 - a (1 - exp(-Wmax/{scale:.2f})))", 0.45, {"force": act})


@_mullins()
def soft_phase(rng: Rng, specimen: Specimen) -> Effect:
    """Softer the further below the largest strain so far, and the more so the larger that was."""
    n, end = rng.uniform(1, 2), specimen.end

    def act(s: State, force: Array, size: float) -> Array:
        largest = np.maximum(largest_so_far(s.strain), 1e-4)
        return force * (1 - size * np.clip(largest / end, 0, 1.2) ** n * np.clip(1 - s.strain / largest, 0, 1) ** 0.8)

    return Effect(f"F (1 - a xmax^{n:.2f} (1 - strain/largest)^0.8)", 0.5, {"force": act})


@_fatigue()
def by_travel(rng: Rng, specimen: Specimen) -> Effect:
    """Towards an end, with the way."""
    number, end = rng.uniform(4, 20), specimen.end

    def act(s: State, force: Array, size: float) -> Array:
        return force * (1 - size * (1 - np.exp(-travel(s.strain) / 2 / end / number)))

    return Effect(f"F (1 - a (1 - exp(-N/{number:.1f}))), N full cycles by the way", 0.4, {"force": act})


@_fatigue()
def by_work(rng: Rng, specimen: Specimen) -> Effect:
    """With the logarithm of force times way."""
    scale, end, top_N = rng.uniform(0.5, 4), specimen.end, specimen.top_N

    def act(s: State, force: Array, size: float) -> Array:
        work = summed(s.elastic_N[1:] / top_N * np.abs(np.diff(s.strain)) / end)
        return force * (1 - size * np.log1p(work / scale) / 3)

    return Effect(f"F (1 - a ln(1 + W/{scale:.2f})/3), W force times way", 0.5, {"force": act})


@_fatigue()
def by_high_loads(rng: Rng, specimen: Specimen) -> Effect:
    """By a power of how far each stretch goes beyond a limit (as Basquin, 1910)."""
    m, onset, end = rng.uniform(2, 4), rng.uniform(0.3, 0.6), specimen.end
    number = rng.uniform(1.5, 6)

    def act(s: State, force: Array, size: float) -> Array:
        x = np.clip(s.strain / end, 0, 1.2)
        grown = np.maximum(np.diff(x), 0) * m * np.maximum(x[1:] - onset, 0) ** (m - 1) / (1 - onset) ** m
        return force * (1 - size * (1 - (1 + summed(grown) / number) ** -0.7))

    text = f"F (1 - a (1 - (1 + D/{number:.1f})^-0.7)), D by stretches beyond {onset:.2f}, power {m:.1f}"
    return Effect(text, 0.5, {"force": act})
