"""Readings that are older than the displacement beside them."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import testbench as tb
from testbench.fitting.baseline import starting_baseline
from testbench.fitting.evidence.jitter import jitter_of
from testbench.fitting.evidence.sample_noise import likelihood_of, noise_of
from testbench.fitting.fit import fit
from testbench.knit.readout.reading_age import ConductanceAge, ForceAge
from testbench.measurements.preparing import prepare
from tests.testbench.builders import record, truth

TIME_S = np.arange(0, 60, 0.02)
WAVE = 2 + np.sin(0.7 * TIME_S)


def test_the_force_of_five_milliseconds_ago():
    aged = ForceAge(age_s=0.005).apply({"time_s": TIME_S, "force_N": WAVE}, 0.02)["force_N"]
    np.testing.assert_allclose(aged[1:-1], (2 + np.sin(0.7 * (TIME_S - 0.005)))[1:-1], atol=1e-5)


def test_the_conductance_of_ten_milliseconds_ago_at_uneven_times():
    time_s = TIME_S + 0.004 * np.random.default_rng(0).random(len(TIME_S))
    signals = {"time_s": time_s, "conductance_S": 1e-6 * (2 + np.sin(0.7 * time_s))}
    aged = ConductanceAge(age_s=0.01).apply(signals, 0.02)["conductance_S"]
    np.testing.assert_allclose(aged[1:-1], 1e-6 * (2 + np.sin(0.7 * (time_s - 0.01)))[1:-1], rtol=1e-4)


def test_the_instruments_of_the_simulated_rig_are_as_old_as_their_converters_say():
    """The last conversion at 80 per second: 6 ms. The mean of 25 ms: a good 10 ms."""
    found, _ = _example_fitted()
    assert found["force_age"].age_s == pytest.approx(0.006, abs=0.002)
    assert found["conductance_age"].age_s == pytest.approx(0.0115, abs=0.002)


@pytest.mark.parametrize("duration_s", [60, pytest.param(180, marks=pytest.mark.slow)])
def test_a_sensor_with_nothing_hidden_is_fitted_to_the_noise_of_the_simulated_rig(duration_s):
    recording, held_out = (tb.example(duration_s=duration_s, seed=seed) for seed in (1, 2))
    result = tb.diagnose(recording, held_out=held_out, most=1, progress=False)
    assert result.verdict == "nothing_missing"
    told = result.to_dict()
    for channel, error in told["error_after"].items():
        assert error < 1.1 * told["noise_floor"][channel]


def test_the_jitter_of_the_age_is_that_of_the_converter():
    """A conversion of 12.5 ms that is asked for at any time: 12.5 / sqrt(12) ms, less for neighbours are averaged."""
    model, measurement = _example_fitted()
    jitter_s = jitter_of([model], measurement)
    assert jitter_s["force"] == pytest.approx(0.0125 / 12**0.5, rel=0.35)


def test_without_jitter_hardly_any_is_found_and_with_it_fast_samples_count_less():
    measurement = prepare(record(truth(), seed=1))
    jitter_s, noise = jitter_of([truth()], measurement), noise_of(measurement)
    for channel, values in measurement.modelled(truth()).items():
        speed = np.abs(np.gradient(values, measurement.dt_s))
        assert jitter_s[channel] * np.quantile(speed, 0.95) < 0.3 * noise[channel]
    plain, jittery = (likelihood_of(truth(), measurement, noise, of) for of in ({}, {"force": 0.1}))
    assert np.ptp(jittery.weight["force"]) > 2 * np.ptp(plain.weight["force"])
    np.testing.assert_allclose(jittery.weight["conductance"], plain.weight["conductance"])


@cache
def _example_fitted():
    measurement = prepare(tb.example(duration_s=180))
    return fit(starting_baseline(measurement), measurement).model, measurement
