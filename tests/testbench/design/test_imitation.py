"""The measurement that was not made yet."""

from __future__ import annotations

import numpy as np
import pytest

from testbench.design.ahead import planned


def test_a_planned_measurement_has_the_motion_and_nothing_else():
    class Motion:
        time_s, position_mm = np.arange(200) / 20, np.linspace(0, 5, 200)
        rate_hz, duration_s = 20.0, 9.95

    measurement = planned(Motion(), 25.0, ("force",))
    assert measurement.signals["strain"][-1] == pytest.approx(0.2)
    assert measurement.channels == ("force",)
    assert measurement.counts.sum() == 200 - 60
