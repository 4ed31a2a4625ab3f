"""A written program is the planned trajectory, exactly, and a controller executes it on time."""

from __future__ import annotations

import numpy as np
import pytest

from gcode.mach4.controller import play
from gcode.mach4.reader import read_program
from gcode.mach4.writer import write_program
from gcode.motion.statistics import differences
from gcode.programs.make import make, make_again
from gcode.trajectories.planning import plan
from gcode.trajectories.presets import PRESETS, preset
from gcode.trajectories.trajectory import sampled

SHORT = 60.0


def short(name: str):
    spec = preset(name)
    return spec.model_copy(update={"pieces": (spec.pieces[0].model_copy(update={"duration_s": SHORT}),)})


@pytest.mark.parametrize("mode", ["G94", "G93"])
@pytest.mark.parametrize("name", PRESETS)
def test_reading_gives_the_trajectory_back_exactly(name, mode):
    trajectory = plan(short(name), 3, 25.0)
    text = write_program(trajectory, feed_mode=mode, machine_acceleration_mm_per_s2=350.0)
    assert text.endswith("\nG94\nM30\n") == (mode == "G93")  # the next program must not be read in inverse time
    program = read_program(text)
    again = program.planned()
    np.testing.assert_allclose(again.time_s, trajectory.time_s, atol=1e-9)
    np.testing.assert_allclose(again.position_mm, trajectory.position_mm, atol=1e-9)


@pytest.mark.parametrize("name", PRESETS)
def test_the_executed_motion_keeps_the_planned_time(name):
    made = make(preset(name), 51, 25.0)
    executed = play(read_program(made.program), made.spec.rate_hz)
    size = min(len(executed.time_s), len(made.trajectory.time_s))
    assert abs(len(executed.time_s) - len(made.trajectory.time_s)) <= 1
    assert np.abs(executed.position_mm[:size] - made.trajectory.position_mm[:size]).max() < 0.05


def test_the_file_alone_makes_itself_again_byte_for_byte():
    made = make(short("paper-2"), 7, 31.5, "G93")
    assert make_again(read_program(made.program)).program == made.program


def test_a_turn_between_two_samples_keeps_its_jerk_as_executed():
    """Both lie at one place. Were their time carried into the next move, the jerk would be three times the plan's."""
    steps = np.round(2.5e-3 * np.sin(np.arange(0, 20 * np.pi, np.pi / 20)), 4)
    steps[::20] = 0.0
    trajectory = sampled(np.concatenate(([0.0], np.cumsum(steps), np.full(5, steps.sum()))), 20.0)
    program = write_program(trajectory, machine_acceleration_mm_per_s2=100.0)
    executed = play(read_program(program), 20.0)
    planned, done = (np.abs(differences(one.position_mm, 20.0, 3)).max() for one in (trajectory, executed))
    assert done < 1.2 * planned


def test_creeping_is_one_move_a_tick():
    trajectory = sampled(np.concatenate((np.linspace(0.0, 0.0025, 101).round(4), [0.0])), 20.0)
    program = write_program(trajectory)
    assert program.count("G4 P") == 1  # at the turn alone
    assert program.count("(STEPS ") == 25
    np.testing.assert_allclose(read_program(program).planned().position_mm, trajectory.position_mm, atol=1e-9)
