"""The step of Levenberg-Marquardt: the best within bounds, and shortened until the cost falls."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import lsq_linear

from testbench.fitting.downhill import HUBER, downhill, huber, huber_weight, within


@settings(max_examples=40)
@given(st.integers(1, 4), st.integers(0, 5), st.integers(0, 10_000))
def test_a_step_within_bounds_is_the_best_there_is(tied, free, seed):
    rng = np.random.default_rng(seed)
    a, b = rng.standard_normal((40, tied + free)), rng.standard_normal(40)
    low, high = np.full(tied + free, -np.inf), np.full(tied + free, np.inf)
    where = rng.permutation(tied + free)[:tied]
    low[where], high[where] = -rng.uniform(0.01, 0.2, tied), rng.uniform(0.01, 0.2, tied)
    best = lsq_linear(a, b, (low, high), tol=1e-14).x
    np.testing.assert_allclose(within(a.T @ a, a.T @ b, low, high), best, atol=1e-6)


def test_no_step_is_taken_where_none_lowers_the_cost():
    assert downhill(lambda damping: np.array([1 / damping]), lambda step: 1 + float(step @ step), 1.0, 1e-3) is None


def test_the_step_is_shortened_until_it_does():
    found = downhill(lambda damping: np.array([1 / (1 + damping)]), lambda step: abs(float(step[0]) - 0.1), 0.1, 1.0)
    assert found is not None
    assert found.cost < 0.1
    assert found.damping == 10


def test_huber_is_square_within_and_straight_beyond():
    z = np.array([0.0, 1.0, HUBER, 10.0])
    np.testing.assert_allclose(huber(z), [0, 0.5, HUBER**2 / 2, HUBER * (10 - HUBER / 2)])
    slope = (huber(z + 1e-6) - huber(np.maximum(z - 1e-6, 0))) / 2e-6
    np.testing.assert_allclose(slope[1:], (huber_weight(z) * z)[1:], rtol=1e-6)
    assert slope[3] == pytest.approx(HUBER)
