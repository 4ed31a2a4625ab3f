"""Numbers that once led to a traceback or to no end; found by ``benchmarks/attack_commands.py``."""

from __future__ import annotations

import re

import pytest

from gcode.cli import main
from gcode.mach4.reader import read_program
from gcode.programs.make import make, make_again
from gcode.support.errors import UserError
from gcode.trajectories.designed import Hold, Ramp, RateSweep, Staircase, Triangle
from gcode.trajectories.natural import Noise
from gcode.trajectories.planning import plan
from gcode.trajectories.presets import preset
from gcode.trajectories.trajectory import Trajectory, TrajectorySpec, read_csv
from tests.fuzz.targets import SPEC

LIMITS = ["--v-max", "5", "--a-max", "20", "--x-min", "-1", "--x-max", "10"]


@pytest.fixture
def program(tmp_path):
    (tmp_path / "p\x1b[31m.tap").write_text(make(SPEC, 1, 25.0).program)
    return str(tmp_path / "p\x1b[31m.tap")


@pytest.mark.parametrize("option", ["--a-max", "--machine-acceleration"])
def test_a_controller_that_never_arrives_is_refused(program, capsys, option):
    assert main(["check", program, *LIMITS, option, "1e-300"]) == 1
    assert "not executed, since this controller would take" in capsys.readouterr().out


def test_a_rapid_move_that_never_arrives_is_refused(tmp_path, capsys):
    (tmp_path / "rapid.tap").write_text("G21 G90 G94\nG64\nG0 X1\nM30\n")
    assert main(["check", str(tmp_path / "rapid.tap"), *LIMITS, "--rapid", "1e-300"]) == 1
    assert "not executed, since this controller would take" in capsys.readouterr().out


def test_the_name_of_a_file_does_not_steer_the_terminal(program, capsys):
    assert main(["check", program, *LIMITS, "--v-max", "0.001"]) == 1
    assert "\x1b" not in capsys.readouterr().out


@pytest.mark.parametrize(
    "words",
    [
        "--v-mean 0.9 --v-sd 0.6 --a-mean 1.4 --a-sd 1.3 --gauge-length-mm 0.025",
        "--v-mean 1000 --v-sd 600 --a-mean 1500 --a-sd 1500",
    ],
)
def test_a_fit_that_the_stroke_has_no_room_for_is_refused(words, capsys):
    """They ran for minutes."""
    assert main(["fit", *words.split()]) == 2
    assert "noise: the target cannot be reached" in capsys.readouterr().err


@pytest.mark.parametrize("duration_s", [60.0, 9000.0])
def test_noise_that_is_far_slower_than_its_least_speed_is_refused(duration_s):
    """It was made longer and longer, for ever."""
    noise = Noise(duration_s=duration_s, cells_per_s=1e-5, min_speed_mm_per_s=3.0)
    with pytest.raises(UserError, match="far slower than min_speed_mm_per_s = 3"):
        plan(TrajectorySpec.of(noise, name="slow"), 1, 25.0)


def test_a_piece_of_two_seconds_that_begins_at_rest_is_planned():
    """Its first seconds of noise say nothing of how much it needs."""
    fast = preset("fast")
    piece = fast.pieces[0].model_copy(update={"duration_s": 2.0})
    assert make(fast.model_copy(update={"pieces": (piece,)}), 0, 10.0).statistics.x_max_mm > 1


@pytest.mark.parametrize("seed", [-1, 1 << 53, (1 << 53) + 1, 1 << 62])
def test_a_seed_that_a_header_cannot_hold_is_refused(seed):
    """It made a program that `gcode check` refused."""
    with pytest.raises(UserError, match=f"seed must be a whole number from 0 to 9007199254740991, got {seed}"):
        make(SPEC, seed, 25.0)


def test_the_largest_seed_can_be_made_again():
    made = make(SPEC, (1 << 53) - 1, 25.0)
    assert make_again(read_program(made.program)).program == made.program


@pytest.mark.parametrize("gauge_length_mm", [1e-300, 0.0, -1.0, 1e300, float("nan")])
def test_a_gauge_length_that_no_sample_has_is_refused(gauge_length_mm):
    with pytest.raises(UserError, match="gauge length must be"):
        make(SPEC, 1, gauge_length_mm)


@pytest.mark.parametrize(
    ("pieces", "reason"),
    [
        (Ramp(to_percent=4, speed_mm_per_s=1e-9), "samples, this one would have"),
        (Triangle(high_percent=4, speed_mm_per_s=1e-300), "samples, this one would have"),
        (RateSweep(high_percent=4, speeds_mm_per_s=(1.0,) * 100, cycles=100_000), "strokes and rests"),
        (Hold(duration_s=1) + Staircase(levels_percent=(1, 2), speed_mm_per_s=1e-9, hold_s=1), "samples, this one"),
    ],
)
def test_a_motion_of_years_is_refused_before_it_is_planned(pieces, reason):
    """It asked for 7 TB of memory."""
    with pytest.raises(UserError, match=reason):
        plan(TrajectorySpec.of(pieces), 1, 25.0)


def test_links_that_lead_in_a_circle_are_a_sentence(tmp_path, program, capsys):
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    assert main(["play", program, "-o", str(tmp_path / "loop" / "x.csv")]) == 2
    assert "Traceback" not in capsys.readouterr().err


def test_a_message_does_not_repeat_a_megabyte(tmp_path, capsys):
    (tmp_path / "spec.toml").write_text(f'name = "{"x" * 900_000}"\n')
    assert main(["generate", "--spec", str(tmp_path / "spec.toml"), "-o", str(tmp_path / "o")]) == 2
    assert len(capsys.readouterr().err) < 1000


@pytest.mark.parametrize(
    ("time_s", "position_mm", "said"),
    [
        ("x", [0, 1], "time_s must be two finite numbers or more in a row, got x"),
        ([0, 1], [0, float("nan")], "position_mm must be two finite numbers or more in a row, got [0, nan]"),
        ([0], [0], "time_s must be two finite numbers or more"),
        ([[0, 1]], [0, 1], "time_s must be two finite numbers or more"),
        ([0, 1], [0, 1, 2], "as many times as positions are needed, got 2 and 3"),
        ([0, 1, 3], [0, 1, 2], "time_s must rise in even steps"),
        ([1, 0], [0, 1], "time_s must rise in even steps"),
    ],
)
def test_a_trajectory_that_is_none_is_refused_when_it_is_made(time_s, position_mm, said):
    """It was made of anything; `rate_hz` and the statistics of uneven times were wrong in silence."""
    with pytest.raises(UserError, match=re.escape(f"Trajectory: {said}")):
        Trajectory(time_s, position_mm)


def test_a_trajectory_may_be_made_of_lists_and_of_the_rounded_times_of_a_file(tmp_path):
    made = Trajectory([0, 1, 2], [0, 1, 0])
    assert repr(made) == "<Trajectory 2.0 s at 1 Hz, 0 to 1 mm>"
    assert made.statistics().a_max_mm_per_s2 == 2.0
    thirds = Trajectory([number / 3 for number in range(100)], range(100))
    thirds.write_csv(tmp_path / "t.csv")
    assert read_csv(tmp_path / "t.csv").rate_hz == pytest.approx(3)


def test_an_uneven_file_is_no_trajectory(tmp_path):
    (tmp_path / "t.csv").write_text("time_s,position_mm\n0,0\n1,1\n5,2\n")
    with pytest.raises(UserError, match="not a trajectory: Trajectory: time_s must rise in even steps"):
        read_csv(tmp_path / "t.csv")
