"""The trapezoidal look-ahead rule, against known answers and a block-by-block loop."""

from __future__ import annotations

import numpy as np
import pytest

from gcode.motion.blocks import Blocks, block_ends, drive, junction_speeds
from gcode.support.errors import UserError


def blocks_of(lengths, speeds, dwells=None) -> Blocks:
    lengths = np.array(lengths, dtype=float)
    dwell = np.zeros(len(lengths)) if dwells is None else np.array(dwells, dtype=float)
    return Blocks(lengths, np.array(speeds, dtype=float), dwell)


def loop_junctions(lengths, speeds, acceleration, look_ahead=None):
    """The same rule as a controller runs it: one block after the other."""
    count = len(lengths)
    cap = [0.0] * (count + 1)
    for i in range(1, count):
        if lengths[i - 1] * lengths[i] > 0:
            cap[i] = min(speeds[i - 1], speeds[i])
    result = [0.0] * (count + 1)
    for i in range(1, count):
        allowed = cap[i]
        last = count if look_ahead is None else min(i + look_ahead, count)
        room = 0.0
        for j in range(i, last):
            room += abs(lengths[j])
            target = 0.0 if j + 1 == last and look_ahead is not None else cap[j + 1]
            allowed = min(allowed, np.sqrt(target**2 + 2 * acceleration * room))
        result[i] = min(allowed, np.sqrt(result[i - 1] ** 2 + 2 * acceleration * abs(lengths[i - 1])))
    return np.array(result)


def test_one_long_move_is_a_trapezoid():
    motion = drive(blocks_of([10.0], [2.0]), 4.0)
    assert motion.end_s == pytest.approx(10 / 2 + 2 / 4)
    assert motion.position_at(np.array([0.5]))[0] == pytest.approx(0.5)


def test_a_short_move_is_a_triangle():
    assert drive(blocks_of([1.0], [100.0]), 4.0).end_s == pytest.approx(2 * np.sqrt(1 / 4))


def test_a_reversal_is_a_stop_and_a_dwell_takes_its_time():
    moves = blocks_of([5.0, -5.0, 0.0, 5.0], [1.0, 1.0, 0.0, 1.0], [0, 0, 3.0, 0])
    assert drive(moves, 2.0).end_s == pytest.approx(3 * (5 / 1 + 1 / 2) + 3.0)


def test_a_corner_step_is_taken_without_stopping():
    moves = blocks_of([5.0, -5.0], [1.0, 1.0])
    assert junction_speeds(moves, 2.0, corner_mm_per_s=0.5)[1] == pytest.approx(0.25)


def test_exact_stop_stops_at_every_block():
    moves = blocks_of([1.0] * 10, [1.0] * 10)
    stops = np.ones(10, dtype=bool)
    assert not junction_speeds(moves, 5.0, stop_after=stops).any()
    assert drive(moves, 5.0, stop_after=stops).end_s > 1.15 * drive(moves, 5.0).end_s


@pytest.mark.parametrize("look_ahead", [None, 1, 3, 20])
def test_junction_speeds_equal_those_of_a_loop(look_ahead):
    rng = np.random.default_rng(4)
    lengths = rng.uniform(0.001, 0.3, 120) * np.sign(np.sin(np.arange(120) / 7) + 0.01)
    speeds = rng.uniform(0.1, 5.0, 120)
    ours = junction_speeds(blocks_of(lengths, speeds), 6.0, look_ahead)
    np.testing.assert_allclose(ours, loop_junctions(lengths, speeds, 6.0, look_ahead), atol=1e-6)


def test_short_sight_is_slower():
    moves = blocks_of([0.05] * 200, [5.0] * 200)
    assert drive(moves, 5.0, look_ahead=5).end_s > 1.5 * drive(moves, 5.0).end_s


def test_the_motion_is_continuous_and_ends_where_its_blocks_end():
    rng = np.random.default_rng(1)
    lengths = rng.normal(0, 0.2, 300)
    motion = drive(blocks_of(lengths, rng.uniform(0.2, 3, 300)), 10.0, start_mm=1.0)
    np.testing.assert_allclose(motion.position_at(motion.block_end_s), 1.0 + np.cumsum(lengths), atol=1e-6)
    fine = motion.position_at(np.arange(0, motion.end_s, 1e-3))
    assert np.abs(np.diff(fine, 2)).max() / 1e-6 < 10.0 * 1.01


def test_block_ends_are_those_of_the_whole_motion():
    rng = np.random.default_rng(2)
    moves = blocks_of(rng.normal(0, 0.2, 100), rng.uniform(0.2, 3, 100))
    np.testing.assert_allclose(block_ends(moves, 10.0), drive(moves, 10.0).block_end_s, rtol=1e-12)


def test_more_samples_than_fit_in_memory_are_refused():
    motion = drive(blocks_of([1, 0], [1, 1], [0, 600_000]), 100.0)
    assert len(motion.positions(1.0)) == 600_003
    with pytest.raises(UserError, match=r"6e\+05 s at 1000 Hz are too many samples .*; shorten it, or"):
        motion.positions(1000.0)
