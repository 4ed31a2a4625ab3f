"""A recording is over when the stage has come all of its way, however slow the machine is, not at a pause before."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

import gcode
from testbench.rig.acquisition.ending import LONGEST_TIMES, TAIL_S, EndOfMotion
from testbench.rig.acquisition.resume import Left, watched
from testbench.rig.simulation.simulated import Motion
from tests.testbench.rig.rigs import plan

RATE_HZ = 40.0
STARTS_S = 3.0  # after the recorder


def perlin(seed: int = 1, duration_s: float = 120.0) -> Motion:
    trajectory = gcode.generate("paper-1", seed=seed, duration_s=duration_s).trajectory
    return Motion(trajectory.time_s, trajectory.position_mm)


def with_pauses() -> Motion:
    """Three strokes of 10 s with rests of 8 s between them: at zero as at the end."""
    time_s = np.arange(0.0, 46.0, 0.05)
    return Motion(time_s, np.where(time_s % 18.0 < 10.0, 5.0 * np.sin(np.pi * (time_s % 18.0) / 10.0), 0.0))


def slow(speed_mm_per_s: float) -> Motion:
    piece = gcode.Triangle(high_percent=10, speed_mm_per_s=speed_mm_per_s, cycles=4)
    trajectory = gcode.generate(piece, seed=1).trajectory
    return Motion(trajectory.time_s, trajectory.position_mm)


def end_s(
    motion: Motion,
    slower: float,
    lost_s: tuple[float, float] = (0.0, 0.0),
    stops_s: float = np.inf,
    rate_hz: float = RATE_HZ,
) -> float:
    """When a recording ends whose machine takes `slower` times the planned time, and stops for good at `stops_s`."""
    ending = EndOfMotion.of(motion)
    for time_s in np.arange(0.0, STARTS_S + 3 * motion.duration_s, 1 / rate_hz):
        if lost_s[0] <= time_s < lost_s[1]:
            continue
        planned_s = max(0.0, min(time_s, stops_s) - STARTS_S) / slower
        position_nm = round(1e6 * float(np.interp(planned_s, motion.time_s, motion.displacement_mm)))
        row = SimpleNamespace(time_us=round(1e6 * time_s), sample=SimpleNamespace(displacement_nm=position_nm))
        if ending(row):
            return float(time_s)
    raise AssertionError("the recording never ends")


@pytest.mark.parametrize("slower", [1.0, 1.02, 1.1, 1.4, 1.9])
@pytest.mark.parametrize("motion", [perlin(1), perlin(2), with_pauses()], ids=["perlin-1", "perlin-2", "pauses"])
def test_a_slow_machine_is_recorded_to_its_end_and_not_much_longer(motion, slower):
    still = np.abs(motion.displacement_mm - motion.displacement_mm[-1]) < 0.2
    stands_s = motion.time_s[np.flatnonzero(~still)[-1]]  # a plan may itself end with a rest
    end = end_s(motion, slower)
    assert end >= STARTS_S + slower * stands_s + TAIL_S - 0.1
    assert end <= STARTS_S + slower * motion.duration_s + TAIL_S + 0.1


@pytest.mark.parametrize("rate_hz", [20.0, 30.0, 41.5])
@pytest.mark.parametrize("slower", [1.0, 1.3, 1.6, 2.0])
@pytest.mark.parametrize("speed_mm_per_s", [0.05, 0.1, 0.5])
def test_a_motion_that_is_slow_itself_does_not_seem_to_stand(speed_mm_per_s, slower, rate_hz):
    """It went on for two steps of what counts as moved, and ended in mid-stroke, 145 s too early."""
    motion = slow(speed_mm_per_s)
    late_s = end_s(motion, slower, rate_hz=rate_hz) - (STARTS_S + slower * motion.duration_s)
    assert TAIL_S - 0.5 < late_s < TAIL_S + 0.5


@pytest.mark.parametrize("slower", [1.02, 1.3])
def test_the_rest_before_the_last_of_many_strokes_is_not_the_end(slower):
    """39 of 40 strokes are nearly all of the way, and it stands where it will end."""
    time_s = np.arange(0.0, 240.0, 0.05)
    motion = Motion(time_s, 5.0 * np.sin(np.pi * np.minimum(time_s % 6.0, 2.0) / 2.0))
    end = end_s(motion, slower)
    assert end >= STARTS_S + slower * 236.0 + TAIL_S
    assert end <= STARTS_S + slower * 240.0 + LONGEST_TIMES * 4.5 + TAIL_S


def test_a_machine_that_was_stopped_is_not_waited_for():
    motion = perlin()
    assert end_s(motion, 1.0, stops_s=40.0) <= STARTS_S + motion.duration_s + TAIL_S + 0.1


def test_where_lines_were_lost_the_end_is_found_by_standing_for_longer_than_any_rest():
    motion = with_pauses()
    end = end_s(motion, 1.0, lost_s=(20.0, 32.0))
    rest_s = EndOfMotion.of(motion).longest_rest_s
    assert 8.0 < rest_s < 9.0
    assert STARTS_S + motion.duration_s < end < STARTS_S + motion.duration_s + LONGEST_TIMES * rest_s + 2 * TAIL_S


def test_the_rig_on_a_port_stands_until_a_recorder_that_lost_lines_knows_the_end(tmp_path):
    """It stood for 3 s, and such a recording waited for a device that said nothing any more."""
    wish, motion = plan(tmp_path), with_pauses()
    longer_s = len(wish.wire_lines(motion)) / len(list(wish.rig(motion).lines())) * motion.duration_s
    end = end_s(motion, 1.0, lost_s=(20.0, 32.0)) - STARTS_S
    assert motion.duration_s + TAIL_S < end < longer_s


def test_after_a_resume_a_stage_is_watched_before_it_is_said_to_stand():
    motion = with_pauses()
    ending = EndOfMotion.of(motion)
    left = Left()
    for time_s in np.arange(0.0, 40.0, 1 / RATE_HZ):
        left.times_us.append(round(1e6 * time_s))
        left.displacements_nm.append(round(1e6 * float(np.interp(time_s, motion.time_s, motion.displacement_mm))))
    ending = watched(ending, left)
    late_us = round(1e6 * (motion.duration_s + 5.0))
    rows = [(late_us + 25_000 * n, SimpleNamespace(displacement_nm=0)) for n in range(60)]
    over = [ending(SimpleNamespace(time_us=time_us, sample=sample)) for time_us, sample in rows]
    assert not any(over[: round(TAIL_S * RATE_HZ)])
    assert over[-1]


def test_a_motion_too_small_to_be_seen_is_told():
    piece = gcode.Triangle(high_percent=0.5, speed_mm_per_s=0.1)
    trajectory = gcode.generate(piece, seed=1).trajectory
    assert "below 0.2 mm" in EndOfMotion.of(Motion(trajectory.time_s, trajectory.position_mm)).remark()
    assert EndOfMotion.of(perlin()).remark().startswith("the stage was seen to come 0.0 mm")
