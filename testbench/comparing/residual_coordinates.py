"""Coordinates over which a residual is mapped: what the knit did, and what it had been through."""

from __future__ import annotations

import numpy as np

from testbench.comparing.cell import HOLD_RATE
from testbench.knit.effect import FloatArray
from testbench.knit.kernels import turns
from testbench.measurements.measurement import Measurement

RATE_SMOOTHING_S = 0.15
COORDINATES = (
    "strain",
    "strain_rate",
    "elapsed_s",
    "largest_strain",
    "since_reversal_s",
    "since_hold_s",
    "cycle",
    "temperature_C",
)


def coordinates(measurement: Measurement) -> dict[str, FloatArray]:
    """Each of `COORDINATES` on the grid, shape (n,), and ``direction``: +1 stretching, -1 releasing, 0 hold."""
    strain = measurement.signals["strain"]
    rate = strain_rate(strain, measurement.dt_s)
    direction = np.where(np.abs(rate) < HOLD_RATE, 0.0, np.sign(rate))
    threshold = max(0.01 * float(np.ptp(strain)), 1e-4)
    _, known, count = turns(strain, threshold)
    found = {
        "strain": strain,
        "strain_rate": rate,
        "direction": direction,
        "elapsed_s": measurement.signals["time_s"],
        "largest_strain": np.maximum.accumulate(strain),
        "since_reversal_s": (np.arange(len(strain)) - np.ceil(known)) * measurement.dt_s,
        "since_hold_s": _run_length(direction == 0) * measurement.dt_s,
        "cycle": np.floor(count / 2),
    }
    if "temperature_C" in measurement.signals:
        found["temperature_C"] = measurement.signals["temperature_C"]
    return found


def strain_rate(strain: FloatArray, dt_s: float) -> FloatArray:
    """Smoothed derivative, shape (n,) in 1/s."""
    width = max(round(RATE_SMOOTHING_S / dt_s), 1)
    padded = np.pad(np.gradient(strain, dt_s), (width // 2, width - 1 - width // 2), mode="edge")
    return np.convolve(padded, np.full(width, 1 / width), mode="valid")


def _run_length(inside: np.ndarray) -> FloatArray:
    """Samples since `inside` last became true, 0 where it is false."""
    index = np.arange(len(inside))
    last_outside = np.maximum.accumulate(np.where(inside, -1, index))
    return np.where(inside, index - last_outside, 0).astype(float)
