"""Contacts that age between turns, against closed-form answers."""

from __future__ import annotations

import numpy as np
import pytest

from testbench.knit.conduction.turning import ContactAgeing, ElectricalOvershootTurn, since_turn_s
from testbench.knit.kernels import turns

DT_S = 0.05
T = np.arange(0, 60, DT_S)
TRIANGLE = 0.1 * np.abs((T / 10 + 1) % 2 - 1)  # turns at 10, 20, ... s


def test_a_turn_is_dated_back_to_the_extreme_once_it_is_known() -> None:
    x = np.array([0.0, 1.0, 2.0, 3.0, 2.0, 1.0, 0.0, 1.0, 2.0, 3.0])
    since_s, turned_at, has_turned = since_turn_s(x, 0.5, 1.0)
    np.testing.assert_allclose(since_s, [0, 1, 2, 3, 1, 2, 3, 1, 2, 3])
    np.testing.assert_array_equal(turned_at, [0, 0, 0, 0, 3, 3, 3, 6, 6, 6])
    np.testing.assert_array_equal(has_turned, np.arange(10) >= 4)
    known_s, _, _ = since_turn_s(x, 0.5, 1.0, early=0.0)
    np.testing.assert_allclose(known_s, [0, 1, 2, 3, 0.5, 1.5, 2.5, 0.5, 1.5, 2.5])


def test_a_turn_lies_between_samples() -> None:
    x = -((np.arange(12) - 5.3) ** 2)
    since_s, _, _ = since_turn_s(x, 2.0, 0.1)
    np.testing.assert_allclose(since_s[7:], 0.1 * (np.arange(7, 12) - 5.3))


def test_wobbles_below_the_threshold_are_no_turns() -> None:
    x = 0.3 * T / T[-1] + 0.001 * np.sin(9 * T)
    np.testing.assert_allclose(since_turn_s(x, 0.01, 1.0)[0], np.arange(len(x)))


def test_ageing_is_the_logarithm_of_the_time_since_the_turn() -> None:
    effect = ContactAgeing(gain=0.2, tau_s=2.0, back=0.005)
    out = effect.apply({"strain": TRIANGLE, "conductance_S": np.ones_like(T)}, DT_S)["conductance_S"]
    # 0.5 s after a turn it is known (0.005 at 0.01 / s)
    later = (T > 10.6) & ((T % 10) > 0.6)
    np.testing.assert_allclose(np.log(out[later]), 0.2 * np.log1p((T[later] % 10) / 2.0), atol=1e-9)


def test_a_spike_comes_at_a_turn_and_not_when_a_hold_ends_the_same_way() -> None:
    strain = np.interp(T, [0, 10, 20, 30, 60], [0, 0.1, 0.1, 0.2, 0.0])
    effect = ElectricalOvershootTurn(gain=0.1, tau_s=1.0, back=0.001)
    out = np.log(effect.apply({"strain": strain, "conductance_S": np.ones_like(T)}, DT_S)["conductance_S"])
    assert np.max(np.abs(out[(T > 12) & (T < 30)])) < 1e-3
    assert out[T > 30].min() == pytest.approx(-0.1, abs=0.03)


def test_a_turn_becomes_known_between_the_samples_where_it_has_come_back() -> None:
    up_down = np.concatenate([np.linspace(0, 1, 11), np.linspace(0.9, 0, 10)])
    turned, known, count = turns(up_down, 0.25)
    assert (turned[-1], count[-1]) == (10, 1)
    assert known[-1] == pytest.approx(12.5)
    assert known[12] == 0  # not before the sample that tells


@pytest.mark.parametrize("start", [0.9, -0.9])
def test_the_first_way_begins_at_its_extreme_not_at_the_first_sample(start: float) -> None:
    """From 0 by less than a threshold of 1, back by more than that, and on: that is one turn, at -0.5."""
    up = np.sign(start)
    x = np.interp(np.arange(401), [0, 100, 200, 400], up * np.array([0.0, 0.9, -0.5, 3.0]))
    turned, _, count = turns(x, 1.0)
    assert (turned[-1], count[-1]) == (200, 1)


def test_a_wobble_before_the_first_way_is_no_turn() -> None:
    noise = 0.004 * np.random.default_rng(0).uniform(-1, 1, len(T))
    x = np.interp(T, [0, 20, 60], [0.0, 0.0, 0.2]) + noise
    assert not turns(x, 0.01)[2].any()


@pytest.mark.parametrize("rate_hz", [1000, 40, 10, 1])
def test_contacts_age_from_the_start_until_the_first_turn(rate_hz: int) -> None:
    time_s = np.arange(0, 40, 1 / rate_hz)
    strain = 0.01 * np.interp(time_s, [0, 20, 40], [0, 20, 0])
    signals = {"strain": strain, "conductance_S": np.ones_like(strain)}
    out = ContactAgeing(gain=0.2, tau_s=2.0, back=0.005234).apply(signals, 1 / rate_hz)["conductance_S"]
    age_s = np.where(time_s < 20.5234, time_s, time_s - 20)
    np.testing.assert_allclose(np.log(out), 0.2 * np.log1p(age_s / 2.0), atol=1e-9)
