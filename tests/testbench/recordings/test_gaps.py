"""A gap of a day in a recording is a gap: it is found, and no grid is filled with what was never recorded."""

from __future__ import annotations

import numpy as np
import pytest

from gcode.support.errors import UserError
from testbench.recordings.recording import Recording


def recording(time_s) -> Recording:
    time_s = np.asarray(time_s, dtype=float)
    return Recording(time_s, {"displacement_mm": np.sin(time_s)}, 25.0)


def test_gaps_and_segments():
    time_s = np.concatenate([np.arange(100) / 40, 86400 + np.arange(50) / 40, [200_000.0], 300_000 + np.arange(3)])
    gappy = recording(time_s)
    assert [round(end - start) for start, end in gappy.gaps] == [86398, 113599, 100000]
    assert [len(part) for part in gappy.segments()] == [100, 50, 3]
    assert recording(np.arange(10) * 10.0).gaps == ()  # a device of one sample in ten seconds
    assert len(recording(np.arange(10) * 10.0).segments()) == 1


def test_a_gap_does_not_slow_the_sampling():
    day = recording(np.concatenate([np.arange(100) / 40, 86400 + np.arange(100) / 40]))
    assert day.mean_rate_hz == pytest.approx(40.0)
    assert recording(np.arange(10) * 10.0).mean_rate_hz == pytest.approx(0.1)
    assert recording([0.0, 3.0]).mean_rate_hz == pytest.approx(1 / 3)


def test_a_short_gap_is_bridged_and_a_day_is_not():
    short = recording(np.concatenate([np.arange(100) / 40, 60 + np.arange(100) / 40]))
    assert len(short.resampled(20.0)) == pytest.approx(62.5 * 20, abs=2)
    day = recording(np.concatenate([np.arange(100) / 40, 86400 + np.arange(100) / 40]))
    with pytest.raises(UserError, match=r"nothing was recorded for 8.64e\+04 s after 2.475 s"):
        day.resampled(20.0)
    assert [len(part.resampled(20.0)) for part in day.segments()] == [50, 50]


@pytest.mark.parametrize("end_s", [1e9, 1e11])
def test_no_time_is_so_late_that_it_fills_the_memory(end_s):
    with pytest.raises(UserError, match="a uniform grid of 20 Hz"):
        recording([0.0, 1.0, 2.0, end_s]).resampled(20.0)
    with pytest.raises(UserError, match="give a lower rate"):
        recording(np.linspace(0, end_s, 50)).resampled(20.0)
