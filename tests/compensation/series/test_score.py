"""Scores: known answers and their relation to scikit-learn's."""

from __future__ import annotations

import numpy as np
import pytest
from sklearn.metrics import r2_score

from compensation.series import score


def test_r2_takes_the_mean_of_the_prediction():
    assert score.r2(np.array([0.0, 2.0]), np.array([1.0, 3.0])) == pytest.approx(1 - 2 / 4)


def test_r2_is_never_below_sklearns():
    rng = np.random.default_rng(0)
    for _ in range(50):
        truth = rng.normal(size=40)
        guess = truth + rng.normal(rng.normal(), 1, size=40)
        assert score.r2(truth, guess) >= r2_score(truth, guess)


def test_raw_score_is_two_rho_minus_one():
    rng = np.random.default_rng(1)
    truth = rng.normal(size=500)
    raw = -3.0 * truth + rng.normal(size=500)
    rho = np.corrcoef(truth, raw)[0, 1]
    assert score.r2_before(truth, raw, sign=-1.0) == pytest.approx(-2 * rho - 1)
    assert score.rho_squared(truth, raw) == pytest.approx(rho**2)


def test_error_of_two_is_the_papers():
    assert score.error_of_two(0.8, 0.7) == pytest.approx((0.04 + 0.09) / 2)


def test_block_interval_is_wider_for_correlated_errors():
    """The same error variance, once white and once as a slow wave: the interval must know the difference."""
    rng = np.random.default_rng(2)
    time_s = np.arange(0, 1200, 0.05)
    truth = np.sin(time_s)
    white = rng.normal(size=len(time_s))
    slow = np.interp(time_s, np.arange(0, 1260, 60), rng.normal(size=21))
    widths = []
    for error in (white, slow):
        prediction = truth + 0.3 * (error - error.mean()) / error.std()
        low, high = score.block_interval(truth, prediction, time_s)
        assert low < score.r2(truth, prediction) < high
        widths.append(high - low)
    assert widths[1] > 3 * widths[0]


@pytest.mark.parametrize(("duration_s", "has_one"), [(30, False), (99, False), (101, True), (150, True), (310, True)])
def test_a_short_recording_has_shorter_blocks_or_no_interval(duration_s, has_one):
    """Of a single block every draw is the same: an interval without width would promise certainty."""
    time_s = np.arange(0, duration_s, 0.05)
    truth = np.sin(time_s)
    prediction = truth + 0.3 * np.sin(time_s / 5)
    interval = score.block_interval(truth, prediction, time_s)
    assert (interval is not None) == has_one
    assert score.interval_text(interval).replace(".", "").isdigit() == has_one
    if interval is not None:
        assert interval[0] < score.r2(truth, prediction) < interval[1]


def errors_at(time_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A target and a prediction of it, the same at every sample whatever its time."""
    recorded_s = 0.05 * np.arange(len(time_s))
    return np.sin(recorded_s), np.sin(recorded_s) + 0.3 * np.sin(recorded_s / 5)


def test_a_gap_is_no_block():
    """Nothing was recorded there: the interval is that of what was, as if the gap were closed."""
    whole_s = np.arange(0, 300, 0.05)
    paused_s = whole_s + 600.0 * (whole_s > 150)
    expected = score.block_interval(*errors_at(whole_s), whole_s)
    assert score.block_interval(*errors_at(paused_s), paused_s) == pytest.approx(expected, abs=0.02)
    short_s = np.arange(0, 80, 0.05)
    paused_s = short_s + 600.0 * (short_s > 40)
    assert score.block_interval(*errors_at(paused_s), paused_s) is None


def test_blocks_without_a_sample_are_no_blocks():
    time_s = np.array([0.0, 60.0, 120.0])
    assert score.block_interval(*errors_at(time_s), time_s) is None


@pytest.mark.parametrize("count", [3, 4, 5, 8])
def test_an_interval_over_few_recordings_covers_what_it_says(count):
    """Recordings whose errors differ in size: a bootstrap over them covered 70 %."""
    rng, hits, repeats, n = np.random.default_rng(count), 0, 300, 150
    expected = 1 - 0.25 * np.exp(2 * 0.4**2)
    for _ in range(repeats):
        truth = rng.standard_normal((count, n))
        prediction = truth + rng.lognormal(np.log(0.5), 0.4, (count, 1)) * rng.standard_normal((count, n))
        without = [score.r2(np.delete(truth, k, 0), np.delete(prediction, k, 0)) for k in range(count)]
        low, high = score.jackknife_interval(score.r2(truth, prediction), without)
        hits += low <= expected <= high
    assert 0.88 <= hits / repeats <= 0.98
