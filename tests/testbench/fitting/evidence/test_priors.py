"""What is believed before the data."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from testbench.fitting.baseline import with_shapes
from testbench.fitting.evidence.priors import declared, priors_of, tail_evidence, typical_strength, with_tails
from testbench.fitting.parameters import value_of
from testbench.knit.effect import bounds_of
from testbench.measurements.preparing import prepare
from tests.testbench.builders import CATALOGUE, record, truth

SCALARS = [  # of a vector of weights the evidence finds the scale
    name
    for name, effect in CATALOGUE.effects.items()
    if effect.strength and not isinstance(effect.model_fields[effect.strength].default, tuple)
]
SCALES = {"N": 0.8, "1": 0.3}  # a tenth of a range of 8 N


def test_a_force_is_typically_a_tenth_of_the_range_and_friction_half_of_that():
    assert typical_strength(CATALOGUE["viscous_rate_stiffening"], SCALES) == pytest.approx(0.8)
    assert typical_strength(CATALOGUE["hysteresis"], SCALES) == pytest.approx(0.4)


def test_a_level_of_the_resistance_is_believed_on_the_scale_of_the_sensors_own():
    measured = {**SCALES, "ohm": 2e6, "S": 5e-7}
    assert typical_strength(CATALOGUE["adc_saturation"], measured) == 2e6
    assert typical_strength(CATALOGUE["adc_saturation_high"], measured) == 5e-7


def test_what_an_effect_declares_as_typical_is_what_is_believed():
    assert typical_strength(CATALOGUE["stress_relaxation_findley"], SCALES) == 0.7  # its default is 0.4


def test_a_strength_is_believed_to_be_small_wherever_the_search_starts():
    model = truth()
    recording = record(model, 60.0, seed=1)
    priors = priors_of(model, prepare(recording), model, {})
    place = [p.address for p in priors.parameters].index("hysteresis.friction_N")
    assert priors.mean[place] == 0
    assert priors.precision[place] ** -0.5 == pytest.approx(0.05 * np.ptp(recording["force_N"]), rel=0.1)


@pytest.mark.parametrize("name", SCALARS)
def test_every_strength_has_a_typical_size_within_its_bounds(name):
    effect = CATALOGUE[name]
    extra = bounds_of(effect.model_fields[effect.strength])
    mean, width = declared(effect, effect.strength, SCALES)
    if extra["scale"] != "log":
        assert mean == 0
        assert 0 < width <= max(abs(extra["low"]), abs(extra["high"]))


@pytest.mark.parametrize("free", [lambda address: True, lambda address: "[3]" not in address])
def test_a_point_is_a_model_and_back(free):
    measurement = prepare(record(truth(), 60.0, seed=1))
    model = with_shapes(truth(), measurement, CATALOGUE)
    parameters = priors_of(model, measurement, truth(), {}, free).parameters
    x = parameters.point_of(model) + 0.01 * np.random.default_rng(1).standard_normal(len(parameters))
    there = parameters.model_at(model, x)
    np.testing.assert_allclose(parameters.point_of(there), parameters.within(x), rtol=1e-12)
    assert there == model.with_parameters({p.address: p.to_physical(at) for p, at in zip(parameters, x, strict=True)})
    np.testing.assert_array_equal(parameters.point_of(there), [p.to_fit(value_of(there, p)) for p in parameters])


def test_a_strength_of_many_times_its_typical_size_costs_a_logarithm():
    """Where ln Z is that of a Gaussian with the same slope, the difference to Cauchy's density is added."""
    scale, x = 0.02, np.array([1e-4, 0.02, 0.3, 5.0])
    width = with_tails(np.full(4, scale**-2.0), x) ** -0.5
    cauchy, gaussian = stats.cauchy.logpdf(x, scale=scale), stats.norm.logpdf(x, scale=width)
    np.testing.assert_allclose(tail_evidence(np.full(4, scale**-2.0), x), cauchy - gaussian, rtol=1e-12)
    step = 1e-6 * x
    slope = (stats.cauchy.logpdf(x + step, scale=scale) - stats.cauchy.logpdf(x - step, scale=scale)) / (2 * step)
    np.testing.assert_allclose(slope, -x / width**2, rtol=1e-4)


def test_only_the_strengths_of_effects_have_long_tails():
    model = truth().plus(CATALOGUE["stress_relaxation"]())
    priors = priors_of(model, prepare(record(model, 60.0, seed=1)), truth(), {})
    having = [p.address for p, tails in zip(priors.parameters, priors.tails, strict=True) if tails]
    assert having == ["stress_relaxation.fraction"]
