"""The smoothing bank: known answers, the paper's start, and the time-aware form."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from compensation.memories.ema import smooth, smoothing_factors, start_samples
from gcode.support.errors import UserError

RATE_HZ = 20.0


def paper_loop(x, alpha, initial):
    """The recursion as printed."""
    y = [initial]
    for value in x[1:]:
        y.append(alpha * value + (1 - alpha) * y[-1])
    return np.asarray(y)


def test_start_lengths_are_the_papers():
    assert start_samples(smoothing_factors(), RATE_HZ).tolist() == [1, 1, 1, 2, 5, 13, 31]


def test_no_start_is_longer_than_the_memory():
    """Below 1 Hz the formula would average over more than a filter remembers, at 1e-3 Hz a thousand times as much."""
    alphas = smoothing_factors()
    for rate_hz in (1.0, 0.1, 1e-3):
        assert start_samples(alphas, rate_hz).tolist() == np.ceil(1 / alphas - 1e-9).tolist()


def test_an_exact_quotient_is_not_rounded_up():
    assert start_samples([0.05, 0.025], RATE_HZ).tolist() == [1, 2]


def test_bank_is_the_recursion_of_the_paper():
    x = np.random.default_rng(0).normal(size=200)
    alphas = smoothing_factors()
    got = smooth(x, alphas, RATE_HZ)
    for column, (alpha, count) in enumerate(zip(alphas, start_samples(alphas, RATE_HZ), strict=True)):
        np.testing.assert_allclose(got[:, column], paper_loop(x, alpha, x[:count].mean()), atol=1e-13)


def test_step_response_is_exponential():
    alpha = 0.1
    got = smooth(np.r_[0.0, np.ones(50)], np.array([alpha]), RATE_HZ)[:, 0]
    np.testing.assert_allclose(got, 1 - (1 - alpha) ** np.arange(51), atol=1e-14)


@settings(max_examples=30)
@given(st.integers(2, 300), st.integers(0, 1000), st.sampled_from(["paper", "causal"]))
def test_time_aware_equals_fixed_on_a_uniform_grid(count, seed, start):
    x = np.random.default_rng(seed).normal(size=count)
    alphas, time_s = smoothing_factors(), np.arange(count) / RATE_HZ
    timed = smooth(x, alphas, RATE_HZ, start, step_s=np.diff(time_s))
    np.testing.assert_allclose(timed, smooth(x, alphas, RATE_HZ, start), atol=1e-10)


def test_causal_start_meets_the_papers_after_m_samples():
    x = np.random.default_rng(3).normal(size=100)
    alphas = smoothing_factors()
    paper, causal = (smooth(x, alphas, RATE_HZ, start) for start in ("paper", "causal"))
    last = start_samples(alphas, RATE_HZ).max() - 1
    np.testing.assert_array_equal(paper[last:], causal[last:])
    assert np.abs(paper[:last] - causal[:last]).max() > 0.1


def test_causal_output_never_looks_ahead():
    x = np.random.default_rng(4).normal(size=60)
    changed = x.copy()
    changed[20:] += 1.0
    alphas = smoothing_factors()
    before, after = (smooth(values, alphas, RATE_HZ, "causal") for values in (x, changed))
    np.testing.assert_array_equal(before[:20], after[:20])


def test_gaps_do_not_bend_the_time_aware_bank():
    """A missing stretch of a constant signal leaves the filters where they would have been."""
    time_s = np.r_[np.arange(0, 5, 0.05), np.arange(15, 20, 0.05)]
    x = np.where(time_s < 5, 0.0, 1.0)
    got = smooth(x, np.array([0.01]), RATE_HZ, step_s=np.diff(time_s))[-1, 0]
    # From the first sample after the gap, the whole gap counts as input 1.
    expected = 1 - 0.99 ** ((time_s[-1] - time_s[99]) * RATE_HZ)
    assert got == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize(
    ("factor", "count", "match"), [(1.0, 7, "above 1"), (float("nan"), 7, "above 1"), (2.0, 0, "at least 1 filter")]
)
def test_impossible_banks_are_refused(factor, count, match):
    with pytest.raises(UserError, match=match):
        smoothing_factors(factor, count)
