"""gcode check refuses, with line and reason, what a machine should not run; it accepts what others wrote well."""

from __future__ import annotations

import numpy as np
import pytest

from gcode.mach4.check import check_program
from gcode.mach4.controller import Machine, execute, play
from gcode.mach4.reader import parse_program, read_program
from gcode.mach4.writer import write_program
from gcode.programs.api import check
from gcode.programs.make import make
from gcode.support.errors import UserError
from gcode.trajectories.bounds import Limits
from gcode.trajectories.designed import Triangle
from gcode.trajectories.planning import plan
from gcode.trajectories.presets import preset
from gcode.trajectories.trajectory import TrajectorySpec

LIMITS = Limits(v_max_mm_per_s=5, a_max_mm_per_s2=20, x_min_mm=0, x_max_mm=10)
START = "G90 G21 G94 G64\n"
SOUND = START + "G1 X1.0 F6\nX2.0\nG4 P1.5\nG1 X0 F6\nM30\n"


def reasons(body: str, limits: Limits = LIMITS) -> list[str]:
    return [str(problem) for problem in check_program(parse_program(body), limits).problems]


def test_a_sound_foreign_program_passes():
    assert reasons(SOUND) == []


def test_a_program_that_was_read_is_not_read_again_as_foreign():
    with pytest.raises(UserError, match="as_foreign: is of a text or a file"):
        check(parse_program(SOUND), as_foreign=True)


@pytest.mark.parametrize(
    ("body", "line", "reason"),
    [
        ("G1 X11 F6\nG1 X0 F6\nM30\n", 2, "leaves the soft limits"),
        ("G1 X-1 F6\nM30\n", 2, "leaves the soft limits"),
        ("G1 X1 F6\nG1 X9 F400\nM30\n", 3, "above v max"),
        ("G1 X5 F280\nG1 X0 F280\nM30\n", 2, "acceleration"),
        ("G1 X1\nM30\n", 2, "without a feed"),
        ("G1 X1 F0\nM30\n", 2, "not above 0"),
        ("G1 X1.0 F0.00\nM30\n", 2, "not above 0"),
        ("G1 X1 F-5\nM30\n", 2, "not above 0"),
        ("G1 X1 F6\nG4 P500\nM30\n", 3, "looks like milliseconds"),
        ("G1 X1 F6\nG4 P1500.0\nM30\n", 3, "is this milliseconds"),
        ("G1 X1 F6\nP100 G4\nM30\n", 3, "looks like milliseconds"),
        ("G1 X1 F6\nG 4 P 100\nM30\n", 3, "looks like milliseconds"),
        ("G1 X1 F6\nG64 G4 P2\nM30\n", 3, "exclude each other"),
        ("G54 G55\nG1 X1 F6\nM30\n", 2, "exclude each other"),
        ("G80 G1 X1 F6\nM30\n", 2, "before any G0 or G1"),
        ("G80 G1 F6\nX1\nM30\n", 3, "before any G0 or G1"),
        ("G1 X1 F72\nX1.3 F36\nX1.4 F6\nM30\n", 2, "executed acceleration"),  # it starts too fast
        ("G1 X0.1 F6\nX0.4 F36\nX1.6 F72\nM30\n", 4, "executed acceleration"),  # it stops too fast
        ("G1 X1 F6\nG4\nM30\n", 3, "needs P"),
        ("G1 X1 F6\nG4 X2\nM30\n", 3, "not as X"),
        ("G61\nG1 X1 F6\nM30\n", 2, "G61 stops"),
        ("G1 XNAN F6\nM30\n", 2, "not a number"),
        ("G1 X1E-1 F6\nM30\n", 2, "exponent"),
        ("G1 X#1 F6\nM30\n", 2, "cannot read"),
        ("G1 X1..2 F6\nM30\n", 2, "cannot read"),
        ("G1 X1 Y1 F6\nM30\n", 2, "single-axis"),
        ("G2 X1 F6\nM30\n", 2, "not understood"),
        ("G1 X1 F6\nM99\nM30\n", 3, "M99"),
        ("(open\nG1 X1 F6\nM30\n", 2, "not closed"),
        (f"({'X' * 300})\nG1 X1 F6\nM30\n", 2, "characters long"),
        ("G1 X1 F6 (µ)\nM30\n", 2, "not ASCII"),
        ("G1 X1 F6\nG1 X1 F6\nM30\n", 3, "has no length"),
        ("G0 G1 X1 F6\nM30\n", 2, "exclude each other"),
        ("G0 X5\nM30\n", 2, "no known speed"),
        ("G93\nG1 X1 F6\nX2\nM30\n", 4, "F of its own"),
        ("G1 X1 F6\n%\nG1 X0\nM30\n", 3, "% ends the program here"),
        ("G1 X1 F6 (a\rG1 X9 F6000)\nM30\n", 2, "not printed"),
        ("G1 X1 F6 ;\x0bG1 X9 F6000\nM30\n", 2, "not printed"),
        ("G1 X\u0661.0 F\u0666.0\nM30\n", 2, "not ASCII"),
        ("G1 X1 F6\nG20\nG1 X0\nM30\n", 4, "without a feed"),
        ("G1 X1 F6\nG20 F6\nG1 X0\nM30\n", 4, "F of line 3 stands beside G20 or G21"),
        ("G1 X1 F6 M0\nG1 X0\nM30\n", 2, "waits for somebody"),
        ("M3 S100\nG1 X1 F6\nM30\n", 2, "starts the spindle"),
        ("G1 X1 F6\nX0 M4\nM30\n", 3, "starts the spindle"),
        ("M8\nG1 X1 F6\nM30\n", 2, "starts the coolant"),
        ("(log open, a.txt)\nG1 X1 F6\nM30\n", 2, "LOGOPEN writes files"),
        ("G1 X1 F6 (PROBEOPEN a.txt)\nM30\n", 2, "PROBEOPEN writes files"),
        ("G1 X1 F6 ;py,f()\nM30\n", 2, "PY writes files or runs code"),
        ("G91\nG1 X1 F6\nM30\n", 3, "moves before a first place, X under G90,"),
        ("G1 X1 F6\nM0\nG1 X0\nM30\n", 3, "waits for somebody"),
        ("G1 X1 F6\nG80\nX0\nM30\n", 4, "before any G0 or G1"),
        ("G1 X1 F6\nG4 P1.0\nP5.0\nG1 X0\nM30\n", 4, "P stands without the G4"),
        # LinuxCNC stops at these, with the axis where it is.
        ("G1 X1 F6 N5\nM30\n", 2, "N5 stands behind another word"),
        ("N1 N2 G1 X1 F6\nM30\n", 2, "N is given twice"),
        ("N-1 G1 X1 F6\nM30\n", 2, "N-1 must be a whole number, 0 or more"),
        ("G1 X1 F6\nT1.5\nM30\n", 3, "T1.5 must be a whole number"),
        ("G1 X1 F6 S-5\nM30\n", 2, "S-5 must be a number, 0 or more"),
        ("G1 X1 F6\nG1 G1 X0\nM30\n", 3, "G1 is given twice"),
        ("G1 X1 F6\nG4 G4 P1.0\nM30\n", 3, "G4 is given twice"),
        ("G40 G40\nG1 X1 F6\nM30\n", 2, "G40 is given twice"),
        ("G1 X1 F6\nM48 M49\nM30\n", 3, "M48 and M49 exclude each other"),
        ("G1 X1 F6\nM2 M30\n", 3, "M2 and M30 exclude each other"),
        ("G1 X1 F6\nG(a)1 X0\nM30\n", 3, "cannot read 'G()1 X0'"),
        # It leaves out strokes that are shorter than the tolerance.
        ("G64 P9\nG1 X5 F6\nX0.1\nM30\n", 2, "G64 P9 lets the axis leave out strokes"),
        ("G64 P-1\nG1 X5 F6\nM30\n", 2, "P may be from 0 to 0.05 mm"),
        ("G20 G64 P0.01\nG1 X5 F6\nM30\n", 2, "P may be from 0 to 0.05 mm"),
        ("G1 X1 F6\n", 2, "does not end with M30"),
        ("M30\n", 1, "moves nothing"),
    ],
)
def test_what_is_refused_says_line_and_reason(body, line, reason):
    found = [text for text in reasons(START + body) if reason in text]
    assert found
    assert found[0].startswith(f"line {line}: ")


def test_the_first_unit_is_not_for_the_feed_beside_it():
    """LinuxCNC takes F before G21: in whatever unit its last job left. A move with an F of its own does not care."""
    found = reasons("G21 G90 G94 F6\nG1 X1\nG1 X0\nM30\n")
    assert any("line 2: a move without a feed: F of line 1 stands beside G20 or G21" in text for text in found)
    assert reasons("G21 G90 G94 F400\nG1 X1 F6\nG1 X0\nM30\n") == []


def test_a_dwell_before_the_first_move_says_no_mode():
    found = " ".join(reasons("G4 P1\nG1 X1 F6\nX0\nM30\n"))
    assert all(f"moves before {mode} is said" in found for mode in ("G20 or G21", "G90 or G91", "G93 or G94"))


def test_comments_that_only_speak_are_let_through():
    assert reasons("(MSG, hello)\n(logbook 7)\n(probe 3)\n(py)\n" + SOUND) == []


def test_words_that_stand_once_in_a_line_and_a_narrow_tolerance_are_let_through():
    body = "G17 G40 G49 G80 G54\nG64 P0.02\nN10 T1 S0 G1 X1 F6 (a) M5 M9\nN20 X0 ;b\nN30 (c) M30\n"
    assert check_program(parse_program(START + body), Limits()).ok


def test_a_percent_sign_may_begin_and_follow_a_program():
    assert reasons("%\n" + SOUND + "%\n") == []


def test_a_program_of_faults_is_read_no_further_than_a_thousand():
    found = reasons(START + "G1 X1 F6\n" * 5000 + "M30\n")
    assert len(found) == 1001
    assert found[-1].endswith("the program was read no further")


@pytest.mark.parametrize("rate_hz", [0.5, 0.0, -1.0, float("nan"), 1e5])
def test_a_rate_that_would_show_nothing_is_refused(rate_hz):
    with pytest.raises(UserError, match="rate_hz must be from 1 to 10000"):
        check_program(parse_program(SOUND), LIMITS, rate_hz)


def test_inches_and_incremental_moves_are_understood():
    program = read_program("G91 G20 G94\nG1 X0.1 F1\nX0.1\nM30\n")
    np.testing.assert_allclose(program.position_mm, [2.54, 5.08])
    np.testing.assert_allclose(program.feed_mm_per_s, 25.4 / 60)


def test_an_axis_that_shakes_in_step_with_the_samples_is_seen():
    """It turns every 25 ms on a controller of 100 mm/s2: its samples at 20 Hz all lie at one place."""
    body = "G1 X0.015 F60\n" + "X0\nX0.015\n" * 1000 + "X0\nM30\n"
    result = check_program(parse_program(START + body), Limits(a_max_mm_per_s2=20.0))
    assert result.statistics.v_max_mm_per_s < 1e-9
    assert "executed speed changes by 1.91 mm/s within 0.0191 s" in str(result.problems[0])


def test_speeds_that_change_in_step_with_the_samples_are_seen():
    """Fast and slow in turn: the mean speed over each sample is the same."""
    body = "".join(f"G1 X{0.05 * n + 0.04:.4f} F120\nX{0.05 * n + 0.05:.4f} F12\n" for n in range(200))
    result = check_program(parse_program(START + body + "M30\n"), Limits(a_max_mm_per_s2=20.0))
    assert "executed" in str(result.problems[0])


def test_the_range_is_that_of_the_turns_not_of_the_samples():
    found = check("G90 G21 G94\nG1 X7.03 F120\nG1 X-1.04 F120\nG1 X0 F120\nM30\n", LIMITS).statistics
    assert (found.x_min_mm, found.x_max_mm) == (-1.04, 7.03)


def test_our_own_program_passes_at_its_limits_and_fails_below_them():
    program = parse_program(make(preset("paper-1"), 51, 25.0).program)
    assert check_program(program, Limits(v_max_mm_per_s=4.4, a_max_mm_per_s2=20, x_min_mm=0, x_max_mm=7.5)).ok
    tight = Limits(v_max_mm_per_s=3, a_max_mm_per_s2=10, x_min_mm=0, x_max_mm=5)
    text = " ".join(str(problem) for problem in check_program(program, tight).problems)
    assert all(word in text for word in ("soft limits", "above v max", "executed speed", "executed acceleration"))


def test_a_stated_rapid_speed_is_judged_like_a_feed():
    program = parse_program(START + "G0 X5\nM30\n")
    slow = Limits(v_max_mm_per_s=5, a_max_mm_per_s2=1000)
    assert check_program(program, slow, rapid_mm_per_s=4.0).ok
    assert not check_program(program, slow, rapid_mm_per_s=6.0).ok


def test_a_stated_rapid_speed_is_that_of_a_given_machine_too():
    program = parse_program(START + "G0 X5\nM30\n")
    machine = Machine(acceleration_mm_per_s2=1000.0)
    result = check_program(program, Limits(v_max_mm_per_s=5, a_max_mm_per_s2=1000), 20, machine, rapid_mm_per_s=4.0)
    assert result.statistics.v_max_mm_per_s == pytest.approx(4.0)


def test_feeds_faster_than_a_rapid_move_are_one_motion_in_make_check_and_play():
    limits = Limits(v_max_mm_per_s=100, a_max_mm_per_s2=500)
    spec = TrajectorySpec.of(Triangle(high_percent=60, speed_mm_per_s=80, cycles=4), name="fastramp", limits=limits)
    made = make(spec, 1, 200.0)
    program = read_program(made.program)
    checked = check_program(program, limits).statistics
    for found in (made.statistics, checked, play(program).statistics()):
        assert found.v_max_mm_per_s == pytest.approx(80, abs=0.1)
        assert found.duration_s == pytest.approx(made.trajectory.duration_s, abs=0.3)


def test_reading_a_faulty_program_names_the_first_fault():
    with pytest.raises(UserError, match=r"line 2: .*not above 0"):
        read_program(START + "G1 X1 F0\nM30\n")


def test_exact_stop_costs_time():
    text = make(preset("paper-1").model_copy(update={"pieces": _short()}), 1, 25.0).program
    free = play(parse_program(text))
    stopped = play(parse_program(text.replace("\nG64\n", "\nG61\n")))
    assert stopped.duration_s > 1.15 * free.duration_s


def _short():
    return (preset("paper-1").pieces[0].model_copy(update={"duration_s": 60.0, "target": None}),)


def test_the_planner_keeps_planned_time_from_five_times_the_acceleration_on():
    for factor in (5.0, 10.0):
        spec = preset("paper-1").model_copy(update={"machine_acceleration_mm_per_s2": 20.0 * factor})
        program = read_program(make(spec, 51, 25.0).program)
        ends = execute(program, Machine(acceleration_mm_per_s2=20.0 * factor)).block_end_s
        assert np.abs(ends - np.cumsum(program.steps) / 20.0).max() < 0.1


def test_without_compensation_the_machine_is_late():
    trajectory = plan(preset("paper-1"), 51, 25.0)
    late = play(read_program(write_program(trajectory)), 20.0, Machine(acceleration_mm_per_s2=100.0))
    assert late.duration_s - trajectory.duration_s > 1.0
