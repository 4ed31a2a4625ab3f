"""Relaxation of the force, and stiffening with the rate. Sizes are shares of the force."""

from __future__ import annotations

from functools import partial

import numpy as np

from worlds_fourth.effects.effect import Effect, Form, form_of
from worlds_fourth.operators import highpass, lowpass
from worlds_fourth.randoms import Rng
from worlds_fourth.signals import Array, State
from worlds_fourth.specimen import Specimen

FORMS: list[Form] = []
_relaxation = partial(form_of, FORMS, "stress_relaxation")
_rate = partial(form_of, FORMS, "viscous_rate_stiffening")
FAST = 0.2  # strain a second


@_relaxation()
def prony(rng: Rng, specimen: Specimen) -> Effect:
    """One to three relaxation times of the elastic force (Fung's quasi-linear viscoelasticity, 1981)."""
    count = int(rng.integers(1, 4))
    taus_s = np.exp(rng.uniform(np.log(0.8), np.log(60), count))
    shares = rng.dirichlet(np.ones(count) * 2)

    def act(s: State, force: Array, size: float) -> Array:
        late = (highpass(s.elastic_N, s.record.time_s, tau) - s.elastic_N for tau in taus_s)
        return force + size * sum(g * lost for g, lost in zip(shares, late, strict=True))

    text = ", ".join(f"{g:.2f} in {tau:.1f} s" for g, tau in zip(shares, taus_s, strict=True))
    return Effect(f"loses a: {text}", 0.5, {"force": act})


@_relaxation()
def logarithmic(rng: Rng, specimen: Specimen) -> Effect:
    """The same in every decade of time."""
    taus_s = np.exp(np.linspace(np.log(0.2), np.log(rng.uniform(60, 400)), 7))

    def act(s: State, force: Array, size: float) -> Array:
        return force - size * sum(lowpass(s.elastic_N, s.record.time_s, tau) for tau in taus_s) / 7

    return Effect(f"loses a, evenly in the logarithm of times from 0.2 to {taus_s[-1]:.0f} s", 0.5, {"force": act})


@_relaxation()
def nonlinear(rng: Rng, specimen: Specimen) -> Effect:
    """A power of the force relaxes (Schapery, 1969)."""
    n, tau_s, top_N = rng.uniform(1.5, 2.5), rng.uniform(2, 25), specimen.top_N

    def act(s: State, force: Array, size: float) -> Array:
        return force - size * top_N * lowpass((s.elastic_N / top_N) ** n, s.record.time_s, tau_s)

    return Effect(f"loses a of (F/top)^{n:.2f} in {tau_s:.1f} s", 0.5, {"force": act})


@_rate()
def kelvin_voigt(rng: Rng, specimen: Specimen) -> Effect:
    """A dashpot beside the spring, partly in proportion to the force."""
    c, top_N = rng.uniform(0, 1), specimen.top_N

    def act(s: State, force: Array, size: float) -> Array:
        taut = np.minimum(1, s.elastic_N / (0.1 * top_N))
        return force + size * top_N * (1 - c + c * s.elastic_N / top_N) * taut * s.rate_per_s / FAST

    return Effect(f"a of the top at 0.2 strain a second, {c:.2f} of it with the force", 0.3, {"force": act})


@_rate()
def eyring(rng: Rng, specimen: Specimen) -> Effect:
    """The logarithm of the rate, in proportion to the force (Eyring, 1936)."""
    slow = rng.uniform(0.003, 0.02)

    def act(s: State, force: Array, size: float) -> Array:
        return force + size * s.elastic_N * np.arcsinh(s.rate_per_s / slow)

    return Effect(f"a F arsinh(rate/{slow:.4f})", 0.1, {"force": act})


@_rate()
def power_of_rate(rng: Rng, specimen: Specimen) -> Effect:
    """A power of the rate, in proportion to the force (as Cowper and Symonds, 1957)."""
    n = rng.uniform(0.35, 0.7)

    def act(s: State, force: Array, size: float) -> Array:
        return force * (1 + size * np.sign(s.rate_per_s) * np.abs(s.rate_per_s / FAST) ** n)

    return Effect(f"F (1 + a (rate/0.2)^{n:.2f}), signed", 0.3, {"force": act})
