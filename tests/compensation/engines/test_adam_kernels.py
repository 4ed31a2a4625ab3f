"""Tiles of 4 x 4 units, and what is left beside them, are matrix products."""

from __future__ import annotations

import numpy as np
import pytest

from compensation.engines.adam_kernels import add_products, correlate

BEFORE, AFTER, ROWS = 3, 2, 21


@pytest.fixture(params=range(1, 10), ids=lambda n_in: f"in{n_in}")
def case(request):
    """For each number of outputs: weights inside a longer vector, and rows that are wider and more than needed."""
    rng = np.random.default_rng(request.param)
    n_in = request.param
    return [
        (
            rng.normal(size=BEFORE + n_in * n_out + AFTER),
            rng.normal(size=(n_in + 1, 24)),
            rng.normal(size=(n_out, 24)),
        )
        for n_out in range(1, 10)
    ]


def test_forward_products(case):
    for flat, values, out in case:
        n_in, n_out = len(values) - 1, len(out)
        weights = flat[BEFORE:-AFTER].reshape(n_in, n_out)
        expected = out.copy()
        expected[:, :ROWS] += weights.T @ values[:n_in, :ROWS]
        add_products(flat, BEFORE, n_out, 1, values, n_in, out, n_out, ROWS)
        np.testing.assert_allclose(out, expected, rtol=0, atol=1e-13)


def test_backward_products(case):
    for flat, back, step in case:
        n_in, n_out = len(back) - 1, len(step)
        weights = flat[BEFORE:-AFTER].reshape(n_in, n_out)
        expected = back.copy()
        expected[:n_in, :ROWS] += weights @ step[:, :ROWS]
        add_products(flat, BEFORE, 1, n_out, step, n_out, back, n_in, ROWS)
        np.testing.assert_allclose(back, expected, rtol=0, atol=1e-13)


def test_gradient(case):
    for gradient, values, step in case:
        n_in, n_out = len(values) - 1, len(step)
        expected = gradient.copy()
        expected[BEFORE:-AFTER] = (values[:n_in, :ROWS] @ step[:, :ROWS].T).ravel()
        correlate(gradient, BEFORE, values, n_in, step, n_out, ROWS)
        np.testing.assert_allclose(gradient, expected, rtol=0, atol=1e-13)
