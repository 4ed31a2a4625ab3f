"""What is learned from: recorded time, in which gaps do not count."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from compensation.series.preprocessing import apart, series_of
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


def test_of_recordings_that_begin_alike_the_beginning_is_learned_once(recordings, caplog):
    """Two programs with one break-in, played on a simulated sensor from one seed: refused as one recording twice."""
    first, other = recordings[:2]
    rows = first.time_s < 60.0
    branched = replace(
        first,
        channels={name: np.where(rows, first[name], other[name][: len(rows)]) for name in first.channels},
        source="branched",
    )
    one, two = (series_of(recording, "force", 20.0) for recording in (first, branched))
    for given in ([one, two], [two, one]):
        kept = apart(given, "give each once")
        assert kept[0].digest == given[0].digest
        assert kept[1].time_s[0] == pytest.approx(60.0, abs=0.1)
        assert kept[1].time_s[-1] == given[1].time_s[-1]
    assert "branched: its first 60 s are those of simulated-1" in caplog.text
    for part in (branched.between(0.0, 65.0), branched.between(20.0, 120.0)):
        with pytest.raises(UserError, match=r"holds the same samples as simulated-1, .*; give each once$"):
            apart([one, series_of(replace(part, source="a part"), "force", 20.0)], "give each once")
