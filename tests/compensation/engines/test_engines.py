"""The compiled engine is scikit-learn's training, and the fast one is no worse."""

from __future__ import annotations

import numpy as np
import pytest

from compensation.engines.engine import ENGINES
from compensation.series.score import r2


def problem(rows: int = 1500, columns: int = 5):
    """A smooth nonlinear target with a little noise."""
    rng = np.random.default_rng(7)
    features = rng.normal(size=(rows, columns))
    target = np.tanh(features[:, 0]) + 0.5 * features[:, 1] * features[:, 2] + 0.05 * rng.normal(size=rows)
    return features, (target - target.mean()) / target.std()


@pytest.mark.parametrize("sizes", [(4, 2, 2), (6,), (16, 8), (3, 3, 3, 3), (21, 14, 11)])
@pytest.mark.parametrize(("seed", "l2"), [(0, 1e-4), (11, 1.0)])
def test_exact_engine_reproduces_the_loss_curve(sizes, seed, l2):
    features, target = problem()
    reference, ours = (ENGINES[name](features, target, sizes, seed, l2) for name in ("sklearn", "exact"))
    assert len(reference.loss_curve) == len(ours.loss_curve) > 10
    np.testing.assert_allclose(ours.loss_curve, reference.loss_curve, rtol=0, atol=1e-10)
    np.testing.assert_allclose(ours.network(features), reference.network(features), atol=1e-8)


@pytest.mark.parametrize("rows", [333, 50])
def test_a_batch_that_does_not_divide_the_rows_or_is_more_than_all(rows):
    features, target = problem(rows)
    reference, ours = (ENGINES[name](features, target, (4, 2), 3, 1e-4) for name in ("sklearn", "exact"))
    np.testing.assert_allclose(ours.loss_curve, reference.loss_curve, rtol=0, atol=1e-10)


def test_fast_engine_is_near_on_repetitive_data():
    features, target = problem(rows=30_000)
    exact, fast = (ENGINES[name](features, target, (16, 8), 0, 1e-4) for name in ("exact", "fast"))
    assert r2(target, fast.network(features)) > r2(target, exact.network(features)) - 0.03
