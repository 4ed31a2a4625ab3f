"""What a planned motion of some model would be read as."""

from __future__ import annotations

import numpy as np

from testbench.knit.model import KnitModel
from testbench.measurements.measurement import Measurement
from testbench.measurements.preparing import prepare
from tests.testbench.builders import record


def read(planned: Measurement, model: KnitModel, seed: int) -> Measurement:
    """The motion as a recording of force and resistance, with white noise."""
    time_s, strain = planned.signals["time_s"], planned.signals["strain"]
    duration_s = time_s[-1] + planned.dt_s
    return prepare(record(model, duration_s, 1 / planned.dt_s, seed, strain=lambda t: np.interp(t, time_s, strain)))
