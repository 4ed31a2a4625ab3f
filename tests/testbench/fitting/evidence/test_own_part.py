"""What an effect changes that the base laws could not have changed themselves."""

from __future__ import annotations

import numpy as np
import pytest

from testbench.fitting.evidence.hypothesis import imitated, own_part
from testbench.fitting.evidence.laplace import fitted
from testbench.fitting.evidence.sample_noise import likelihood_of, noise_of
from testbench.knit.effect import Effect
from testbench.knit.model import KnitModel
from testbench.measurements.preparing import prepare
from tests.testbench.builders import CATALOGUE, record, truth


def own(base: KnitModel, effect: Effect) -> dict[str, float]:
    """The part of its own, in N and ln S, of an effect in a model fitted to a sensor that has it."""
    model = base.plus(effect)
    measurement = prepare(record(model, 300, 12.5, seed=1))
    likelihood = likelihood_of(base, measurement, noise_of(measurement))
    return own_part(fitted(model, likelihood, base, iterations=2), effect.name, likelihood)[0]


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


def test_laws_and_shapes_of_the_other_channel_change_nothing():
    """A law's own change is followed to its end, whatever stands beside it that says nothing here."""
    rng = np.random.default_rng(0)
    laws, shapes = rng.standard_normal((3, 400)), rng.standard_normal((4, 400))
    silent = np.zeros((2, 400))
    change = 2 * laws[1] + 0.5 * shapes[0]
    alone = imitated(change, laws, shapes, np.full(4, 10.0))
    beside = imitated(change, np.vstack((laws, silent)), np.vstack((shapes, silent)), np.r_[np.full(4, 10.0), 1, 1e4])
    np.testing.assert_allclose(beside, alone, atol=1e-12)
    np.testing.assert_allclose(imitated(laws[1], laws, np.vstack((shapes, silent)), np.full(6, 1e4)), laws[1])
    np.testing.assert_allclose(imitated(laws[1], laws, np.zeros((0, 400)), np.zeros(0)), laws[1])


def test_shapes_follow_a_change_as_far_as_their_weights_are_believed():
    """One wave, one weight: of a change of 3 the fit that believes in 1 / 10 takes n / (n + 100)."""
    wave = np.sin(np.linspace(0, 20, 400))
    square, none = float(wave @ wave), np.zeros((0, 400))
    followed = imitated(3 * wave, none, wave[None], np.array([10.0]))
    np.testing.assert_allclose(followed, 3 * wave * square / (square + 100), rtol=1e-9)
    np.testing.assert_allclose(imitated(3 * wave, none, wave[None], np.array([1e6])), 0.0, atol=1e-6)
    np.testing.assert_allclose(imitated(3 * wave, wave[None], wave[None], np.array([10.0])), 3 * wave, rtol=1e-9)
