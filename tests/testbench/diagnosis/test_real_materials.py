"""Materials whose answer is known, measured by others; skipped where the recordings are not there."""

from __future__ import annotations

from pathlib import Path

import pytest

from testbench.diagnosis import diagnose
from testbench.recordings.files import read_recording
from testbench.recordings.recording import Recording

pytestmark = pytest.mark.slow
REAL = Path(__file__).resolve().parents[3] / "../shared/data/real"


def measured(folder: str, name: str, gauge_length_mm: float) -> Recording:
    """One recording with all of its channels."""
    path = REAL / folder / f"{name}.csv"
    if not path.exists():
        pytest.skip(f"{path.name}: the measured recordings are not here")
    return read_recording(path, gauge_length_mm)


def vhb(name: str) -> Recording:
    """A ramp to a stretch of 2 or 2.5, held for half an hour."""
    return measured("vhb4910_elastomer", name, 80.0)


def strip(name: str) -> Recording:
    """Carbon black in silicone, or silicone alone, moved in jerks of half a second."""
    return measured("cb_silicone_strip", name, 40.0)


@pytest.mark.parametrize(("calibration", "held_out"), [("relax_2d0", "relax_2d5"), ("relax_2d5", "relax_2d0")])
def test_vhb_relaxes(calibration, held_out):
    result = diagnose(vhb(calibration), vhb(held_out), most=1)
    assert result.ranking[0].effect == "stress_relaxation"
    assert result.verdict == "missing"
    # At a stretch that it was not fitted on: a fifth of what the base leaves.
    assert result.error_after["force"] < 0.2 * result.error_before["force"]


def test_silicone_without_carbon_relaxes():
    """What the machine's jerks leave in the ramps is noise; what is left in the holds is not."""
    result = diagnose(strip("cb0_control_holds8_speeds_v2"))
    assert (result.verdict, result.ranking[0].effect) == ("missing", "stress_relaxation")


def test_the_conductance_of_a_carbon_strip_overshoots():
    """No law is exact there: a free-form map predicts better than the law alone, but not better than both."""
    one, other = (strip(f"cb7.5_s2_triangles_prestrain10_{side}") for side in "ab")
    result = diagnose(one, other, most=1)
    assert (result.verdict, result.ranking[0].effect) == ("missing", "electrical_overshoot")
    assert result.error_after["conductance"] < 0.5 * result.error_before["conductance"]
