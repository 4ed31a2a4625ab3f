"""How much each sample counts."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from testbench.fitting import constants
from testbench.fitting.evidence.evidence import NormalEquations, maximised
from testbench.fitting.evidence.jitter import jitter_of
from testbench.fitting.evidence.laplace import fitted
from testbench.fitting.evidence.likelihood import Likelihood, law_error_of
from testbench.fitting.evidence.sample_noise import likelihood_of, noise_of
from testbench.knit.model import KnitModel
from testbench.measurements.measurement import Measurement
from testbench.measurements.preparing import prepare
from testbench.recordings.recording import Recording
from tests.testbench.builders import CATALOGUE, record, truth


def test_beside_a_true_model_laws_do_not_err_and_of_a_wrong_one_they_leave_a_fifth():
    measurement = prepare(record(truth(), seed=2))
    noise = noise_of(measurement)
    true, wrong = truth(), truth().with_parameters({"elasticity.offset_N": truth()["elasticity"].offset_N + 1.0})
    assert law_error_of(true, likelihood_of(true, measurement, noise))["force"] < 0.1 * noise["force"]
    found = law_error_of(wrong, likelihood_of(wrong, measurement, noise))
    assert found["force"] == pytest.approx(constants.LAW_ERROR * 1.0, rel=0.05)


def test_where_laws_err_much_quiet_samples_count_no_more_than_others():
    measurement = prepare(record(truth(), seed=2))
    noise, jitter_s = noise_of(measurement), {"force": 0.1}
    plain = likelihood_of(truth(), measurement, noise, jitter_s)
    compared = plain.with_law_error({"force": 100 * plain.floor["force"]})
    assert np.ptp(plain.weight["force"]) > 0.2
    assert np.ptp(compared.weight["force"]) < 0.1
    assert compared.weight["force"] == pytest.approx(1.0, abs=0.1)
    # The noise is not larger for that: its mean square over the samples, each by its weight.
    by_sample = plain.floor["force"] / plain.weight["force"]
    assert compared.floor["force"] == pytest.approx(np.sqrt(np.mean(by_sample**2)), rel=0.1)
    np.testing.assert_allclose(compared.weight["conductance"], plain.weight["conductance"])


def test_each_recording_of_a_specimen_brings_its_own_pieces():
    measurement = prepare(record(truth(), 640.0, seed=2))
    one, three = (pieces_of(measurement, runs) for runs in (1, 3))
    assert three == pytest.approx(3 * one)


def pieces_of(measurement: Measurement, runs: int) -> float:
    """Independent samples that a model is compared by."""
    noise = noise_of(measurement)
    return likelihood_of(truth(), measurement, noise, pieces=constants.INDEPENDENT * runs).in_pieces.count


def test_a_filter_that_came_to_rest_hides_no_noise():
    """A thread that hangs loose pulls at nothing, and the filter of the reading forgets what it carried."""
    time_s = np.arange(0, 300, 0.1)
    pulled = time_s % 40 > 24
    force_N = pulled * (1 + np.random.default_rng(0).normal(0, 0.01, len(time_s)))
    for i in range(1, len(force_N)):
        force_N[i] += 0.85 * (force_N[i - 1] - force_N[i])
    strain_mm = 10.0 * np.clip(np.minimum(time_s % 40 - 20, 40 - time_s % 40) / 4, 0, 1)
    recording = Recording(time_s, {"displacement_mm": strain_mm, "force_N": force_N}, 50.0)
    assert 2e-4 < noise_of(prepare(recording))["force"] < 0.01


def test_readings_further_apart_than_the_grid_have_a_jitter_nonetheless():
    """Between them the grid holds straight lines, which show no noise at all."""
    time_s = np.concatenate([np.arange(0, 6, 0.02), 6 + np.arange(0, 600, 3.0)])
    strain = np.minimum(0.25 * time_s, 1.5)
    force_N = 1.5 * strain**0.5 * (1 - 0.1 * np.log1p(np.maximum(time_s - 6, 0)) / np.log(600))
    force_N = np.round(force_N + 1e-3 * np.random.default_rng(0).standard_normal(len(time_s)), 4)
    recording = Recording(time_s, {"displacement_mm": 80 * strain, "force_N": force_N}, 80.0)
    found = jitter_of([truth()], prepare(recording))
    assert 0 <= found["force"] < 0.1


def test_jerks_that_the_displacement_does_not_show_are_jitter_of_the_readings():
    """The machine is ahead of its scale or behind it, for a third of a second each time: 0.1 s of its motion."""
    time_s = np.arange(0, 300, 0.1)
    ahead_s = 0.1 * np.repeat(np.random.default_rng(1).standard_normal(len(time_s) // 3), 3)

    def strain(at_s: np.ndarray) -> np.ndarray:
        return 0.15 + 0.15 * np.sin(2 * np.pi * at_s / 20)

    noise = 1e-3 * np.random.default_rng(2).standard_normal(len(time_s))
    force_N = 2.0 * strain(time_s + ahead_s) + noise
    recording = Recording(time_s, {"displacement_mm": 25 * strain(time_s), "force_N": force_N}, 25.0)
    line = KnitModel({"elasticity": CATALOGUE["elasticity"](stiffness_N=2.0, curvature=0.0, offset_N=0.0)})
    # Robust measures of samples of all speeds say less than there is; without jerks it is a fiftieth of that.
    assert 0.05 < jitter_of([line], prepare(recording))["force"] < 0.12


def test_a_ripple_that_is_the_same_at_the_same_strain_is_no_jerk():
    """The saw-tooth of a worn screw, six turns of which are within the motion; as jitter it would be 0.04 s."""
    time_s = np.arange(0, 300, 0.04)
    strain = 0.15 + 0.1 * np.sin(2 * np.pi * time_s / 20) + 0.05 * np.sin(2 * np.pi * time_s / 7.3)
    noise = 1e-3 * np.random.default_rng(3).standard_normal(len(time_s))
    force_N = 2.0 * (strain + 0.01 * ((strain / 0.045) % 1.0 - 0.5)) + noise
    recording = Recording(time_s, {"displacement_mm": 25 * strain, "force_N": force_N}, 25.0)
    line = KnitModel({"elasticity": CATALOGUE["elasticity"](stiffness_N=2.0, curvature=0.0, offset_N=0.0)})
    assert jitter_of([line], prepare(recording))["force"] < 0.01


def prior_of_noise(
    floors: dict[str, float], explained: dict[str, float] | None = None, whole: dict[str, float] | None = None
) -> float:
    """Log prior of what a complete model leaves; all in noise floors."""
    floor = dict.fromkeys(floors, 1e-3)
    likelihood = Likelihood(SimpleNamespace(), np.arange(10), {}, floor, 1.0)  # type: ignore[arg-type]
    left, by_law, all_of_it = (
        {c: 1e-3 * value for c, value in (one or {}).items()} for one in (floors, explained, whole)
    )
    return likelihood.log_odds_complete(left, by_law, all_of_it)


def test_what_a_complete_model_leaves_is_the_noise_of_one_channel():
    """A half normal density of ln(what is left) over a flat one, by hand."""
    spread, over = constants.NOISE_SPREAD, np.log(1.5 / constants.LEAST_MISFIT)
    half_normal = np.sqrt(2 / np.pi) / spread * np.exp(-0.5 * (over / spread) ** 2)
    assert prior_of_noise({"force": 1.5}) == pytest.approx(np.log(half_normal * np.log(constants.MOST_LEFT)))


def test_a_quiet_channel_does_not_excuse_what_another_leaves():
    assert prior_of_noise({"force": 1.25, "conductance": 1.25}) > 3
    assert prior_of_noise({"force": 1.25, "conductance": 2.7}) < -5
    assert prior_of_noise({"force": 1.25, "conductance": 2.7}, {"conductance": 20.0}) > 0  # an error of the law
    assert (
        prior_of_noise({"force": 1.25, "conductance": 2.7}, {}, {"conductance": 60.0}) > 0
    )  # of all that it changes


def test_what_is_missing_may_leave_a_channel_alone():
    """Else a channel that fits would speak against an effect that never touches it."""
    alone = prior_of_noise({"force": 5.0})
    assert prior_of_noise({"force": 5.0, "conductance": 1.25}) == pytest.approx(alone, abs=1.2)


def test_a_glitch_is_no_noise_of_the_others():
    """One reading in a hundred jumps by 300 standard deviations; what a fit leaves of the others is their noise."""
    clean = record(truth(), seed=4)
    force_N = clean["force_N"].copy()
    force_N[::97] += 3.0
    measurement = prepare(Recording(clean.time_s, {**clean.channels, "force_N": force_N}, 25.0))
    noise = noise_of(measurement)
    found = fitted(truth(), likelihood_of(truth(), measurement, noise), truth())
    assert found.evidence.sigma["force"] == pytest.approx(noise["force"], rel=0.2)
    without = likelihood_of(truth(), prepare(clean), noise)
    # Steps and turns are no glitches: without any, no sample counts less than the noise of its level says.
    assert without.weight["force"].min() > 0.5


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10_000), st.floats(0.01, 100.0), st.floats(1.0, 4.0))
def test_no_law_adds_more_than_the_bound(seed: int, size: float, times: float) -> None:
    """One column beside a residual, whatever its prior and however much of the residual it explains."""
    rng = np.random.default_rng(seed)
    count = 120
    column = rng.standard_normal(count)
    residual = rng.standard_normal(count) + rng.uniform(0, 2) * column
    left = float(np.sqrt(np.mean(residual**2)))
    floor = {"force": left / times / constants.LEAST_MISFIT}
    likelihood = Likelihood(SimpleNamespace(), np.arange(count), {}, floor, 1.0)  # type: ignore[arg-type]

    def evidence(rows: np.ndarray) -> float:
        columns, few = len(rows) - 1, np.ones(len(rows) - 1)
        products, group = {"force": rows @ rows.T}, np.full(columns, -1)
        normal = NormalEquations(products, count, 1.0, likelihood.misfit, 0 * few, few / size**2, group)
        return maximised(normal, iterations=30).value

    added = evidence(np.vstack([residual, column])) - evidence(residual[None])
    assert added <= likelihood.most_added({"force": left}) + 0.01
