"""Loops over samples against closed forms and against the plainest way to compute the same."""

from __future__ import annotations

import numpy as np
import pytest
from worlds_third import kernels


def test_a_follower_is_exact_for_a_step_at_any_time_step() -> None:
    for count in (11, 1001):
        time_s = np.linspace(0, 10, count)
        out = kernels.follow(np.ones(count), np.diff(time_s, prepend=0.0), 3.0, 5.0, 0.0)
        np.testing.assert_allclose(out, 1 - np.exp(-time_s / 3.0), atol=1e-12)


def test_a_bank_of_contacts_is_that_of_one_contact_after_the_other() -> None:
    rng = np.random.default_rng(3)
    x = np.sin(np.cumsum(rng.normal(size=3000)) * 0.02)
    closes = rng.uniform(-1, 1, 40)
    opens = closes - rng.uniform(0, 0.4, 40)
    weights = rng.uniform(0.1, 1.0, 40)
    on = closes <= x[0]
    expected = []
    for value in x:
        on = np.where(value >= closes, True, np.where(value <= opens, False, on))
        expected.append(weights[on].sum())
    np.testing.assert_allclose(kernels.relays(x, closes, opens, weights), expected, atol=1e-12)


def test_the_oscillator_settles_where_statics_says_and_rings_at_its_frequency() -> None:
    time_s = np.arange(0, 20, 0.01)
    out = kernels.oscillator(np.ones(len(time_s)), np.diff(time_s, prepend=0.0), 1.0, 0.1)
    rest = 1 / (2 * np.pi) ** 2
    assert out[-1] == pytest.approx(rest, rel=1e-4)
    rises = time_s[1:][np.diff(np.sign(out - rest)) > 0]
    assert np.diff(rises[:5]).mean() == pytest.approx(1 / np.sqrt(1 - 0.1**2), rel=0.01)


def test_half_strokes_are_those_of_a_triangle() -> None:
    x = np.interp(np.linspace(0, 4, 401), range(5), [0, 1, 0.4, 0.9, 0])
    found = kernels.half_strokes(x, 0.03)
    np.testing.assert_allclose(found[found > 0], [1.0, 0.6, 0.5], atol=0.02)


def test_contacts_age_in_a_hold_and_are_young_after_a_move() -> None:
    x = np.concatenate([np.zeros(100), np.linspace(0, 1, 100)])
    age = kernels.ageing(x, np.full(200, 0.1), 0.05)
    assert age[99] == pytest.approx(11.0, abs=0.2)
    assert age[-1] == pytest.approx(0.1 / (1 / 99 / 0.05), rel=0.05)
