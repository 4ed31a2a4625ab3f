"""Speed and acceleration of a sampled motion, as the paper's Table 1 counts them."""

from __future__ import annotations

from typing import Any

import numpy as np
from pydantic import BaseModel, ConfigDict


class MotionStatistics(BaseModel):
    """Finite-difference statistics of |v| and |a|; they depend on the sample rate, so it is part of them."""

    model_config = ConfigDict(frozen=True)

    sample_rate_hz: float
    duration_s: float
    x_min_mm: float
    x_max_mm: float
    v_max_mm_per_s: float
    v_mean_mm_per_s: float
    v_sd_mm_per_s: float
    a_max_mm_per_s2: float
    a_mean_mm_per_s2: float
    a_sd_mm_per_s2: float

    def lines(self) -> list[str]:
        """A small table for the screen."""
        low, high = (round(end, 3) + 0.0 for end in (self.x_min_mm, self.x_max_mm))
        rows = [
            f"{self.duration_s:.1f} s, position {low:.3f} to {high:.3f} mm",
            f"at {self.sample_rate_hz:g} Hz       max     mean       SD",
        ]
        for name, unit in (("v", "mm_per_s"), ("a", "mm_per_s2")):
            values = [getattr(self, f"{name}_{what}_{unit}") for what in ("max", "mean", "sd")]
            label = f"{name} ({unit.replace('_per_', '/')})"
            rows.append(f"{label:12s}" + "".join(f"{value:9.3f}" for value in values))
        return rows


def differences(position_mm: np.ndarray, rate_hz: float, order: int) -> np.ndarray:
    """Signed speed (mm/s), acceleration (mm/s2) or jerk (mm/s3) by `order` 1, 2 or 3; length n - order."""
    return np.diff(position_mm, order) * rate_hz**order


def motion_statistics(position_mm: np.ndarray, rate_hz: float) -> MotionStatistics:
    """Statistics of positions sampled uniformly at `rate_hz`."""
    position = np.asarray(position_mm, dtype=float)
    values: dict[str, Any] = {
        "sample_rate_hz": rate_hz,
        "duration_s": (len(position) - 1) / rate_hz,
        "x_min_mm": float(position.min()),
        "x_max_mm": float(position.max()),
    }
    for name, unit, order in (("v", "mm_per_s", 1), ("a", "mm_per_s2", 2)):
        size = np.abs(differences(position, rate_hz, order))
        size = size if size.size else np.zeros(1)
        values[f"{name}_max_{unit}"] = float(size.max())
        values[f"{name}_mean_{unit}"] = float(size.mean())
        values[f"{name}_sd_{unit}"] = float(size.std())
    return MotionStatistics(**values)
