"""What is small is written with more decimals, and read again as it was; what is usual keeps its form."""

from __future__ import annotations

import numpy as np
import pytest

from gcode.support.errors import UserError
from testbench.recordings.files import read_recording, write_recording_csv
from testbench.recordings.recording import Recording


def small(step_s=0.025, force_N=1.0, length_mm=10.0, resistance_ohm=1e4) -> Recording:
    part = np.linspace(0.1, 1.0, 10)
    sizes = {"displacement_mm": length_mm, "force_N": force_N, "resistance_ohm": resistance_ohm}
    return Recording(step_s * np.arange(10.0), {name: size * part for name, size in sizes.items()}, 25.0)


@pytest.mark.parametrize(
    "sizes", [{}, {"step_s": 2.5e-7}, {"force_N": 3e-6}, {"length_mm": 4e-6}, {"resistance_ohm": 1e-6}]
)
def test_what_is_small_is_read_as_it_was(tmp_path, sizes):
    given = small(**sizes)
    write_recording_csv(tmp_path / "a.csv", given)
    found = read_recording(tmp_path / "a.csv", 25.0)
    assert found.time_s == pytest.approx(given.time_s, rel=1e-3)
    for name, values in given.channels.items():
        assert found[name] == pytest.approx(values, rel=1e-3)


def test_what_is_usual_keeps_its_form(tmp_path):
    write_recording_csv(tmp_path / "a.csv", small(force_N=0.012))
    assert (tmp_path / "a.csv").read_text().splitlines()[1] == "0.000000,1.000000,0.001200,1000.000"


def test_times_that_no_decimals_can_tell_apart_are_refused(tmp_path):
    with pytest.raises(UserError, match=r"a step of 1e-17 s is too short .*--time-unit"):
        write_recording_csv(tmp_path / "a.csv", small(step_s=1e-17))
