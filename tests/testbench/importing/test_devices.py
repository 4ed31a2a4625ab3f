"""What many devices, loggers and programs write is the test that it is, to the last sample."""

from __future__ import annotations

from typing import Any

import pytest

from testbench.importing.wish import Wish
from tests.testbench.importing.devices import EXPORTS
from tests.testbench.importing.exports import EXTENSION_MM, FORCE_N, RESISTANCE_OHM, TIME_S, import_csv

TRUE = {"displacement_mm": EXTENSION_MM, "force_N": FORCE_N, "resistance_ohm": RESISTANCE_OHM}


@pytest.mark.parametrize("name", EXPORTS)
def test_every_export_is_the_same_test(tmp_path, name):
    export = EXPORTS[name]
    (tmp_path / "lab.txt").write_bytes(export.data)
    wish: dict[str, Any] = export.wish
    recording = import_csv(tmp_path / "lab.txt", Wish(40.0, **wish)).recording
    assert sorted(recording.channels) == sorted(export.channels)
    assert recording.time_s == pytest.approx(TIME_S, abs=1e-4)
    for channel in export.channels:
        assert recording[channel] == pytest.approx(TRUE[channel], rel=1e-5, abs=1e-5)
