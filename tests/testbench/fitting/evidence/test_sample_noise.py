"""The noise that each sample is taken to have."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from testbench.fitting.evidence.independent_samples import telling
from testbench.fitting.evidence.sample_noise import _noise_by_level, likelihood_of, noise_of
from testbench.measurements.preparing import prepare
from tests.testbench.builders import NOISE_N, record, truth


@pytest.mark.parametrize("gap_s", [60.0, 200.0, 3600.0])
def test_a_gap_makes_no_sample_precise(gap_s):
    whole = record(truth(), 180.0)
    later = whole.time_s + gap_s * (whole.time_s > 90)
    broken = telling(prepare(replace(whole, time_s=later)))
    judged = likelihood_of(truth(), broken, noise_of(broken))
    noise_N = judged.floor["force"] / judged.weight["force"]
    assert judged.floor["force"] == pytest.approx(NOISE_N, rel=0.1)
    assert noise_N.min() > 0.75 * NOISE_N


def test_readings_that_are_all_far_apart_are_alike():
    whole = record(truth(), 180.0)
    kept = np.cumsum(np.random.default_rng(0).integers(1, 9, len(whole)))
    kept = kept[kept < len(whole)]
    sparse = replace(whole, time_s=whole.time_s[kept], channels={c: v[kept] for c, v in whole.channels.items()})
    measurement = telling(prepare(sparse))
    judged = likelihood_of(truth(), measurement, noise_of(measurement))
    assert all(np.all(np.isfinite(weight)) for weight in judged.weight.values())


def test_noise_is_never_nothing():
    """Where most readings are one, and no rounding is known."""
    values = np.r_[np.linspace(0.0, 1.0, 60), np.full(400, 1.0), 1.0 + np.random.default_rng(0).random(60)]
    assert np.all(_noise_by_level(values, np.ones(len(values), bool), 0.0) > 0)


def test_an_instrument_that_rounds_is_as_good_as_its_rounding_at_every_level():
    """Where little moves no two readings differ; where much moves many do, by one step."""
    whole = record(truth(), 180.0, channels=("force_N",), noise=0.0)
    step_N = 0.04
    rounded = step_N * np.round(whole["force_N"] / step_N)
    measurement = telling(prepare(replace(whole, channels={**whole.channels, "force_N": rounded})))
    judged = likelihood_of(truth(), measurement, noise_of(measurement))
    noise_N = judged.floor["force"] / judged.weight["force"]
    assert np.quantile(noise_N, [0.05, 0.5, 0.8]) == pytest.approx(step_N / 12**0.5, rel=0.35)


def test_the_noise_of_the_displacement_counts_where_friction_sticks():
    """Behind a turn the force follows the strain more steeply than the curve that friction slips along."""
    stiff = truth().with_parameters({"elasticity.stiffness_N": 6.0, "hysteresis.friction_N": 2.0})
    whole = record(stiff, 180.0, channels=("force_N",), noise=0.01)
    moved_mm = 0.01 * np.random.default_rng(0).normal(size=len(whole))
    shaken = {**whole.channels, "displacement_mm": whole["displacement_mm"] + moved_mm}
    measurement = telling(prepare(replace(whole, channels=shaken)))
    judged = likelihood_of(stiff, measurement, noise_of(measurement))
    noise_N = judged.floor["force"] / judged.weight["force"]
    off = measurement.residual(stiff)["force"][judged.rows] / noise_N
    steep = noise_N > np.quantile(noise_N, 0.8)
    assert np.sqrt(np.mean(off[steep] ** 2)) == pytest.approx(1.0, rel=0.3)
    assert np.sqrt(np.mean(off[~steep] ** 2)) == pytest.approx(1.0, rel=0.3)
