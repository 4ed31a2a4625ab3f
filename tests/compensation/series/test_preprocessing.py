"""What is learned from: recorded time, in which gaps do not count."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from compensation.series.preprocessing import series_of
from gcode.support.errors import UserError
from testbench.recordings.recording import recorded_duration_s, recorded_time_s
from tests.compensation.conftest import paused


def test_recorded_time_stands_still_in_a_gap():
    time_s = np.array([3.0, 3.1, 3.2, 60.0, 60.1, 80.0, 80.1])
    np.testing.assert_allclose(recorded_time_s(time_s), [0.0, 0.1, 0.2, 0.2, 0.3, 0.3, 0.4], atol=1e-12)
    assert recorded_duration_s(time_s) == pytest.approx(0.4)
    assert recorded_duration_s(time_s[:1]) == 0.0


def test_the_length_of_a_recording_is_of_what_was_recorded(recordings):
    with pytest.raises(UserError, match=r"7\.9 s long; a compensator needs at least 10 s"):
        series_of(paused(recordings[0].between(0.0, 8.0), 4.0, 60.0), "force", 20.0)


def test_a_clock_in_milliseconds_is_asked_about_and_not_learned_from(recordings):
    """Five minutes were put on a grid of six million points, 500 of them between two samples."""
    late = replace(recordings[0], time_s=1000.0 * recordings[0].time_s)
    with pytest.raises(UserError, match=r"one sample in .* is its time in s\? At 20 Hz nearly all of it"):
        series_of(late, "force", 20.0)
