"""The small problem inside an imitation, and the measurement that was not made yet."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import lsq_linear

from testbench.design.experiment import planned
from testbench.design.imitation import bounded


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
