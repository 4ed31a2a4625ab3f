"""No limit is exceeded in the executed motion, whatever the spec; what cannot be met is refused in one sentence."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gcode.mach4 import controller
from gcode.mach4.controller import Machine, play
from gcode.mach4.reader import read_program
from gcode.programs.make import make
from gcode.support.errors import UserError
from gcode.trajectories.bounds import Limits, excesses
from gcode.trajectories.designed import Hold, Multisine, Noise, Ramp, RateSweep, ReturnToZero, Staircase, Triangle
from gcode.trajectories.planning import plan
from gcode.trajectories.presets import PRESETS, preset
from gcode.trajectories.trajectory import TrajectorySpec

speed = st.floats(0.05, 4.0)
percent = st.floats(1.0, 60.0)
noise = st.builds(
    Noise,
    duration_s=st.floats(2.0, 30.0),
    cells_per_s=st.floats(0.05, 1.5),
    octaves=st.integers(1, 3),
    persistence=st.floats(0.1, 1.0),
    high_percent=percent,
    min_speed_mm_per_s=st.floats(0.0, 0.5),
    pace_spread=st.floats(0.0, 1.0),
)
piece = st.one_of(
    noise,
    st.builds(Hold, duration_s=st.floats(0.01, 5.0)),
    st.builds(Ramp, to_percent=percent, speed_mm_per_s=speed),
    st.builds(ReturnToZero, speed_mm_per_s=speed, rest_s=st.floats(0.0, 2.0)),
    st.builds(Triangle, high_percent=percent, speed_mm_per_s=speed, cycles=st.integers(1, 3)),
    st.builds(
        Staircase,
        levels_percent=st.lists(percent, min_size=1, max_size=4).map(tuple),
        speed_mm_per_s=speed,
        hold_s=st.floats(0.1, 2.0),
    ),
    st.builds(RateSweep, high_percent=percent, speeds_mm_per_s=st.lists(speed, min_size=1, max_size=3).map(tuple)),
    st.builds(
        Multisine,
        high_percent=percent,
        duration_s=st.floats(1.0, 20.0),
        frequencies_hz=st.lists(st.floats(0.02, 0.5), min_size=1, max_size=3).map(tuple),
    ),
)
limits = st.builds(
    Limits,
    v_max_mm_per_s=st.floats(1.0, 10.0),
    a_max_mm_per_s2=st.floats(5.0, 100.0),
    j_max_mm_per_s3=st.one_of(st.none(), st.floats(100.0, 1000.0)),
)
spec = st.builds(
    TrajectorySpec,
    pieces=st.lists(piece, min_size=1, max_size=3).map(tuple),
    limits=limits,
    offset_mm=st.floats(-2.0, 2.0),
    approach_mm_per_s=st.floats(0.1, 3.0),
)


@given(spec, st.integers(0, 1000), st.floats(5.0, 60.0), st.sampled_from(["G94", "G93"]))
@settings(max_examples=60)
def test_any_spec_keeps_its_limits_as_executed_and_reads_back_exactly(spec, seed, gauge_length_mm, mode):
    try:
        made = make(spec, seed, gauge_length_mm, mode)
    except UserError as error:
        assert any(word in str(error) for word in ("limits", "never moves", "min_speed_mm_per_s"))  # noqa: PT017
        assert "own check" not in str(error)  # noqa: PT017
        return
    program = read_program(made.program)
    executed = play(program, spec.rate_hz)
    assert not excesses(executed.position_mm, spec.rate_hz, spec.limits, slack=1e-3)
    np.testing.assert_allclose(program.planned().position_mm, made.trajectory.position_mm, atol=1e-9)


@given(
    st.sampled_from(sorted(PRESETS)),
    st.integers(0, 10_000),
    st.floats(2.0, 30.0),
    st.floats(10.0, 50.0),
    st.floats(0.7, 3.0),
    st.sampled_from([1.0, 1.5, 2.0, 5.0, 20.0]),
    st.sampled_from(["G94", "G93"]),
)
@settings(max_examples=80)
def test_a_short_piece_of_a_preset_passes_its_own_check(name, seed, duration_s, gauge_length_mm, room, machine, mode):
    spec = preset(name)
    noise = spec.pieces[0].model_copy(update={"duration_s": duration_s})
    limits = spec.limits.model_copy(update={"a_max_mm_per_s2": spec.limits.a_max_mm_per_s2 * room})
    change = {
        "machine_acceleration_mm_per_s2": machine * limits.a_max_mm_per_s2,
        "limits": limits,
        "pieces": (noise,),
    }
    try:
        make(spec.model_copy(update=change), seed, gauge_length_mm, mode)
    except UserError as error:  # a few seconds need not hold the preset's statistics
        assert "target cannot be reached" in str(error) or "would stretch" in str(error)  # noqa: PT017


def test_a_move_below_the_programs_last_digit_is_no_move():
    spec = TrajectorySpec(pieces=(ReturnToZero(rest_s=1e-12),), offset_mm=1e-12)
    with pytest.raises(UserError, match="never moves"):
        plan(spec, 1, 25.0)


def test_a_controller_that_cannot_follow_is_spoken_of(monkeypatch):
    spec = preset("paper-1")
    short = tuple(piece.model_copy(update={"duration_s": 120.0}) for piece in spec.pieces)
    slow = spec.model_copy(update={"pieces": short, "machine_acceleration_mm_per_s2": 5.0})
    made = make(slow, 3, 25.0)
    played = play(read_program(made.program), spec.rate_hz).position_mm
    assert np.array_equal(made.executed.position_mm, played)
    with monkeypatch.context() as nothing_plays:  # its check has played it: what is said needs no second time
        nothing_plays.setattr(controller, "drive", None)
        (note,) = [note for note in made.notes() if "controller" in note]
    assert re.search(r"a controller of 5 mm/s2 is up to 0\.\d+ mm off this plan", note)
    brisk = slow.model_copy(update={"machine_acceleration_mm_per_s2": 60.0})
    assert not [note for note in make(brisk, 3, 25.0).notes() if "controller" in note]
    assert [note for note in make(brisk, 3, 25.0).notes() if "in so short a motion" in note]


@pytest.mark.parametrize("machine_mm_per_s2", [2.0, 5.0, 20.0, 60.0])
@pytest.mark.parametrize("speed_mm_per_s", [0.5, 2.0])
def test_a_sluggish_controller_does_what_is_planned(speed_mm_per_s, machine_mm_per_s2):
    """Planned with the limit's acceleration alone, it cut the turns by a millimetre, at twice the speed."""
    triangle = Triangle(high_percent=20.0, speed_mm_per_s=speed_mm_per_s, cycles=3)
    made = make(TrajectorySpec.of(triangle, machine_acceleration_mm_per_s2=machine_mm_per_s2), 1, 25.0)
    done = play(read_program(made.program), made.spec.rate_hz)
    position_mm = np.interp(made.trajectory.time_s, done.time_s, done.position_mm)
    assert np.abs(position_mm - made.trajectory.position_mm).max() < 0.03
    assert made.statistics.v_max_mm_per_s < 1.02 * speed_mm_per_s


def test_limits_hold_at_any_rate_on_a_controller_set_to_the_limit():
    spec = preset("paper-1").model_copy(update={"machine_acceleration_mm_per_s2": 20.0})
    fine = play(read_program(make(spec, 3, 25.0).program), 500.0, Machine(acceleration_mm_per_s2=20.0))
    assert np.abs(np.diff(fine.position_mm, 2)).max() * 500.0**2 <= 20.0 * 1.001


def test_limiting_is_local_and_keeps_the_stroke():
    wild = TrajectorySpec(
        pieces=(Noise(duration_s=300, cells_per_s=0.5),), limits=Limits(v_max_mm_per_s=50, a_max_mm_per_s2=500)
    )
    free = plan(wild, 1, 25.0)
    tight = Limits(v_max_mm_per_s=0.5 * free.statistics().v_max_mm_per_s, a_max_mm_per_s2=20)
    held = plan(wild.model_copy(update={"limits": tight}), 1, 25.0).statistics()
    assert held.v_max_mm_per_s <= tight.v_max_mm_per_s
    assert held.v_mean_mm_per_s > 0.9 * free.statistics().v_mean_mm_per_s
    assert held.x_max_mm == pytest.approx(free.statistics().x_max_mm, rel=0.02)


def test_a_jerk_limit_is_held():
    spec = preset("paper-1")
    spec = spec.model_copy(update={"limits": spec.limits.model_copy(update={"j_max_mm_per_s3": 150.0})})
    executed = play(read_program(make(spec, 2, 25.0).program), 20.0)
    assert np.abs(np.diff(executed.position_mm, 3)).max() * 8000 <= 150.0
    free = play(read_program(make(preset("paper-1"), 2, 25.0).program), 20.0)
    assert np.abs(np.diff(free.position_mm, 3)).max() * 8000 > 150.0


@pytest.mark.parametrize(
    ("gauge", "seed", "match"),
    [(0.0, 1, "gauge length"), (-5.0, 1, "gauge length"), (np.nan, 1, "gauge length"), (25.0, -1, "seed")],
)
def test_an_impossible_request_is_refused(gauge, seed, match):
    with pytest.raises(UserError, match=match):
        plan(preset("paper-1"), seed, gauge)


def test_strain_beyond_the_travel_is_refused():
    spec = preset("paper-1").model_copy(update={"limits": Limits(x_min_mm=0, x_max_mm=5)})
    with pytest.raises(UserError, match="travel: this motion needs"):
        plan(spec, 1, 25.0)


def test_limits_that_no_motion_can_meet_are_refused():
    spec = TrajectorySpec(pieces=(Noise(duration_s=60),), limits=Limits(a_max_mm_per_s2=1e-4))
    with pytest.raises(UserError, match="would stretch this motion"):
        plan(spec, 1, 25.0)


def test_a_target_that_the_limits_exclude_is_refused():
    spec = preset("fast").model_copy(update={"limits": Limits(v_max_mm_per_s=2, a_max_mm_per_s2=5)})
    with pytest.raises(UserError, match=r"limits: |target cannot be reached"):
        plan(spec, 1, 25.0)


def test_a_gauge_length_in_metres_is_refused_before_any_search():
    with pytest.raises(
        UserError, match=r"over 0\.0075 mm, .* at most 0\.18\d mm/s; the gauge length is 0\.025 mm: is it"
    ):
        plan(preset("paper-1"), 1, 0.025)


def test_a_least_speed_that_the_range_does_not_allow_is_refused():
    # To and fro over 7.5 mm at 19 mm/s2 (5 % are kept in reserve): 2 sqrt(7.5 / 19) s a stroke, or 5.97 mm/s.
    spec = TrajectorySpec(pieces=(Noise(duration_s=60, min_speed_mm_per_s=6.2),), limits=Limits(a_max_mm_per_s2=20))
    with pytest.raises(UserError, match=r"min_speed_mm_per_s: at most 5\.97 mm/s over 7\.5 mm .* got 6\.2"):
        plan(spec, 1, 25.0)


@pytest.mark.parametrize(
    "values", [{"v_max_mm_per_s": 0}, {"a_max_mm_per_s2": np.nan}, {"x_min_mm": 5, "x_max_mm": 1}]
)
def test_senseless_limits_are_refused(values):
    with pytest.raises(UserError, match=next(iter(values))):
        Limits(**values)


@pytest.mark.parametrize(
    ("piece", "asked", "reached"),
    [
        (RateSweep(speeds_mm_per_s=(1, 20)), 20, 10),
        (Triangle(speed_mm_per_s=9, high_percent=2), 9, 3.16),
        (Multisine(duration_s=20, frequencies_hz=(1.0,), high_percent=10), 4, 2.4),
    ],
)
def test_a_speed_that_the_limits_do_not_let_the_axis_reach_is_said(piece, asked, reached):
    (note,) = make(TrajectorySpec.of(piece), 1, 25.0).notes()
    numbers = [float(number) for number in re.findall(r"([\d.]+) mm/s", note)]
    assert numbers == pytest.approx([asked, reached], rel=0.05)


def test_what_keeps_its_speeds_is_not_remarked_upon():
    pieces = Hold(duration_s=1) + Triangle(speed_mm_per_s=5) + Noise(duration_s=20)
    assert make(TrajectorySpec.of(pieces), 1, 25.0).notes() == []
    assert make(TrajectorySpec.of(Hold(duration_s=1) + Noise(duration_s=20)), 1, 25.0).notes() == []
