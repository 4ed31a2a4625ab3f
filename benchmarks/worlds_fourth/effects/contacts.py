"""Relaxation and saturation of the contacts: the conductance shows them, the force does not."""

from __future__ import annotations

from functools import partial

import numpy as np

from worlds_fourth.effects.effect import Effect, Form, form_of
from worlds_fourth.kernels.followers import age
from worlds_fourth.operators import lowpass, softplus
from worlds_fourth.randoms import Rng
from worlds_fourth.signals import Array, State
from worlds_fourth.specimen import Specimen

FORMS: list[Form] = []
_relaxation = partial(form_of, FORMS, "contact_relaxation")
_saturation = partial(form_of, FORMS, "contact_saturation")


@_relaxation()
def creeping_area(rng: Rng, specimen: Specimen) -> Effect:
    """The area of the contacts grows on, evenly in the logarithm of time."""
    range_g = specimen.conduction.range
    taus_s = np.exp(np.linspace(np.log(0.5), np.log(rng.uniform(40, 150)), 6))

    def act(s: State, log_g: Array, size: float) -> Array:
        return log_g + size * range_g * sum(lowpass(s.share, s.record.time_s, tau) for tau in taus_s) / 6

    return Effect(f"gains a of the range from 0.5 to {taus_s[-1]:.0f} s", 0.6, {"conductance": act})


@_relaxation()
def relaxing_pressure(rng: Rng, specimen: Specimen) -> Effect:
    """The pressure between the yarns relaxes with one time."""
    range_g, top_N, tau_s = specimen.conduction.range, specimen.top_N, rng.uniform(4, 25)

    def act(s: State, log_g: Array, size: float) -> Array:
        return log_g - size * range_g * lowpass(s.force_N / top_N, s.record.time_s, tau_s)

    return Effect(f"loses a of the range times force, in {tau_s:.1f} s", 0.6, {"conductance": act})


@_relaxation()
def ageing(rng: Rng, specimen: Specimen) -> Effect:
    """Contacts age at rest and are renewed by sliding (Dieterich, 1979)."""
    slip, onset_s = specimen.end * rng.uniform(0.02, 0.08), rng.uniform(0.3, 1.0)
    sign = 1 if rng.random() < 0.6 else -1

    def act(s: State, log_g: Array, size: float) -> Array:
        ages = age(np.abs(s.rate_per_s) / slip, np.gradient(s.record.time_s))
        return log_g + sign * size * np.log1p(ages / onset_s)

    return Effect(f"ln G {sign:+d} a ln(1 + age/{onset_s:.2f} s), slip {slip:.4f}", 0.15, {"conductance": act})


@_relaxation()
def stretched_decay(rng: Rng, specimen: Specimen) -> Effect:
    """Contacts newly made part again, with times spread about one."""
    rng.uniform(0.4, 0.7)  # not used, drawn so that the numbers stay those of the first writing
    tau_s, range_g = rng.uniform(5, 30), specimen.conduction.range
    taus_s = tau_s * np.exp(np.linspace(-2.5, 2.5, 6))
    weights = np.exp(-0.5 * (np.linspace(-1.5, 1.5, 6)) ** 2)
    weights /= weights.sum()

    def act(s: State, log_g: Array, size: float) -> Array:
        terms = (w * lowpass(s.share**2, s.record.time_s, tau) for w, tau in zip(weights, taus_s, strict=True))
        return log_g - size * range_g * sum(terms)

    return Effect(f"loses a of the range times x^2, in times about {tau_s:.1f} s", 0.6, {"conductance": act})


def _level(specimen: Specimen) -> float:
    """Driver at which it begins at size 0: out of reach."""
    return 1.1 if specimen.conduction.strain_share > 0.5 else 1.2


def _driver_stops(specimen: Specimen, width: float) -> Effect:
    level = _level(specimen)

    def act(s: State, driver: Array, size: float) -> Array:
        return driver - width * softplus((driver - level * (1 - size)) / width)

    return Effect(
        f"the driver grows no further than {level} (1 - a), rounded over {width:.3f}", 0.75, {"driver": act}
    )


@_saturation()
def parallel_limit(rng: Rng, specimen: Specimen) -> Effect:
    """Something in series with the contacts limits G, where G rises over the stroke; else as `driver_plateau`."""
    width = rng.uniform(0.015, 0.06)
    if specimen.conduction.course != "rise":
        return _driver_stops(specimen, width)
    top, range_g = specimen.conduction.top, specimen.conduction.range
    n = rng.uniform(12, 40) / range_g

    def act(s: State, log_g: Array, size: float) -> Array:
        limit = top + 0.1 * range_g - size * range_g
        return -np.logaddexp(-n * log_g, -n * limit) / n

    return Effect(f"G^-{n:.0f} + limit^-{n:.0f}, a - 0.1 of the range below the top", 0.75, {"conductance": act})


@_saturation()
def driver_plateau(rng: Rng, specimen: Specimen) -> Effect:
    """What drives the contacts grows no further than a level."""
    return _driver_stops(specimen, rng.uniform(0.015, 0.06))


@_saturation()
def contact_count(rng: Rng, specimen: Specimen) -> Effect:
    """The number of contacts goes towards an end."""
    rng.uniform(0.015, 0.06)  # not used, drawn so that the numbers stay those of the first writing
    n, level = rng.uniform(5, 12), _level(specimen)

    def act(s: State, driver: Array, size: float) -> Array:
        end = level / max(size, 1e-6) ** 0.5 * 0.45
        up = np.maximum(driver, 0)
        return up / (1 + (up / end) ** n) ** (1 / n) + np.minimum(driver, 0)

    return Effect(f"d/(1 + (d/end)^{n:.1f})^(1/{n:.1f}), end {level * 0.45:.2f}/sqrt(a)", 1.0, {"driver": act})
