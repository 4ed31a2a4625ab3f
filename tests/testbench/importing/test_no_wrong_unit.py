"""The law of import: over generated layouts and units, the right numbers or a refusal, never other numbers."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings

from gcode.support.errors import UserError
from testbench.importing.wish import Wish
from tests.testbench.importing.exports import import_csv
from tests.testbench.importing.layouts import CHANNELS, TRUE, Written, files

LAYOUTS = 200


@settings(max_examples=LAYOUTS, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(written=files())
def test_no_wrong_unit_is_ever_accepted(written: Written) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "lab.csv"
        path.write_bytes(written.data)
        if written.unsaid:
            with pytest.raises(UserError, match=r"unit|cannot tell what the comma means"):
                import_csv(path, Wish(40.0))
            return
        recording = import_csv(path, Wish(40.0)).recording
    assert recording.time_s == pytest.approx(TRUE["time"], abs=1e-6)
    assert set(recording.channels) == {CHANNELS[role] for role in written.roles if role != "time"}
    for role in written.roles:
        if role != "time":
            assert np.allclose(recording[CHANNELS[role]], TRUE[role], rtol=1e-7, atol=1e-9), role
