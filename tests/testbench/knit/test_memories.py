"""What a knit can remember: known answers."""

from __future__ import annotations

import numpy as np
import pytest

from testbench.knit import memories

DT_S = 0.01
T = np.arange(2000) * DT_S
CONSTANT = np.full_like(T, 1.0)


def test_a_share_that_forms_and_goes_settles_between_its_two_rates():
    gain, loss = 0.5 * CONSTANT, np.where(T > 0, 1.5, 0.0)
    share = memories.kinetics(gain, loss, DT_S)
    expected = 0.25 + 0.75 * np.exp(-2.0 * T)  # all of it is there before the loss begins
    assert share[0] == 1.0
    assert np.max(np.abs(share - expected)) < 0.02
    assert share[-1] == pytest.approx(0.25)


def test_a_share_stays_a_share_however_quick_the_rates():
    share = memories.kinetics(1e6 * CONSTANT, 1e6 * np.abs(np.sin(T)), DT_S)
    assert np.all((share >= 0) & (share <= 1))


def test_nothing_happens_without_rates():
    assert not memories.kinetics(0 * CONSTANT, 0 * CONSTANT, DT_S).any()


def test_an_oscillator_rings_at_its_frequency_and_comes_to_rest_at_its_input():
    step = np.where(T > 1.0, 1.0, 0.0)
    ringing = memories.oscillator(step, 2.0, 0.1, DT_S)
    overshoot = 1 + np.exp(-np.pi * 0.1 / np.sqrt(1 - 0.1**2))  # of a second-order system
    assert ringing.max() == pytest.approx(overshoot, rel=0.01)
    assert T[np.argmax(ringing)] == pytest.approx(1.0 + 0.25 / np.sqrt(1 - 0.1**2), abs=2 * DT_S)
    assert ringing[-1] == pytest.approx(1.0, abs=1e-3)


def test_a_relay_switches_back_later_than_it_switched():
    x = np.array([0.0, 0.6, 0.4, 0.2, 0.4, 0.6])
    assert memories.relay(x, 0.5, 0.3).tolist() == [0, 1, 1, 0, 0, 1]


def test_a_dead_band_shows_an_old_value_and_never_lags_by_more():
    x = np.sin(T)
    shown = memories.held(x, 0.1)
    assert np.max(np.abs(shown - x)) <= 0.1 + 1e-12
    assert len(np.unique(np.round(shown, 9))) <= 21
    assert np.array_equal(memories.held(x, 0.0), x)


def test_what_sticks_lets_go_at_its_grip():
    went = memories.stuck(0.35 * T / T[-1], 0.1)
    assert went.min() >= 0
    assert went.max() <= 0.1 + 1e-12
    assert int(np.sum(np.diff(went) < -0.05)) == 3


def test_a_slip_element_that_relaxes_carries_its_reach_at_most_and_lets_go_at_rest():
    x = np.minimum(0.1 * T, 0.5)  # five seconds of pull, then a hold
    carried = memories.relaxing_stop(x, 0.15, 4.0, DT_S)
    slips = -4.0 * np.log(1 - 0.15 / 0.4) > T
    assert carried[slips] == pytest.approx(0.4 * (1 - np.exp(-T[slips] / 4.0)))
    assert carried.max() == pytest.approx(0.15)
    assert carried[-1] == pytest.approx(0.15 * np.exp(-(T[-1] - 5.0) / 4.0), rel=1e-6)
    y = 0.3 * np.sin(T)
    assert memories.relaxing_stop(y, 0.1, 1e9, DT_S) == pytest.approx(memories.stop(y, 0.1), abs=1e-6)


def test_time_at_rest_grows_while_nothing_moves_and_starts_anew():
    x = np.where(T < 5, 0.0, np.where(T < 6, T - 5, 1.0))
    near = memories.seconds_near(x, 0.05, DT_S)
    assert near[499] == pytest.approx(4.99)
    assert near[T < 6].max() < 5.1
    assert near[-1] == pytest.approx(T[-1] - 6.0, abs=0.05)  # the last width is passed within 0.05 s


def test_the_last_top_is_where_it_turned_down():
    x = np.abs(((T + 4) % 8) - 4) / 4 * np.where(T < 8, 1.0, 0.5)  # a triangle of 1, then triangles of 1/2
    tops = memories.last_top(x, 0.02)
    assert tops[int(4.5 / DT_S)] == pytest.approx(1.0)
    assert tops[int(12.5 / DT_S)] == pytest.approx(0.5)
    assert memories.since_turn(x, 1.0, DT_S)[int(6 / DT_S)] == pytest.approx(2.0, abs=0.02)
    assert memories.turns_so_far(x, 1.0)[-1] == 4


def test_direction_is_one_way_or_the_other_between_turns():
    x = np.sin(0.5 * T)
    way = memories.heading(x, 2.0)
    assert way[int(2 / DT_S)] > 0.95
    assert way[int(6 / DT_S)] < -0.95


def test_path_and_work_add_up_both_ways():
    x = np.sin(np.pi * T / T[-1])
    assert memories.path(x, 1.0)[-1] == pytest.approx(2.0, abs=0.02)
    assert memories.work(2.0 * CONSTANT, x)[-1] == pytest.approx(4.0, rel=1e-3)


def test_a_delay_is_what_was():
    assert memories.delayed(T, 0.5, DT_S)[-1] == pytest.approx(T[-1] - 0.5)
    assert memories.delayed(T, 0.5, DT_S)[0] == 0.0


@pytest.mark.parametrize("dt_s", [0.001, 0.1, 0.5])
def test_a_lag_of_two_ways_is_that_of_each_way_at_every_sampling_rate(dt_s):
    time_s = np.arange(0, 20 + dt_s / 2, dt_s)
    ramps = np.interp(time_s, [0, 10, 20], [0.0, 5.0, 0.0])
    lag = ramps - memories.two_way_lag(ramps, 0.2, 1.0, dt_s)
    at = np.searchsorted(time_s, [9.0 - 1e-9, 19.0 - 1e-9])
    assert lag[at] == pytest.approx([0.5 * 0.2, -0.5 * 1.0], rel=1e-3)
