"""Gaps and signs that make a model's answer doubtful are said, or refused where there would be no answer."""

from __future__ import annotations

import logging
from dataclasses import replace

import numpy as np
import pytest

from gcode.support.errors import UserError
from testbench.recordings import doubts
from testbench.recordings.recording import Recording


def with_gap(gap_s: float, rate_hz: float = 20.0) -> Recording:
    """90 s with a gap in the middle."""
    time_s = np.arange(round(90 * rate_hz)) / rate_hz
    time_s = np.where(time_s >= 45, time_s + gap_s, time_s)
    moved = np.sin(time_s)
    return Recording(time_s, {"displacement_mm": 2 + moved, "force_N": 3 + moved}, 25.0, f"gap {gap_s:g}")


@pytest.fixture
def said(monkeypatch, caplog) -> pytest.LogCaptureFixture:
    """What is said in a test; nothing was said before it."""
    monkeypatch.setattr(doubts, "_SAID", set())
    caplog.set_level(logging.WARNING, "knitbench")
    return caplog


@pytest.mark.parametrize("gap_s", [86_400 * 365.25, 1e10])
def test_a_recording_that_is_nearly_only_a_gap_is_refused_with_where_it_is(gap_s):
    with pytest.raises(UserError, match=r"nothing was recorded for .* after 44.95 s"):
        doubts.check_gap(with_gap(gap_s))


def test_a_gap_longer_than_what_was_recorded_is_said(said):
    doubts.check_gap(with_gap(3600))
    assert "nothing was recorded for 3600 s after 44.95 s" in said.text


@pytest.mark.parametrize("gap_s", [0.0, 20.0])
def test_a_short_gap_is_not_worth_a_word(said, gap_s):
    doubts.check_gap(with_gap(gap_s))
    assert not said.records


def test_sampling_that_slows_down_in_a_hold_is_no_gap(said):
    time_s = np.concatenate([np.arange(400) / 20, 20 * 1.05 ** np.arange(1, 200)])
    values = {"displacement_mm": np.minimum(time_s, 5.0), "force_N": np.exp(-time_s)}
    doubts.check_gap(Recording(time_s, values, 25.0))
    assert not said.records


def test_a_held_out_recording_is_bounded_by_the_grid_of_the_calibration():
    fine = with_gap(0.0)
    doubts.check_grid([with_gap(86_400)], fine, 25.0, 170)
    with pytest.raises(UserError, match="million points; cut it"):
        doubts.check_grid([with_gap(1e7)], fine, 25.0, 170)
    doubts.check_grid([with_gap(1e7)], with_gap(0.0, rate_hz=0.2), 25.0, 10)


def test_what_follows_is_bounded_together_with_its_rests():
    fine = with_gap(0.0)
    doubts.check_grid([with_gap(86_400)] * 2, fine, 25.0, 170)
    with pytest.raises(UserError, match="million points"):
        doubts.check_grid([with_gap(86_400)] * 3, fine, 25.0, 170)
    with pytest.raises(UserError, match="million points"):
        doubts.check_grid([with_gap(0.0)] * 3, fine, 25.0, 170, rest_s=86_400.0)


def test_the_grid_is_as_fine_as_the_quicker_part_of_a_recording():
    quick, slow = np.arange(1000) / 25, 40 + 1e4 * np.arange(1, 10)
    first = Recording(np.r_[quick, slow], {"displacement_mm": np.zeros(1009)}, 25.0)
    with pytest.raises(UserError, match="at the 25 Hz of"):
        doubts.check_grid([with_gap(1e7)], first, 25.0, 1)


def test_a_held_out_recording_needs_points_on_the_grid_of_the_calibration():
    slow = Recording(np.arange(400) * 1e6, {"displacement_mm": np.zeros(400)}, 25.0, "ten years")
    with pytest.raises(UserError, match=r"at the 1e-06 Hz of ten years are fewer than the 170 points"):
        doubts.check_grid([with_gap(0.0)], slow, 25.0, 170)


def test_what_is_held_out_of_itself_is_said(said):
    doubts.say_if_same(with_gap(0.0), with_gap(1.0))
    assert not said.records
    doubts.say_if_same(with_gap(0.0), replace(with_gap(0.0), source="another name"))
    assert "holds the same samples as what is fitted on" in said.text


@pytest.mark.parametrize(("times", "is_said"), [(1, False), (2e4, True)])
def test_a_clock_in_ms_is_doubted(said, times, is_said):
    recording = with_gap(0.0)
    doubts.say_slow(replace(recording, time_s=times * recording.time_s))
    assert ("is its time in s?" in said.text) == is_said


@pytest.mark.parametrize("turned", ["force_N", "displacement_mm"])
def test_a_force_of_the_other_sign_is_said(said, turned):
    good = with_gap(0.0)
    doubts.say_sign(replace(good, channels={**good.channels, turned: -good[turned]}))
    assert f"--negate {turned.partition('_')[0]}" in said.text


def test_a_compression_in_which_both_are_negative_is_fine(said):
    good = with_gap(0.0)
    doubts.say_sign(replace(good, channels={name: -values for name, values in good.channels.items()}))
    doubts.say_sign(good)
    assert not said.records


def test_a_recording_given_twice_is_refused_by_its_samples_whatever_its_name():
    one = with_gap(0.0)
    doubts.check_distinct([one, with_gap(1.0)], "give each once")
    with pytest.raises(UserError, match=r"^a copy: holds the same samples as gap 0; give each once$"):
        doubts.check_distinct([one, replace(one, source="a copy")], "give each once")
    with pytest.raises(UserError, match="holds the same samples"):
        doubts.check_distinct([one, one], "give each once")


def test_a_recording_with_much_missing_is_said(said):
    doubts.say_gaps(with_gap(0.0))
    assert not said.text
    doubts.say_gaps(replace(with_gap(300.0), source="paused"))
    assert "paused: nothing was recorded in" in said.text
