"""Materials whose answer is known, measured by others; skipped where the recordings are not there."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from testbench.diagnosis import diagnose
from testbench.recordings.channels import DISPLACEMENT, FORCE
from testbench.recordings.recording import Recording

pytestmark = pytest.mark.slow
REAL = Path(__file__).resolve().parents[3] / "../shared/data/real"


def vhb(name: str) -> Recording:
    """A ramp to a stretch of 2 or 2.5, held for half an hour."""
    path = REAL / "vhb4910_elastomer" / f"{name}.csv"
    if not path.exists():
        pytest.skip(f"{path.name}: the measured recordings are not here")
    table = pd.read_csv(path)
    channels = {DISPLACEMENT: table["displacement_mm"].to_numpy(), FORCE: table["force_N"].to_numpy()}
    return Recording(table["time_s"].to_numpy(), channels, 80.0)


@pytest.mark.parametrize(("calibration", "held_out"), [("relax_2d0", "relax_2d5"), ("relax_2d5", "relax_2d0")])
def test_vhb_relaxes(calibration, held_out):
    result = diagnose(vhb(calibration), vhb(held_out), most=1)
    assert result.ranking[0].effect == "stress_relaxation"
    assert result.verdict == "missing"
    # At a stretch that it was not fitted on: a fifth of what the base leaves.
    assert result.error_after["force"] < 0.2 * result.error_before["force"]
