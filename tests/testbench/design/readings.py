"""What a planned motion of some model would be read as."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from testbench.knit.model import KnitModel
from testbench.measurements.measurement import Measurement, prepare
from testbench.recordings.channels import DISPLACEMENT, FORCE, RESISTANCE
from testbench.recordings.recording import Recording


def read(planned: Measurement, model: KnitModel, noise: Mapping[str, float], seed: int) -> Measurement:
    """The motion as a recording of force and resistance, with white noise."""
    clean, rng = planned.modelled(model), np.random.default_rng(seed)
    noisy = {c: clean[c] + sd * rng.standard_normal(len(clean[c])) for c, sd in noise.items()}
    gauge_length_mm = planned.recording.gauge_length_mm
    channels = {
        DISPLACEMENT: planned.signals["strain"] * gauge_length_mm,
        FORCE: noisy["force"],
        RESISTANCE: np.exp(-noisy["conductance"]),
    }
    return prepare(Recording(planned.signals["time_s"], channels, gauge_length_mm))
