"""What a recording tells about which hypothesis holds, against closed forms and simulation."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from testbench.design.information import Prediction, information
from tests.testbench.design.monte_carlo import sampled_information

NONE = np.zeros((1, 0))


def at(*values: float, factor=None) -> Prediction:
    mean = np.array(values, float)
    return Prediction(mean, np.zeros((len(mean), 0)) if factor is None else np.asarray(factor, float))


def exact_of_two(distance: float, p: float) -> float:
    """Mutual information of two unit Gaussians so far apart, by quadrature."""

    def integrand(y: float) -> float:
        one = np.exp(-0.5 * y * y) / np.sqrt(2 * np.pi)
        two = np.exp(-0.5 * (y - distance) ** 2) / np.sqrt(2 * np.pi)
        both = p * one + (1 - p) * two
        return sum(w * d * np.log(d / both) for w, d in ((p, one), (1 - p, two)) if d > 0)

    return quad(integrand, -12, 12 + distance, limit=200)[0]


@pytest.mark.parametrize("distance", [0.1, 0.5, 1.0, 2.0, 4.0, 8.0])
@pytest.mark.parametrize("p", [0.5, 0.9])
def test_the_bounds_hold_the_exact_information_of_two_gaussians(distance, p):
    found = information([at(0.0), at(distance)], [p, 1 - p])
    exact = exact_of_two(distance, p)
    assert found.low <= exact + 1e-9
    assert exact <= found.high + 1e-9
    # The bound below is that of the Bhattacharyya distance d^2 / 8 in closed form.
    near = np.exp(-(distance**2) / 8)
    closed = -p * np.log(p + (1 - p) * near) - (1 - p) * np.log(1 - p + p * near)
    assert found.low == pytest.approx(closed, rel=1e-9)


def test_small_differences_of_a_linear_gaussian_model_tell_what_the_closed_form_says():
    """Rivals a x against 0 with a ~ N(m, s^2): the reading N(m x, 1 + s^2 x x^T) against N(0, 1)."""
    x = np.array([[0.3], [-0.2], [0.5]])
    m, s = 0.4, 0.7
    one, other = at(0, 0, 0), Prediction(m * x[:, 0], s * x)
    size = float(x[:, 0] @ x[:, 0])
    variance = 1 + s * s * size
    middle = (1 + variance) / 2
    distance = m * m * size / 8 / middle + 0.5 * np.log(middle / np.sqrt(variance))
    near = np.exp(-distance)
    assert information([one, other], [1, 1]).low == pytest.approx(-np.log(0.5 + 0.5 * near), rel=1e-9)


def test_a_motion_without_information_about_the_difference_has_none():
    """The rivals differ, but not in what this motion shows; and what their parameters leave open is the same."""
    factor = np.array([[0.4, 0.1], [0.0, 1.3], [2.0, 0.0]])
    same = [Prediction(np.array([1.0, 2.0, 3.0]), factor) for _ in range(3)]
    found = information(same, [0.5, 0.3, 0.2])
    assert found.low == pytest.approx(0.0, abs=1e-12)
    assert found.high == pytest.approx(0.0, abs=1e-9)


def test_a_difference_that_the_parameters_can_imitate_tells_nothing():
    """A mean difference along a direction in which both rivals are free to move."""
    free = 1e4 * np.array([[1.0], [2.0], [-1.0]])
    apart = information([at(0, 0, 0), at(1, 2, -1)], [1, 1])
    imitated = information([at(0, 0, 0, factor=free), at(1, 2, -1, factor=free)], [1, 1])
    assert apart.low > 0.1
    assert imitated.high < 1e-6


def test_what_is_surely_told_is_ranked_by_the_doubt_that_stays():
    near, far = (information([at(0.0), at(d)], [1, 1]) for d in (20.0, 40.0))
    assert near.low == pytest.approx(np.log(2), rel=1e-9)
    assert 0 < far.conditional_entropy < near.conditional_entropy < 1e-12


@settings(max_examples=25, deadline=None)
@given(
    seed=st.integers(0, 2**31),
    rivals=st.integers(2, 4),
    size=st.integers(1, 8),
    free=st.integers(0, 3),
    spread=st.sampled_from([0.1, 1.0, 3.0]),
)
def test_simulation_lies_between_the_bounds(seed, rivals, size, free, spread):
    """The same rivals weighed by their marginal likelihoods of drawn readings."""
    rng = np.random.default_rng(seed)
    predictions = [
        Prediction(spread * rng.standard_normal(size), spread * rng.standard_normal((size, free)))
        for _ in range(rivals)
    ]
    probabilities = rng.dirichlet([2.0] * rivals)
    found = information(predictions, probabilities)
    told = sampled_information(predictions, probabilities, rng, draws=4000)
    slack = 0.06  # of 4000 draws
    assert found.low - slack <= told <= found.high + slack
    assert 0 <= found.low <= found.high + 1e-9 <= -float(probabilities @ np.log(probabilities)) + 2e-9


@pytest.mark.parametrize("place", [0, 1, 2])
def test_what_cannot_be_tells_nothing(place):
    likely, chances = [at(0.0, 1.0), at(2.0, 1.0)], [0.7, 0.3]
    alone = information(likely, chances)
    likely.insert(place, at(50.0, -3.0, factor=[[1.0], [2.0]]))
    chances.insert(place, 0.0)
    assert vars(information(likely, chances)) == pytest.approx(vars(alone))
