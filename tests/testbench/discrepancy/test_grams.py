"""The small matrices of the screening answer as least squares on the samples themselves would."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import lsq_linear, nnls

from testbench.discrepancy.experiment import planned
from testbench.discrepancy.grams import BLOCKS, Weighting, grams, nonnegative, reduce_to_traces
from testbench.discrepancy.imitation import bounded
from testbench.discrepancy.measurement import prepare
from tests.testbench.discrepancy.samples import record, truth


@pytest.fixture(scope="module")
def example():
    measurement = prepare(record(truth(), 60))
    rng = np.random.default_rng(0)
    columns = [rng.standard_normal(len(measurement.counts)) for _ in range(6)]
    made = grams({"force": columns}, measurement, Weighting({"force": np.ones(1)}, {"force": 2.0}), base=3)
    centred = np.stack([c[measurement.counts] - c[measurement.counts].mean() for c in columns]) / 2.0
    return made, centred


def test_even_and_odd_blocks_add_up_to_the_whole(example):
    made, centred = example
    np.testing.assert_allclose(made.total, centred @ centred.T, rtol=1e-9, atol=1e-9)
    even = np.concatenate(np.array_split(centred, BLOCKS, axis=1)[::2], axis=1)
    np.testing.assert_allclose(made.even, even @ even.T, rtol=1e-9, atol=1e-9)


def test_a_column_that_does_not_touch_a_channel_adds_nothing_there(example):
    measurement = prepare(record(truth(), 60))
    rng = np.random.default_rng(1)
    first, second = rng.standard_normal((2, len(measurement.counts)))
    ones, unit = {"force": np.ones(1), "conductance": np.ones(1)}, {"force": 1.0, "conductance": 1.0}
    apart = grams({"force": [first, None], "conductance": [None, second]}, measurement, Weighting(ones, unit), base=0)
    counted = second[measurement.counts]
    assert apart.total[0, 1] == 0
    assert apart.total[1, 1] == pytest.approx(np.sum((counted - counted.mean()) ** 2))


def test_elimination_of_the_base_equals_direct_least_squares(example):
    made, centred = example
    total = made.total
    reduced = reduce_to_traces(total, total, 3, np.full(3, 1e-9), np.ones(3, bool), np.zeros(3))
    amounts = np.linalg.solve(reduced.fit[1:, 1:], reduced.fit[1:, 0])
    direct, *_ = np.linalg.lstsq(centred[1:].T, centred[0], rcond=None)
    np.testing.assert_allclose(amounts, direct[3:], rtol=1e-6)
    left = float(np.sum((centred[0] - direct @ centred[1:]) ** 2))
    assert reduced.judged([1, 2], amounts) == pytest.approx(left, rel=1e-6)


def test_a_missing_sensitivity_leaves_its_contribution_in_the_residual(example):
    made, centred = example
    kept, weights = np.array([True, True, False]), np.array([0.0, 0.0, 0.7])
    reduced = reduce_to_traces(made.total, made.total, 3, np.full(3, 1e-9), kept, weights)
    goal = centred[0] + 0.7 * centred[3]
    direct, *_ = np.linalg.lstsq(centred[1:3].T, goal, rcond=None)
    left = float(np.sum((goal - direct @ centred[1:3]) ** 2))
    assert reduced.judged([], np.empty(0)) == pytest.approx(left, rel=1e-6)


@settings(max_examples=40)
@given(st.integers(1, 7), st.integers(0, 10_000))
def test_nonnegative_agrees_with_scipy(count, seed):
    rng = np.random.default_rng(seed)
    a, b = rng.standard_normal((60, count)), rng.standard_normal(60)
    normal = a.T @ a
    # Its small ridge is part of the problem it solves.
    ridged = np.vstack([a, np.diag(np.sqrt(1e-3 * np.diag(normal)))])
    wanted, _ = nnls(ridged, np.r_[b, np.zeros(count)])
    ours = nonnegative(normal, a.T @ b, np.zeros(count, bool))
    np.testing.assert_allclose(ours, wanted, atol=1e-5)
    free = nonnegative(normal, a.T @ b, np.ones(count, bool))
    np.testing.assert_allclose(free, np.linalg.lstsq(ridged, np.r_[b, np.zeros(count)], rcond=None)[0], atol=1e-5)


@settings(max_examples=40)
@given(st.integers(1, 6), st.integers(0, 10_000))
def test_bounded_stays_within_and_is_hardly_worse_than_scipy(count, seed):
    rng = np.random.default_rng(seed)
    a, b = rng.standard_normal((40, count)), rng.standard_normal(40)
    low, high = -rng.uniform(0.01, 0.3, count), rng.uniform(0.01, 0.3, count)
    ours = bounded(a.T @ a, a.T @ b, low, high)
    assert np.all((low <= ours) & (ours <= high))
    best = lsq_linear(a, b, (low, high)).x
    cost = [float(np.sum((b - a @ x) ** 2)) for x in (ours, best)]
    assert cost[0] <= 1.03 * cost[1]


def test_a_planned_measurement_has_the_motion_and_nothing_else():
    class Motion:
        time_s, position_mm, rate_hz = np.arange(200) / 20, np.linspace(0, 5, 200), 20.0

    measurement = planned(Motion(), 25.0, ("force",))
    assert measurement.signals["strain"][-1] == pytest.approx(0.2)
    assert measurement.channels == ("force",)
    assert measurement.counts.sum() == 200 - 60
