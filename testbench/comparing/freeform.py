"""A free-form map of the residual over its coordinates: the ceiling of what any effect could explain.

Learnt on one recording and judged on the other, it says how much of the residual is structure at all, and what that
structure depends on, whether or not the catalogue knows an effect for it.
"""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from testbench.comparing.residual_coordinates import coordinates
from testbench.knit.effect import FloatArray
from testbench.measurements.measurement import Measurement

MEMORIES_S = (0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0)
BUMPS = 6


def features(measurement: Measurement) -> dict[str, FloatArray]:
    """Groups of features by what they depend on, each of shape (k, n)."""
    where = coordinates(measurement)
    strain, rate, direction = where["strain"], where["strain_rate"], where["direction"]
    span = max(float(np.ptp(strain)), 1e-9)
    e = (strain - strain.min()) / span
    v = rate / max(float(np.std(rate)), 1e-12)
    over_strain = bumps(e)
    t = where["elapsed_s"] / max(float(where["elapsed_s"][-1]), 1e-9)
    late = np.log1p(where["since_reversal_s"])
    top = (where["largest_strain"] - strain.min()) / span
    slow = np.stack([lagged(e, tau, measurement.dt_s) - e for tau in MEMORIES_S])
    worked = np.stack([lagged(np.abs(v), tau, measurement.dt_s) for tau in (1.0, 10.0, 100.0)])
    groups = {
        "strain": over_strain,
        "direction of motion": over_strain * direction,
        "strain rate": np.stack([v, np.abs(v), v * v, v * e, np.abs(v) * e, np.tanh(v)]),
        "strain in the past seconds to minutes": np.vstack([slow, slow * e, np.maximum(slow, 0)]),
        "how much it moved lately": np.vstack([worked, worked * e]),
        "time since the last reversal": np.stack([late, late * direction, late * e, late * direction * e]),
        "largest strain so far": np.stack([top, top - e, (top - e) ** 2, (top - e) * e]),
        "elapsed time": np.vstack([bumps(t), bumps(t) * e]),
    }
    if "temperature_C" in where:
        warm = where["temperature_C"] - where["temperature_C"].mean()
        groups["temperature"] = np.stack([warm, warm * e])
    return groups


def bumps(x: FloatArray) -> FloatArray:
    """Triangular bumps over 0 <= x <= 1, shape (BUMPS, n)."""
    centres = np.linspace(0, 1, BUMPS)
    return np.maximum(1 - np.abs(x[None, :] - centres[:, None]) * (BUMPS - 1), 0)


def lagged(x: FloatArray, tau_s: float, dt_s: float) -> FloatArray:
    """First-order lag, at rest at the start."""
    keep = np.exp(-dt_s / tau_s)
    return lfilter([1 - keep], [1, -keep], x, zi=[keep * x[0]])[0]
