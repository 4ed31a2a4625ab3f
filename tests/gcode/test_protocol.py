"""Pieces do what their names say, chain with +, and survive TOML."""

from __future__ import annotations

import numpy as np
import pytest

import gcode
from gcode.mach4.header import flatten, header_lines, unflatten
from gcode.mach4.reader import read_program
from gcode.programs.make import make_again
from gcode.support.errors import UserError
from gcode.trajectories.designed import (
    Hold,
    Multisine,
    Noise,
    Ramp,
    RateSweep,
    ReturnToZero,
    Staircase,
    Triangle,
)
from gcode.trajectories.planning import plan
from gcode.trajectories.presets import PRESETS, preset
from gcode.trajectories.protocol import Protocol
from gcode.trajectories.trajectory import Limits, TrajectorySpec, read_spec, spec_to_toml

ALL = (
    Hold(duration_s=2)
    + Ramp(to_percent=10, speed_mm_per_s=1)
    + Triangle(high_percent=20, speed_mm_per_s=2, cycles=2)
    + Staircase(levels_percent=(10, 20), speed_mm_per_s=1, hold_s=3)
    + RateSweep(high_percent=10, speeds_mm_per_s=(0.5, 1))
    + Multisine(duration_s=5, frequencies_hz=(0.1, 0.3), amplitudes=(1.0, 0.5))
    + ReturnToZero(rest_s=1)
    + Noise(duration_s=10)
)


def planned(protocol, **settings):
    return plan(TrajectorySpec.of(protocol, **settings), 1, 50.0)


def test_addition_chains_pieces_and_protocols():
    a, b, c = ALL.pieces[:3]
    assert (a + b + c).pieces == (a, b, c) == (a + (b + c)).pieces == (Protocol(pieces=(a,)) + (b + c)).pieces


def test_a_sum_chains_pieces_and_protocols_and_nothing_else():
    a, b, c = ALL.pieces[:3]
    assert sum([a, b, c]).pieces == (a, b, c) == sum([a, b + c]).pieces == sum([a + b, c]).pieces
    with pytest.raises(TypeError, match="unsupported operand"):
        3 + a


def test_zero_is_told_as_zero():
    """It was ``5.88e-19 mm``, and may have been ``-0.000``."""
    made = gcode.generate(Triangle(low_percent=-10, high_percent=0, speed_mm_per_s=2), seed=2)
    assert repr(made).endswith("-2.5 to 0 mm>")
    assert made.statistics.model_copy(update={"x_max_mm": -1e-9}).lines()[0].endswith("-2.500 to 0.000 mm")


@pytest.mark.parametrize(
    ("rate_hz", "a_max_mm_per_s2", "asked"),
    [(20.0, 5.0, 5.0), (200.0, 5.0, 9.0), (500.0, 20.0, 9.0), (1000.0, 20.0, 5.0)],
)
def test_a_plan_is_no_faster_than_a_controller_that_sees_so_many_blocks_can_be(rate_hz, a_max_mm_per_s2, asked):
    """Twenty blocks are a tenth of a second at 200 Hz: the program was refused by its own check, between samples."""
    limits = gcode.Limits(a_max_mm_per_s2=a_max_mm_per_s2)
    spec = TrajectorySpec.of(Triangle(high_percent=50, speed_mm_per_s=asked), rate_hz=rate_hz, limits=limits)
    made = gcode.generate(spec, seed=1, gauge_length_mm=40)
    reached = made.statistics.v_max_mm_per_s
    assert (reached < 0.95 * asked) == any("let the axis reach" in note for note in made.notes())
    assert (reached > 0.95 * asked) == (rate_hz == 20)


@pytest.mark.parametrize(
    ("rate_hz", "remedy"),
    [(20.0, "raise them"), (1000.0, r"lower the spec's rate_hz \(a controller sees 20 samples")],
)
def test_a_motion_that_is_stretched_too_far_is_told_by_what(rate_hz, remedy):
    limits = gcode.Limits(v_max_mm_per_s=1 if rate_hz == 20 else 10, a_max_mm_per_s2=5)
    spec = TrajectorySpec.of(Triangle(high_percent=50, speed_mm_per_s=9), rate_hz=rate_hz, limits=limits)
    with pytest.raises(UserError, match=f"would stretch this motion from .*; {remedy}"):
        gcode.generate(spec, seed=1, gauge_length_mm=40)


def test_what_a_jerk_limit_takes_from_a_stroke_is_noted():
    """It was not: a triangle to 5 mm went to 4.1 mm, and nobody was told."""
    triangle = Triangle(high_percent=20, speed_mm_per_s=2)
    assert gcode.generate(triangle, seed=1).notes() == []
    (note,) = gcode.generate(triangle, seed=1, j_max_mm_per_s3=20).notes()
    assert note == "5 mm are asked for, of which the jerk limit leaves 4.1 mm"


def test_a_turn_that_lies_between_two_samples_is_noted():
    """At 1 Hz a triangle to 1.25 mm went to 0.97 mm, and nobody was told."""
    triangle = Triangle(high_percent=5, speed_mm_per_s=1)
    assert gcode.generate(triangle, seed=0).notes() == []
    (note,) = gcode.generate(TrajectorySpec.of(triangle, rate_hz=1), seed=0).notes()
    assert note == "1.25 mm are asked for, of which samples at 1 Hz leave 0.9737 mm"


def test_a_target_that_a_jerk_limit_takes_away_is_told_as_such():
    """It was laid at the door of the gauge length and the range alone."""
    (note, *_) = gcode.generate("paper-1", 3, duration_s=400, j_max_mm_per_s3=60).notes()
    assert note.startswith("the target is missed at this gauge length and range within this jerk limit: a_mean")


def test_a_jerk_limit_that_is_too_low_is_told_in_the_numbers_that_were_given():
    """It was told in those that a plan uses of them: 3.8 and 19."""
    with pytest.raises(UserError, match=r"j max 4 mm/s3 is too low for a max 20 mm/s2 \(at least 8\)"):
        gcode.generate(Triangle(speed_mm_per_s=1), seed=1, j_max_mm_per_s3=4)


def test_a_triangle_reaches_its_strains_at_its_speed():
    run = planned(Triangle(high_percent=20, speed_mm_per_s=2, cycles=3), limits=Limits(a_max_mm_per_s2=50))
    assert run.position_mm.max() == pytest.approx(10.0, abs=0.01)
    assert run.statistics().v_max_mm_per_s == pytest.approx(2.0, abs=0.01)
    step = np.sign(np.diff(run.position_mm))
    assert ((step[:-1] > 0) & (step[1:] < 0)).sum() == 3
    assert run.duration_s == pytest.approx(3 * 2 * (5.0 + 2 / 50 / 0.95), abs=0.3)


def test_a_staircase_holds_each_level():
    run = planned(Staircase(levels_percent=(10, 20), speed_mm_per_s=1, hold_s=3))
    for level in (5.0, 10.0):
        assert (np.abs(run.position_mm - level) < 1e-6).sum() / 20 == pytest.approx(3.0, abs=0.2)


def test_a_rate_sweep_goes_at_each_rate():
    run = planned(RateSweep(high_percent=20, speeds_mm_per_s=(0.5, 2.0)))
    speed = np.abs(np.diff(run.position_mm)) * 20
    assert (np.abs(speed - 0.5) < 0.01).sum() / 20 == pytest.approx(40, rel=0.05)
    assert (np.abs(speed - 2.0) < 0.01).sum() / 20 == pytest.approx(10, rel=0.05)


def test_a_multisine_fills_its_range_and_holds_its_frequencies():
    run = planned(Multisine(duration_s=200, frequencies_hz=(0.1, 0.25), low_percent=5, high_percent=15))
    middle = run.position_mm[400:3600]
    assert (middle.min(), middle.max()) == pytest.approx((2.5, 7.5), abs=0.2)
    power = np.abs(np.fft.rfft((middle - middle.mean()) * np.hanning(len(middle))))
    peaks = np.fft.rfftfreq(len(middle), 0.05)[np.argsort(power)[-6:]]
    for frequency_hz in (0.1, 0.25):
        assert np.min(np.abs(peaks - frequency_hz)) < 0.01
    assert np.all(np.abs(peaks[:, None] - [0.1, 0.25]).min(axis=1) < 0.02)


def test_the_offset_is_approached_first_and_left_last():
    run = planned(Hold(duration_s=2) + Triangle(speed_mm_per_s=1), offset_mm=1.5)
    assert run.position_mm[0] == run.position_mm[-1] == 0.0
    assert (np.abs(run.position_mm - 1.5) < 1e-6).sum() >= 40
    assert run.position_mm.max() == pytest.approx(1.5 + 15.0, abs=0.01)


def test_noise_lasts_as_long_as_asked_as_executed():
    run = planned(Noise(duration_s=100, min_speed_mm_per_s=0.3))
    start = abs(run.position_mm[:200]).max()
    assert 100 < run.duration_s < 100 + 2 * (start + 16)


@pytest.mark.parametrize("name", PRESETS)
def test_presets_survive_toml(name, tmp_path):
    (tmp_path / "spec.toml").write_text(spec_to_toml(preset(name)))
    assert read_spec(tmp_path / "spec.toml") == preset(name)


def test_every_piece_survives_toml_and_the_header(tmp_path):
    spec = TrajectorySpec.of(ALL, name="all", offset_mm=0.5)
    (tmp_path / "spec.toml").write_text(spec_to_toml(spec))
    assert read_spec(tmp_path / "spec.toml") == spec
    flat = flatten({"spec": spec.model_dump(mode="json", exclude_none=True)})
    assert TrajectorySpec.model_validate(unflatten(flat, "spec")) == spec


def test_a_comment_that_would_break_the_file_is_refused():
    for value in ("a" * 200, "nested (comment)"):
        with pytest.raises(UserError, match="header: note"):
            header_lines({"note": value})


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("pieces = 3", "spec.toml: not a usable spec: pieces"),
        ("[[pieces]]\nkind = 'dance'", "spec.toml: not a usable spec: pieces.0"),
        ("[[pieces]]\nkind = 'hold'\nduration_s = 1e9", "duration_s.*172800"),
        ("[[pieces]]\nkind = 'hold'\nduration_s = nan", "duration_s.*finite"),
        ("[[pieces]]\nkind = 'noise'\noctaves = 0", "octaves.*greater than or equal to 1"),
        ("[[pieces]]\nkind = 'noise'\npersistence = 0.0", "persistence"),
        ("[[pieces]]\nkind = 'noise'\nhigh_percent = -5.0", "low_percent must be below"),
        (
            "[[pieces]]\nkind = 'noise'\nlacunarity = 0",
            "lacunarity: there is no such entry; leave it out",
        ),
        ("[[pieces]]\nkind = 'hold'", "duration_s: this entry is needed"),
        ("not toml", "not valid TOML"),
    ],
)
def test_a_bad_spec_names_file_and_field(tmp_path, text, match):
    (tmp_path / "spec.toml").write_text(text)
    with pytest.raises(UserError, match=match):
        read_spec(tmp_path / "spec.toml")


def test_amplitudes_must_match_the_frequencies():
    with pytest.raises(UserError, match="as many as frequencies_hz"):
        Multisine(duration_s=1, frequencies_hz=(0.1, 0.2), amplitudes=(1.0,))


@pytest.mark.parametrize(
    "call",
    [
        lambda odd: gcode.Limits(v_max_mm_per_s=odd),
        lambda odd: gcode.Machine(look_ahead_blocks=odd),
        lambda odd: gcode.RateSweep(speeds_mm_per_s=(1, odd)),
        lambda odd: gcode.TrajectorySpec(pieces=(gcode.Hold(duration_s=1),), limits={"v_max_mm_per_s": odd}),
        lambda odd: gcode.TrajectorySpec(pieces=[{"kind": "hold", "duration_s": odd}]),
        lambda odd: gcode.generate(gcode.Ramp(to_percent=1, speed_mm_per_s=1), 1, v_max_mm_per_s=odd),
        lambda odd: gcode.generate(gcode.Ramp(to_percent=1, speed_mm_per_s=1), 1, machine_acceleration_mm_per_s2=odd),
        lambda odd: gcode.generate("paper-1", 1, duration_s=odd),
    ],
)
@pytest.mark.parametrize("odd", ["5", True])
def test_no_number_is_made_of_a_text_or_of_a_yes(call, odd):
    with pytest.raises(UserError, match="must be a number, got"):
        call(odd)


@pytest.mark.parametrize("name", ["51", "true", "1e5"])
def test_a_name_that_looks_like_a_number_is_made_again_from_the_header(name):
    """It became a number on the way, so that the program was refused by its own check."""
    spec = TrajectorySpec.of(gcode.Ramp(to_percent=1, speed_mm_per_s=1), name=name)
    made = gcode.generate(spec, 1)
    assert gcode.check(made).ok
    assert make_again(read_program(made.program)).program == made.program
