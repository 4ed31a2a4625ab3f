"""The one Levenberg-Marquardt: a bounded problem solved as scipy does, and a step shortened until the cost falls."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import least_squares, lsq_linear

from testbench.fitting.downhill import HUBER, Linearised, downhill, huber, huber_weight, minimised, within


class Curve:
    """Sum of squares of ``f(x) - goal`` between bounds."""

    def __init__(self, f, jacobian, goal, low, high):
        self.f, self.jacobian, self.goal, self.low, self.high = f, jacobian, goal, low, high

    def cost(self, x):
        return 0.5 * float(np.sum((self.goal - self.f(x)) ** 2))

    def linearised(self, x):
        rows, left = self.jacobian(x), self.goal - self.f(x)
        return Linearised(rows.T @ rows, rows.T @ left, self.cost(x))


@settings(max_examples=40)
@given(st.integers(1, 6), st.integers(0, 10_000))
def test_a_linear_problem_between_bounds_is_solved_as_scipy_does(count, seed):
    rng = np.random.default_rng(seed)
    a, b = rng.standard_normal((40, count)), rng.standard_normal(40)
    low, high = -rng.uniform(0.01, 0.3, count), rng.uniform(0.01, 0.3, count)
    problem = Curve(lambda x: a @ x, lambda _: a, b, low, high)
    ours, _, _ = minimised(problem, np.zeros(count), 200, 1e-12, quiet=3)
    assert np.all((low <= ours) & (ours <= high))
    best = lsq_linear(a, b, (low, high), tol=1e-12).x
    assert problem.cost(ours) <= problem.cost(best) * (1 + 1e-6)


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


def test_rosenbrock_is_solved_from_its_usual_start():
    problem = Curve(
        lambda x: np.array([10 * (x[1] - x[0] ** 2), 1 - x[0]]),
        lambda x: np.array([[-20 * x[0], 10.0], [-1.0, 0.0]]),
        np.zeros(2),
        np.full(2, -5.0),
        np.full(2, 5.0),
    )
    x, here, tries = minimised(problem, np.array([-1.2, 1.0]), 200, 1e-15)
    np.testing.assert_allclose(x, 1.0, rtol=1e-6)
    assert here.cost < 1e-12
    reference = least_squares(problem.f, [-1.2, 1.0], problem.jacobian, method="lm")
    assert tries < 3 * reference.nfev


def test_no_step_is_taken_where_none_lowers_the_cost():
    assert downhill(lambda damping: np.array([1 / damping]), lambda step: 1 + float(step @ step), 1.0, 1e-3) is None


def test_the_step_is_shortened_until_it_does():
    found = downhill(lambda damping: np.array([1 / (1 + damping)]), lambda step: abs(float(step[0]) - 0.1), 0.1, 1.0)
    assert found is not None
    assert found.cost < 0.1
    assert found.tries == 2
    assert found.damping == 8


def test_huber_is_square_within_and_straight_beyond():
    z = np.array([0.0, 1.0, HUBER, 10.0])
    np.testing.assert_allclose(huber(z), [0, 0.5, HUBER**2 / 2, HUBER * (10 - HUBER / 2)])
    slope = (huber(z + 1e-6) - huber(np.maximum(z - 1e-6, 0))) / 2e-6
    np.testing.assert_allclose(slope[1:], (huber_weight(z) * z)[1:], rtol=1e-6)
    assert slope[3] == pytest.approx(HUBER)
