"""Loops over samples against closed forms and against the plainest way to compute the same."""

from __future__ import annotations

import numpy as np
import pytest
from worlds_fourth import operators
from worlds_fourth.kernels import followers, friction, jaws, preisach

CYCLES = np.concatenate([np.interp(np.linspace(0, 6, 1801), range(7), [0, 1, 0, 0.7, 0.2, 1, 0])])


def test_a_filter_is_exact_for_a_step_at_any_time_step() -> None:
    for count in (11, 1001):
        time_s = np.linspace(0, 10, count)
        out = operators.lowpass(np.ones(count), time_s, 3.0, 0.0)
        np.testing.assert_allclose(out, 1 - np.exp(-time_s / 3.0), atol=1e-12)


def test_what_a_filter_leaves_of_a_level_is_nothing() -> None:
    time_s = np.linspace(0, 10, 101)
    np.testing.assert_allclose(operators.highpass(np.full(101, 2.5), time_s, 3.0), 0.0, atol=1e-12)


def test_play_is_late_by_its_half_width_and_stands_still_at_a_turn() -> None:
    x = np.concatenate([np.linspace(0, 1, 101), np.linspace(1, 0.5, 51)[1:]])
    out = operators.play(x, 0.1, 0.0)
    assert out[100] == pytest.approx(0.9)
    assert out[120] == pytest.approx(0.9)  # x is 0.8 there: the gap is just crossed
    assert out[-1] == pytest.approx(0.6)


def test_plays_are_those_of_one_after_the_other_from_a_virgin_state() -> None:
    widths, weights = np.array([0.05, 0.1, 0.3]), np.array([0.2, 0.5, 0.3])
    each = sum(w * operators.play(CYCLES, float(r), 0.0) for r, w in zip(widths, weights, strict=True))
    np.testing.assert_allclose(friction.plays(CYCLES, widths, weights), each, atol=1e-12)


def test_dahl_comes_to_one_on_the_way_out_and_to_minus_one_on_the_way_back() -> None:
    out = friction.dahl(CYCLES, 0.05)
    np.testing.assert_allclose(out[:300], 1 - np.exp(-CYCLES[:300] / 0.05), atol=1e-12)
    assert out[599] == pytest.approx(-1.0, abs=1e-6)


def test_bouc_and_wen_with_a_power_of_one_is_dahl() -> None:
    np.testing.assert_allclose(
        friction.bouc_wen(CYCLES, 0.05, 1.0, 0.5)[:300], friction.dahl(CYCLES, 0.05)[:300], atol=0.01
    )


def test_sliding_springs_slide_at_their_reaches() -> None:
    reaches = np.array([0.1, 0.2])
    out = friction.sliding_springs(CYCLES, reaches, np.ones(2))
    assert out[300] == pytest.approx(0.3)
    assert out[600] == pytest.approx(-0.3)


def test_a_relay_keeps_its_state_between_its_levels() -> None:
    x = np.array([0.0, 0.5, 1.0, 0.5, 0.0, 0.5])
    np.testing.assert_array_equal(friction.switched(x, 0.8, 0.2, 0.0), [0, 0, 1, 1, 0, 0])


def test_relays_by_turning_points_are_those_of_one_relay_after_the_other() -> None:
    """With the weight d^2 the density of relays is even: 2 for every pair of levels."""
    x = np.interp(np.linspace(0, 7, 701), range(8), [0, 0.8, 0.2, 0.6, 0.3, 1.0, 0.1, 0.5])
    levels = (np.arange(200) + 0.5) / 200
    up, down = (grid.ravel() for grid in np.meshgrid(levels, levels))
    up, down = up[up >= down], down[up >= down]
    on, counted = np.zeros(len(up), dtype=bool), []
    for value in x:
        on = (on | (value >= up)) & (value > down)
        counted.append(2 * on.sum() / 200**2)
    np.testing.assert_allclose(preisach.preisach(x, 2.0, 0.0), counted, atol=0.02)


def test_contacts_age_at_rest_and_are_young_after_sliding() -> None:
    ages = followers.age(np.r_[np.zeros(100), np.full(100, 5.0)], np.full(200, 0.1))
    assert ages[99] == pytest.approx(11.0)
    assert ages[-1] == pytest.approx(0.2)


def test_a_conductor_without_feedback_comes_to_the_temperature_of_its_power() -> None:
    warm = followers.heat(np.full(2000, 0.4), np.full(2000, 0.1), np.zeros(2000), 10.0, 0.0, 1.0, 0.0)
    assert warm[99] == pytest.approx(np.exp(0.4) * (1 - np.exp(-1.0)))
    assert warm[-1] == pytest.approx(np.exp(0.4))


def test_a_jaw_that_gives_way_keeps_the_strain_at_its_limit() -> None:
    position = np.concatenate([np.linspace(0, 5, 51), np.linspace(5, 0, 51)])
    slipped = jaws.slip_above(position, 25.0, 0.1)
    strain = (position - slipped) / (25.0 + slipped)
    assert strain.max() == pytest.approx(0.1)
    assert np.all(np.diff(slipped) >= 0)
    assert slipped[-1] == slipped[50]
