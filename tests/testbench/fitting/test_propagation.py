"""A small change passes on to the readings as a run of the whole model says."""

from __future__ import annotations

import numpy as np
import pytest

from testbench.fitting.baseline import framed, with_shapes
from testbench.fitting.parameters import FreeParameters, free_parameters, shape_scales
from testbench.fitting.propagation import Chain
from testbench.fitting.sensitivity import sensitivities
from testbench.knit.cache import SimulationCache
from testbench.knit.catalogue import load_catalogue
from testbench.measurements.preparing import prepare
from tests.testbench.builders import record, truth

EFFECTS = load_catalogue().effects
MEASUREMENT = prepare(record(truth(), 60))
BENT = with_shapes(truth(), MEASUREMENT)
SINGLE_MOMENTS = 3  # of 1,200


def model_with(name):
    """The base with shapes that bend a little, and one effect of the catalogue at its default strength."""
    rng = np.random.default_rng(7)
    shapes = FreeParameters(p for p in free_parameters(BENT, shape_scales(MEASUREMENT)) if "_shape." in p.address)
    bent = shapes.model_at(BENT, 0.02 * rng.standard_normal(len(shapes)))
    return bent if name in bent else bent.plus(framed(EFFECTS[name](), bent, MEASUREMENT))


@pytest.mark.parametrize("name", EFFECTS)
def test_sensitivities_are_those_of_the_whole_model(name):
    model = model_with(name)
    every = free_parameters(model, shape_scales(MEASUREMENT))
    parameters = FreeParameters(p for p in every if p.place[2] < 2)
    _, jacobian = sensitivities(model, parameters, MEASUREMENT, SimulationCache())
    start, plain = parameters.point_of(model), MEASUREMENT.modelled(model)
    for index, parameter in enumerate(parameters):
        step = 1e-4 * (1.0 if parameter.log else max(abs(start[index]), 0.1 * parameter.width))
        if parameter.to_physical(start[index] + step) >= parameter.high:
            continue
        there = MEASUREMENT.modelled(FreeParameters([parameter]).model_at(model, start[index : index + 1] + step))
        for channel, rows in jacobian.items():
            whole = (there[channel] - plain[channel]) / step
            # At a corner that a single moment lies on, the slope on one side is not that on the other.
            off = np.sort((rows[index] - whole) ** 2)[:-SINGLE_MOMENTS]
            size = np.sqrt(np.mean(whole**2))
            assert np.sqrt(np.mean(off)) < 0.03 * size + 1e-6, (parameter.address, channel)


def chain_of(model):
    cache = SimulationCache()
    MEASUREMENT.modelled(model, cache)
    return Chain(model, MEASUREMENT, cache)


def test_a_change_of_the_force_is_simulated_as_far_as_a_law_remembers_it():
    plain, relaxing = chain_of(BENT), chain_of(BENT.plus(EFFECTS["contact_relaxation"]()))
    force = plain.number["elasticity"]
    assert plain.until(force) == force
    assert relaxing.until(relaxing.number["elasticity"]) == relaxing.number["contact_relaxation"]


def test_a_change_of_the_strain_is_simulated_to_the_last_loop():
    chain = chain_of(BENT.plus(EFFECTS["slack"]()))
    assert chain.until(chain.number["slack"]) == chain.number["contact_loops_shape"]


def test_the_force_reaches_the_conductance_through_the_contacts():
    """d ln G / dF of a contact without other paths: exponent / pressing force."""
    contact = EFFECTS["contact"](contact_resistance_ohm=1e5, parallel_S=1e-12, series_ohm=1e-4, exponent=0.5)
    model = truth().replacing("contact", contact)
    chain = chain_of(model)
    number = chain.number["hysteresis"]
    slope = chain.answers_behind(number).slopes["conductance"]["force_N"]
    pressing = contact.preload_N + chain.behind[number]["force_N"]
    firm = pressing > 5 * contact.preload_N  # where contacts are pressed, they are pressed by all of it
    assert firm.any()
    np.testing.assert_allclose(slope[firm], 0.5 / pressing[firm], rtol=2e-3)
