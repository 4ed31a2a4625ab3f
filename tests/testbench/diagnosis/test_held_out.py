"""Intervals of a fall of the held-out error."""

from __future__ import annotations

import numpy as np
import pytest

from testbench.diagnosis.held_out import gain_interval


def test_the_same_fall_everywhere_is_certain():
    energy = {"force": np.arange(1.0, 21.0), "conductance": np.ones(20)}
    half = {channel: values / 4 for channel, values in energy.items()}
    assert gain_interval(energy, half) == pytest.approx((np.log(4),) * 3)


def test_a_fall_in_some_blocks_only_is_uncertain_and_covers_the_truth():
    """Blocks fall by e on average (log-normal ratios): the interval covers that in about 95 of 100 draws."""
    rng = np.random.default_rng(7)
    hits, widths = 0, []
    for _ in range(200):
        before = np.ones(25)
        after = np.exp(-1 + 0.5 * rng.standard_normal(25) - 0.125)
        _, low, high = gain_interval({"force": before}, {"force": after})
        hits += low < 1.0 < high
        widths.append(high - low)
    assert 0.88 <= hits / 200 <= 0.99
    assert np.mean(widths) == pytest.approx(4 * 0.53 / 5, rel=0.15)


def test_an_interval_from_few_blocks_covers_the_truth():
    """Eight blocks, as a recording of three minutes has: a plain bootstrap covers 86 of 100."""
    rng = np.random.default_rng(8)
    hits = 0
    for _ in range(400):
        after = np.exp(-1 + 0.5 * rng.standard_normal(8) - 0.125)
        _, low, high = gain_interval({"force": np.ones(8)}, {"force": after})
        hits += low < 1.0 < high
    assert 0.9 <= hits / 400 <= 0.98
