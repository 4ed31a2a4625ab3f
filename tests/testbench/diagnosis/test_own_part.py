"""What an effect changes that the base laws could not have changed themselves."""

from __future__ import annotations

import numpy as np
import pytest

from testbench.diagnosis.laplace import fitted
from testbench.diagnosis.likelihood import likelihood_of, noise_of
from testbench.diagnosis.own_part import own_part
from testbench.fitting.measurement import prepare
from testbench.knit.effect import Effect
from testbench.knit.model import KnitModel
from tests.testbench.builders import CATALOGUE, record, truth


def own(base: KnitModel, effect: Effect) -> dict[str, float]:
    """The part of its own, in N and ln S, of an effect in a model fitted to a sensor that has it."""
    model = base.plus(effect)
    measurement = prepare(record(model, 300, 12.5, seed=1))
    likelihood = likelihood_of(base, measurement, noise_of(measurement))
    return own_part(fitted(model, likelihood, base, iterations=2), effect.name, likelihood)


def test_what_the_base_does_only_through_the_effect_is_the_effects_own():
    """The conductance of this base does not know the force; with the wear it does, by every law of the force."""
    base = KnitModel({k: e for k, e in truth().effects.items() if not k.startswith("contact")})
    found = own(base.plus(CATALOGUE["piezoresistance"](), "contact"), CATALOGUE["coating_wear_load"](loss=0.5))
    assert found["conductance"] > 0.002
    assert found["force"] == pytest.approx(0.0, abs=1e-9)


def test_what_the_base_could_do_is_not():
    """A weak exponential drift over five minutes is nearly one by the logarithm of the time."""
    effect = CATALOGUE["drift_exponential"](amount=0.01, tau_s=100.0)
    changed = 0.01 * np.sqrt(np.var(np.exp(-np.linspace(0, 3, 300))))
    assert own(truth(), effect)["conductance"] < 0.5 * changed


def test_what_another_law_of_the_base_could_do_is_not():
    """The same drift as an effect, and as a law of a base that has one."""
    drift = CATALOGUE["drift_exponential"](amount=0.2, tau_s=100.0)
    bare = KnitModel({k: e for k, e in truth().effects.items() if k != "drift"})
    model = bare.plus(drift)
    measurement = prepare(record(model, 300, 12.5, seed=1))
    likelihood = likelihood_of(bare, measurement, noise_of(measurement))
    as_effect, as_base = (fitted(model, likelihood, reference, iterations=2) for reference in (bare, model))
    alone = own_part(as_effect, drift.name, likelihood)["conductance"]
    assert own_part(as_effect, drift.name, likelihood, as_base)["conductance"] < 0.1 * alone
