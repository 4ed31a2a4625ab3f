"""Recordings of a clumsy or hostile person end in a model or in a sentence, never in an error of a library's."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

import testbench as tb
from gcode.support.errors import UserError
from testbench.recordings.recording import Recording
from tests.testbench.builders import record, truth

GOOD = record(truth(), 90)
Change = Callable[[np.ndarray], np.ndarray]


def glitch(value: float) -> Change:
    """One sample in mid-recording that is far from the others."""
    return lambda values: np.where(np.arange(len(values)) == 777, value, values)


def changed(channel: str, change: Change) -> Recording:
    """The good recording with one channel changed."""
    if channel == "time_s":
        return replace(GOOD, time_s=change(GOOD.time_s))
    return replace(GOOD, channels={**GOOD.channels, channel: change(GOOD[channel])})


@pytest.mark.parametrize(
    ("channel", "change", "said"),
    [
        ("force_N", lambda f: f * 1e300, "force_N is .*check its unit"),
        ("force_N", glitch(1e300), r"row 777 \(counting from 0\): force_N is 1e\+300"),
        ("displacement_mm", lambda d: d * 1e300, "displacement_mm is"),
        ("displacement_mm", lambda d: d * 1000, "is a strain of .*check the gauge length"),
        ("displacement_mm", glitch(-1e4), r"row 777 \(counting from 0\): a displacement of -10000 mm"),
        ("resistance_ohm", lambda r: r * 1e300, "resistance_ohm is"),
        ("resistance_ohm", glitch(1e-300), r"row 777 \(counting from 0\): resistance_ohm is 1e-300"),
        ("resistance_ohm", lambda r: -r, "must be positive"),
        ("time_s", lambda t: t * 1e300, "time_s is"),
        ("time_s", lambda t: t * 1e-9, "too short"),
        ("time_s", lambda t: t[::-1], "time must increase"),
        ("time_s", lambda t: np.where(t > 45, t + 1e9, t), "nothing was recorded for 1e\\+09 s"),
        ("force_N", lambda f: f * math.nan, "force_N is nan"),
        ("force_N", lambda f: 0 * f + 1, "force_N is constant"),
        ("displacement_mm", lambda d: 0 * d, "too still"),
    ],
)
def test_what_no_tester_measures_is_refused_in_words(channel, change, said):
    with pytest.raises(UserError, match=said):
        tb.fit(changed(channel, change))


@pytest.mark.parametrize(
    ("channel", "change"),
    [
        ("force_N", lambda f: f * 1e5),
        ("force_N", lambda f: f * 1e-12),
        ("force_N", glitch(1e5)),
        ("force_N", lambda f: -f),
        ("force_N", np.round),
        ("displacement_mm", lambda d: d * 70),
        ("displacement_mm", glitch(499.0)),
        ("displacement_mm", lambda d: -d),
        ("resistance_ohm", glitch(1e17)),
        ("time_s", lambda t: t + 1.7e9),
        ("time_s", lambda t: np.where(t > 45, t + 7200, t)),
    ],
)
# What overflows on the way to a fit is a trial that is not taken.
@pytest.mark.filterwarnings("ignore:overflow encountered:RuntimeWarning")
def test_what_is_odd_but_possible_gets_a_model(channel, change):
    found = tb.fit(changed(channel, change))
    assert all(math.isfinite(error) for part in found.errors.values() for error in part.values())
    assert found.to_dict()


OTHER = record(truth(), 90, seed=1)
YEARS = replace(OTHER, time_s=1e7 * OTHER.time_s, source="of years")


@pytest.mark.parametrize(
    ("recordings", "held_out", "said"),
    [
        ([GOOD, YEARS], OTHER, "of years: .* are more than 5 million points; cut it"),
        ([GOOD, OTHER], YEARS, "of years: .* are more than 5 million points; cut it"),
        ([YEARS, GOOD], OTHER, "at the 2e-06 Hz of of years are fewer than the 170 points"),
        ([YEARS], GOOD, "at the 2e-06 Hz of of years are fewer than the 170 points"),
        ([GOOD, replace(GOOD, source="a copy")], OTHER, "a copy: holds the same samples as"),
        ([GOOD, OTHER], GOOD, "holds the same samples as .*; of several recordings each is made after"),
    ],
)
def test_what_cannot_be_one_history_is_refused_in_words(recordings, held_out, said):
    with pytest.raises(UserError, match=said):
        tb.diagnose(recordings, held_out, progress=False)
