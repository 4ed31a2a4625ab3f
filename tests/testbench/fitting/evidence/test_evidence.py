"""The log evidence of a linear model is the one that can be written down."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import multivariate_normal

from testbench.fitting.evidence.evidence import LARGEST, SMALLEST, LogEvidence, NormalEquations, maximised

COUNT, WEIGHTS = 40, 3
SIGMA = {"force": 0.7, "conductance": 0.2}


def linear(seed: int) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray], NormalEquations]:
    """Residual and design matrix of each channel, and the normal equations of both."""
    rng = np.random.default_rng(seed)
    designs = {c: rng.standard_normal((WEIGHTS, COUNT)) for c in SIGMA}
    mean, precision = rng.standard_normal(WEIGHTS), rng.uniform(0.3, 3.0, WEIGHTS)
    weights = mean + rng.standard_normal(WEIGHTS) / np.sqrt(precision)
    residuals = {c: weights @ designs[c] + SIGMA[c] * rng.standard_normal(COUNT) for c in SIGMA}
    columns = {c: np.vstack([residuals[c], designs[c]]) for c in SIGMA}
    normal = NormalEquations(
        {c: rows @ rows.T for c, rows in columns.items()},
        float(COUNT),
        1.0,
        dict.fromkeys(SIGMA, 0.0),
        mean,
        precision,
        np.full(WEIGHTS, -1),
    )
    return residuals, designs, normal


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10_000))
def test_log_evidence_is_that_of_the_gaussian_marginal(seed):
    """ln Z = ln N(r; J m, J P^-1 J' + sigma^2), but for the constant that all models share."""
    residuals, designs, normal = linear(seed)
    found = maximised(normal, sigma=SIGMA, iterations=1)
    design = np.hstack(list(designs.values()))
    noise = np.concatenate([np.full(COUNT, SIGMA[c] ** 2) for c in SIGMA])
    covariance = design.T @ np.diag(1 / normal.precision) @ design + np.diag(noise)
    marginal = multivariate_normal(normal.mean @ design, covariance).logpdf(np.concatenate(list(residuals.values())))
    constant = -0.5 * len(noise) * np.log(2 * np.pi)
    assert found.value == pytest.approx(marginal - constant, abs=1e-8)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10_000))
def test_the_posterior_is_that_of_the_textbook(seed):
    """Bishop, Pattern Recognition and Machine Learning (2006), eq. 3.50 and 3.51."""
    residuals, designs, normal = linear(seed)
    found = maximised(normal, sigma=SIGMA, iterations=1)
    precision = np.diag(normal.precision) + sum(designs[c] @ designs[c].T / SIGMA[c] ** 2 for c in SIGMA)
    goal = normal.precision * normal.mean + sum(designs[c] @ residuals[c] / SIGMA[c] ** 2 for c in SIGMA)
    np.testing.assert_allclose(found.coefficients, np.linalg.solve(precision, goal), rtol=1e-8, atol=1e-10)
    np.testing.assert_allclose(found.covariance, np.linalg.inv(precision), rtol=1e-8, atol=1e-10)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10_000), st.sets(st.integers(0, WEIGHTS - 1)))
def test_coefficients_that_stay_are_integrated_over_as_if_they_were_best_there(seed, still):
    """The log posterior where it is largest with these at zero, and the volume of its Gaussian there."""
    residuals, designs, normal = linear(seed)
    found = maximised(replace(normal, still=np.array(sorted(still), int)), sigma=SIGMA, iterations=1)
    moves = [i for i in range(WEIGHTS) if i not in still]
    curvature = np.diag(normal.precision) + sum(designs[c] @ designs[c].T / SIGMA[c] ** 2 for c in SIGMA)
    goal = normal.precision * normal.mean + sum(designs[c] @ residuals[c] / SIGMA[c] ** 2 for c in SIGMA)
    x = np.zeros(WEIGHTS)
    x[moves] = np.linalg.solve(curvature[np.ix_(moves, moves)], goal[moves])
    misfit = sum(np.sum((residuals[c] - x @ designs[c]) ** 2) / SIGMA[c] ** 2 for c in SIGMA)
    density = -0.5 * misfit - COUNT * sum(np.log(sigma) for sigma in SIGMA.values())
    prior = -0.5 * np.sum(normal.precision * (x - normal.mean) ** 2 - np.log(normal.precision))
    expected = density + prior - 0.5 * np.linalg.slogdet(curvature)[1]
    np.testing.assert_allclose(found.coefficients, x, rtol=1e-8, atol=1e-10)
    assert found.value == pytest.approx(expected, abs=1e-8)
    assert found.value <= maximised(normal, sigma=SIGMA, iterations=1).value + 1e-8


def test_what_is_nearer_than_the_least_is_no_merit():
    """Half of what no weight can explain is taken away: worth something, unless all of it was nearer already."""
    residuals, designs, normal = linear(4)
    nearer = {}
    for c, residual in residuals.items():
        explained = designs[c].T @ np.linalg.lstsq(designs[c].T, residual, rcond=None)[0]
        rows = np.vstack([0.5 * (residual + explained), designs[c]])
        nearer[c] = rows @ rows.T
    closer = replace(normal, products=nearer)
    assert maximised(closer).value > maximised(normal).value + 10
    least = {c: 5 * sigma for c, sigma in SIGMA.items()}
    one, other = (maximised(replace(problem, least=least)) for problem in (normal, closer))
    assert other.value == pytest.approx(one.value, abs=1e-8)
    assert other.sigma == pytest.approx(least)


@given(st.permutations(range(WEIGHTS)))
@settings(max_examples=6, deadline=None)
def test_the_order_of_the_columns_does_not_matter(order):
    _, _, normal = linear(3)
    picked = np.r_[0, np.array(order) + 1]
    changed = {c: gram[np.ix_(picked, picked)] for c, gram in normal.products.items()}
    moved = {key: getattr(normal, key)[list(order)] for key in ("mean", "precision", "group")}
    one, other = maximised(normal), maximised(replace(normal, products=changed, **moved))
    assert other.value == pytest.approx(one.value, abs=1e-8)
    np.testing.assert_allclose(other.coefficients, one.coefficients[list(order)], atol=1e-8)


def test_a_column_that_changes_nothing_costs_nothing():
    """An effect that cannot act: its coefficient stays at its prior, and so does the evidence."""
    _, _, normal = linear(5)
    padded = replace(
        normal,
        products={c: np.pad(gram, (0, 1)) for c, gram in normal.products.items()},
        mean=np.r_[normal.mean, 0.4],
        precision=np.r_[normal.precision, 2.0],
        group=np.r_[normal.group, -1],
    )
    one, other = maximised(normal), maximised(padded)
    assert other.value == pytest.approx(one.value, abs=1e-8)
    assert other.coefficients[-1] == pytest.approx(0.4)


@pytest.mark.parametrize("mean", [0.0, 0.4])
def test_a_group_that_is_switched_off_costs_next_to_nothing_and_stays_at_its_prior_mean(mean):
    residuals, designs, normal = linear(5)
    idle = np.random.default_rng(1).standard_normal((2, COUNT))
    more = {c: np.vstack([residuals[c], designs[c], idle]) for c in SIGMA}
    less = {c: np.vstack([residuals[c] - mean * idle.sum(axis=0), designs[c]]) for c in SIGMA}
    padded = replace(
        normal,
        products={c: rows @ rows.T for c, rows in more.items()},
        mean=np.r_[normal.mean, mean, mean],
        precision=np.r_[normal.precision, 1.0, 1.0],
        group=np.r_[normal.group, 0, 0],
    )
    without = replace(normal, products={c: rows @ rows.T for c, rows in less.items()})
    one = maximised(without, SIGMA, iterations=1)
    other = maximised(padded, SIGMA, iterations=1, scale=np.array([LARGEST]))
    assert other.value == pytest.approx(one.value, abs=0.05)
    np.testing.assert_allclose(other.coefficients, np.r_[one.coefficients, mean, mean], atol=1e-5)
    np.testing.assert_allclose(np.diag(other.covariance)[-2:], 1 / LARGEST, rtol=1e-5)


@pytest.mark.parametrize("weights", [0, WEIGHTS])
def test_with_nothing_switched_on_the_evidence_is_that_of_the_residual(weights):
    """A recording in which the data see nothing of what is free there."""
    residuals, _, normal = linear(5)
    seen = replace(
        normal,
        products={c: gram[: 1 + weights, : 1 + weights] for c, gram in normal.products.items()},
        mean=np.zeros(weights),
        precision=np.ones(weights),
        group=np.zeros(weights, int),
    )
    found = maximised(seen, SIGMA, iterations=1, scale=np.array([LARGEST]) if weights else np.ones(0))
    misfit = sum(np.sum(residuals[c] ** 2) / SIGMA[c] ** 2 + 2 * COUNT * np.log(SIGMA[c]) for c in SIGMA)
    assert found.value == pytest.approx(-0.5 * misfit, abs=0.05)
    np.testing.assert_array_equal(found.coefficients, np.zeros(weights))


def test_the_scale_of_a_group_is_found_by_the_evidence():
    """A thousand weights of one size, well determined: their scale is the size that they were drawn with."""
    rng = np.random.default_rng(0)
    count, size = 1000, 0.05
    weights = size * rng.standard_normal(count)
    residual, design = weights + 1e-3 * rng.standard_normal(count), np.eye(count)
    rows = np.vstack([residual, design])
    normal = NormalEquations(
        {"force": rows @ rows.T}, 1000.0, 1.0, {"force": 1e-3}, np.zeros(count), np.ones(count), np.zeros(count, int)
    )
    found = maximised(normal, sigma={"force": 1e-3}, iterations=40, scale=np.ones(1))
    assert found.scale[0] ** -0.5 == pytest.approx(size, rel=0.05)


def grouped(seed: int) -> NormalEquations:
    """All weights share one scale."""
    _, _, normal = linear(seed)
    return replace(normal, mean=np.zeros(WEIGHTS), precision=np.full(WEIGHTS, 25.0), group=np.zeros(WEIGHTS, int))


def with_known_scale(normal: NormalEquations, noise: LogEvidence, factor: float) -> float:
    """ln Z where the scale is known as well as the noise."""
    known = replace(normal, precision=factor * normal.precision, group=np.full(WEIGHTS, -1))
    return maximised(known, sigma=noise.sigma, iterations=1).value


def test_the_scale_of_a_group_of_a_typical_size_is_the_maximum_with_cauchys_prior():
    """On a grid of scales: ln Z of the Gaussian marginal plus ln(tau / (1 + tau^2)), the density of ln(tau)."""
    free = grouped(5)
    said = maximised(replace(free, typical_groups=frozenset({0})), iterations=200, scale=np.ones(1))
    grid = np.geomspace(0.1, 10, 41) * said.scale[0]
    believed = [with_known_scale(free, said, factor) - np.log(factor**-0.5 + factor**0.5) for factor in grid]
    assert grid[np.argmax(believed)] == pytest.approx(said.scale[0], rel=0.13)
    assert maximised(free, iterations=200, scale=np.ones(1)).scale[0] < said.scale[0]


@pytest.mark.parametrize("size", [0.0, 0.1, 1.0, 8.0])
def test_the_evidence_of_a_group_of_a_typical_size_is_the_integral_over_cauchys_prior(size):
    """Twelve weights of this many typical sizes, the noise known: by the trapezoidal rule over ln(tau)."""
    rng = np.random.default_rng(0)
    count, samples, typical = 12, 400, 0.05
    design = 10 * rng.standard_normal((count, samples))
    residual = size * typical * rng.standard_normal(count) @ design + rng.standard_normal(samples)
    rows = np.vstack([residual, design])
    prior = np.zeros(count), np.full(count, typical**-2), np.zeros(count, int)
    normal = NormalEquations({"force": rows @ rows.T}, samples, 1.0, {"force": 1e-9}, *prior, frozenset({0}))
    scale = np.ones(1)
    for _ in range(200):
        found = maximised(normal, {"force": 1.0}, iterations=1, scale=scale)
        scale = found.scale
    tau = np.geomspace(1e-3, 1e3, 1201)
    free = replace(normal, group=np.full(count, -1))
    known = [maximised(replace(free, precision=(t * typical) ** -2 * np.ones(count)), {"force": 1.0}, 1) for t in tau]
    values = np.array([one.value for one in known]) + np.log(2 / np.pi * tau / (1 + tau**2))
    whole = values.max() + np.log(np.trapezoid(np.exp(values - values.max()), np.log(tau)))
    assert found.value == pytest.approx(whole, abs=1.0)


@pytest.mark.parametrize("seed", range(4))
def test_the_evidence_of_a_found_scale_is_that_of_all_scales_together(seed):
    """ln of the mean of Z over a flat prior of ln(precision), by the trapezoidal rule."""
    free = grouped(seed)
    found = maximised(free, iterations=200, scale=np.ones(1))
    grid = np.geomspace(SMALLEST, LARGEST, 2001)
    values = np.array([with_known_scale(free, found, factor) for factor in grid])
    mean = np.log(np.mean(np.exp(values - values.max()))) + values.max()
    assert found.value == pytest.approx(mean, abs=1.0)
    assert values.max() > mean + 1.5, "what is found is not known"
