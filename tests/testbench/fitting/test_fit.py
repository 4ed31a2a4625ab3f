"""A fit finds what is known, says how well, and works on whatever was measured."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize

from testbench.fitting.baseline import starting_baseline, with_shapes
from testbench.fitting.downhill import huber
from testbench.fitting.evidence.independent_samples import independent_share
from testbench.fitting.evidence.laplace import fitted
from testbench.fitting.evidence.sample_noise import likelihood_of, noise_of
from testbench.fitting.fit import fit
from testbench.fitting.parameters import FreeParameters, free_parameters, shape_scales
from testbench.fitting.sensitivity import sensitivities
from testbench.knit.cache import SimulationCache
from testbench.knit.effect import bounds_of
from testbench.measurements.noise_level import noise_floor, robust_sd
from testbench.measurements.preparing import prepare
from tests.testbench.builders import CATALOGUE, NOISE_LN, NOISE_N, record, truth

KNOWN = ("elasticity.stiffness_N", "elasticity.curvature", "hysteresis.friction_N", "hysteresis.threshold")


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_known_parameters_come_back_within_their_standard_errors(seed):
    measurement = prepare(record(truth(), seed=seed))
    result = fit(starting_baseline(measurement), measurement)
    at = {p.address: index for index, p in enumerate(result.parameters)}
    rows = [at[address] for address in KNOWN]
    wanted = FreeParameters(result.parameters[row] for row in rows).point_of(truth())
    distance = (result.vector[rows] - wanted) / result.standard_errors[rows]
    assert np.all(np.abs(distance) < 3), dict(zip(KNOWN, distance, strict=True))
    # The errors are wide for the allowance, but not so wide that they say nothing.
    errors = {address: result.standard_errors[row] for address, row in at.items()}
    assert errors["elasticity.stiffness_N"] < 0.1


@pytest.mark.parametrize("iterations", [1, 2, 3])
def test_a_parameter_that_came_off_its_bound_has_an_error_of_its_own(iterations):
    """Where the search ends with the step that took it off."""
    measurement = prepare(record(truth(), seed=1))
    start = truth()
    for name, effect in start.effects.items():
        for key, field in type(effect).model_fields.items():
            extra = bounds_of(field) if isinstance(getattr(effect, key), float) else {}
            if extra.get("scale") == "log":
                start = start.with_parameters({f"{name}.{key}": extra["low"]})
    result = fit(start, measurement, iterations=iterations)
    inside = (result.vector > result.parameters.low + 1e-9) & (result.vector < result.parameters.high - 1e-9)
    assert inside.sum() > 3
    assert result.standard_errors[inside].min() > 1e-5


def test_standard_errors_allow_for_autocorrelation():
    """On white noise the stated errors are wider than the scatter of refits by about the root of the allowance."""
    found = []
    for seed in range(8):
        measurement = prepare(record(truth(), 120, seed=seed, strain=lambda t: 0.15 - 0.15 * np.cos(t)))
        result = fit(truth(), measurement)
        index = [p.address for p in result.parameters].index("elasticity.stiffness_N")
        found.append((result.vector[index], result.standard_errors[index]))
    values, errors = np.array(found).T
    assert 1 < np.mean(errors) / np.std(values) < 3 / np.sqrt(independent_share(measurement))


def test_nothing_near_is_more_probable():
    """Where the fit ends, a general minimiser of the same posterior finds nothing better."""
    measurement = prepare(record(truth(), 120, seed=5))
    likelihood = likelihood_of(truth(), measurement, noise_of(measurement))
    h = fitted(starting_baseline(measurement), likelihood, truth())
    parameters, sigma = h.priors.parameters, h.evidence.sigma

    def cost(x):
        residual = measurement.residual(parameters.model_at(h.model, x))
        misfit = sum(np.sum(huber(np.abs(likelihood.picked(v, c)) / sigma[c])) for c, v in residual.items())
        return float(misfit * likelihood.share + np.sum(h.priors.cost(x, h.evidence.scale)))

    bounds = list(zip(parameters.low, parameters.high, strict=True))
    found = minimize(cost, h.vector, method="L-BFGS-B", bounds=bounds)
    assert cost(h.vector) < found.fun + 0.1
    far = parameters.point_of(starting_baseline(measurement))
    assert cost(h.vector) < cost(far) - 10


def test_a_parameter_on_its_bound_is_said():
    source = record(truth(), channels=("force_N",))
    falling = {**source.channels, "force_N": 1 - source["force_N"]}
    measurement = prepare(type(source)(source.time_s, falling, source.gauge_length_mm))
    result = fit(starting_baseline(measurement), measurement)
    assert "hysteresis.friction_N" in result.at_bound()
    # As wide as what is known on the near side, not as the pin that holds it there.
    assert 1e-4 < result.summary()["parameters"]["hysteresis.friction_N"]["standard_error"] < 1


@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e4])
def test_a_level_of_the_resistance_is_known_as_well_in_every_unit(unit):
    whole = record(truth(), 120.0)
    top_ohm = float(np.quantile(whole["resistance_ohm"], 0.8))
    noise = np.exp(0.003 * np.random.default_rng(3).standard_normal(len(whole)))
    clipped = {**whole.channels, "resistance_ohm": unit * noise * np.minimum(whole["resistance_ohm"], top_ohm)}
    contact = truth()["contact"]
    scaled = {
        "contact.contact_resistance_ohm": contact.contact_resistance_ohm * unit,
        "contact.parallel_S": contact.parallel_S / unit,
        "contact.series_ohm": contact.series_ohm * unit,
    }
    start = truth().with_parameters(scaled).plus(CATALOGUE["adc_saturation_high"](floor_S=1.1 / (top_ohm * unit)))
    found = fit(start, prepare(replace(whole, channels=clipped)))
    address = "adc_saturation_high.floor_S"
    entry = found.summary()["parameters"][address]
    assert entry["value"] * top_ohm * unit == pytest.approx(1.0, abs=0.01)
    assert entry["standard_error"] / entry["value"] < 0.002
    assert address not in found.at_bound()


@pytest.mark.parametrize("unit", [0.02, 100.0])
def test_contacts_are_found_as_well_in_a_sensor_of_any_force(unit):
    """A skin that pulls with tens of millinewtons, and a webbing with hundreds of newtons."""
    relaxing = truth().plus(CATALOGUE["contact_relaxation"]().near(fraction=0.2, tau_s=10.0))
    whole = record(relaxing, 120.0, 10.0, seed=1)
    other = replace(whole, channels={**whole.channels, "force_N": whole["force_N"] * unit})
    usual, scaled = (fit(starting_baseline(one), one) for one in map(prepare, (whole, other)))
    assert scaled.model["contact"].preload_N == pytest.approx(unit * usual.model["contact"].preload_N, rel=0.1)
    assert scaled.model["contact"].exponent == pytest.approx(usual.model["contact"].exponent, rel=0.1)
    left = [
        np.std(m.residual(found.model)["conductance"])
        for m, found in ((prepare(whole), usual), (prepare(other), scaled))
    ]
    assert left[1] == pytest.approx(left[0], rel=0.02)


def test_what_force_alone_cannot_tell_is_said():
    measurement = prepare(record(truth(), channels=("force_N",)))
    result = fit(truth(), measurement)
    assert "contact.contact_resistance_ohm" in result.unidentified()
    assert "elasticity.stiffness_N" not in result.unidentified()


@pytest.mark.parametrize("rate_hz", [12.0, 100.0])
@pytest.mark.parametrize("channels", [("force_N",), ("resistance_ohm",), ("force_N", "resistance_ohm")])
def test_any_channels_at_any_rate_down_to_the_noise(channels, rate_hz):
    measurement = prepare(record(truth(), 120, rate_hz, channels=channels))
    result = fit(starting_baseline(measurement), measurement)
    residual = measurement.residual(result.model)
    averaged = np.sqrt(min(1.0, 25.0 / rate_hz))
    # Without force the elastic law is only felt through the contacts; the fit comes near the noise but not to it.
    most = 1.35 if "force_N" in channels else 6.0
    for channel, noise in (("force", NOISE_N), ("conductance", NOISE_LN)):
        if channel in residual:
            assert np.std(residual[channel][measurement.counts]) < most * averaged * noise


def test_a_ramp_and_hold_can_be_fitted():
    source = record(truth(), 300, strain=lambda t: 0.3 * np.minimum(t, 1.0), channels=("force_N",))
    measurement = prepare(source)
    result = fit(starting_baseline(measurement), measurement)
    assert np.std(measurement.residual(result.model)["force"][measurement.counts]) < 1.2 * NOISE_N


def test_outliers_do_not_pull():
    clean = record(truth(), seed=4)
    force = clean["force_N"].copy()
    force[::97] += 3.0
    measurement = prepare(type(clean)(clean.time_s, {**clean.channels, "force_N": force}, 25.0))
    result = fit(starting_baseline(measurement), measurement)
    assert result.model["elasticity"].stiffness_N == pytest.approx(6.0, rel=0.05)


def test_sensitivities_agree_with_central_differences():
    measurement = prepare(record(truth(), 60))
    model = with_shapes(truth(), measurement)
    parameters = free_parameters(model, shape_scales(measurement))
    _, jacobian = sensitivities(model, parameters, measurement, SimulationCache())
    start = parameters.point_of(model)
    for index, parameter in enumerate(parameters):
        step = 1e-5 * (1.0 if parameter.log else max(abs(start[index]), 0.1 * parameter.width))
        if not parameter.low < parameter.to_physical(start[index] - step):
            continue  # at its lower bound
        one = FreeParameters([parameter])
        sides = [measurement.modelled(one.model_at(model, start[index : index + 1] + s)) for s in (-step, step)]
        for channel, rows in jacobian.items():
            central = (sides[1][channel] - sides[0][channel]) / (2 * step)
            scale = np.sqrt(np.mean(central**2)) + 1e-9
            # Play operators have kinks: single samples may differ, the whole may not.
            assert np.sqrt(np.mean((rows[index] - central) ** 2)) < 0.05 * scale + 1e-6, parameter.address


def test_noise_floor_of_white_noise_within_5_percent():
    for seed in range(5):
        rng = np.random.default_rng(seed)
        slow = np.sin(np.arange(20_000) / 200)
        assert noise_floor(slow + 0.02 * rng.standard_normal(20_000)) == pytest.approx(0.02, rel=0.05)


@pytest.mark.parametrize("hum_hz", [4.0, 9.7, 16.2])
def test_a_hum_is_no_part_of_the_noise_floor(hum_hz):
    rng = np.random.default_rng(1)
    t_s = np.arange(40_000) / 40
    noise = 0.02 * rng.standard_normal(len(t_s))
    assert noise_floor(noise + 0.1 * np.sin(2 * np.pi * hum_hz * t_s)) == pytest.approx(0.02, rel=0.08)


def test_noise_floor_of_a_coarse_converter_is_a_share_of_its_step():
    values = np.round(np.sin(np.arange(5000) / 500) / 0.1) * 0.1
    assert noise_floor(values) == pytest.approx(0.1 / np.sqrt(12))


def test_robust_sd_ignores_outliers():
    values = np.random.default_rng(0).standard_normal(10_000)
    values[:500] = 1e6
    assert robust_sd(values) == pytest.approx(1.0, rel=0.1)
