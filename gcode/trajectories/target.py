"""Target statistics of a noise piece."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field

from gcode.motion.statistics import MotionStatistics
from gcode.trajectories.quantities import Positive, SpecModel

NAMES = ("v_mean_mm_per_s", "v_sd_mm_per_s", "a_mean_mm_per_s2", "a_sd_mm_per_s2")


class Target(SpecModel):
    """Means and standard deviations of |v| and |a|, by finite differences at `rate_hz`."""

    v_mean_mm_per_s: Positive
    v_sd_mm_per_s: Positive
    a_mean_mm_per_s2: Positive
    a_sd_mm_per_s2: Positive
    rate_hz: Annotated[float, Field(ge=1, le=1000)] = 20.0

    def deviations(self, statistics: MotionStatistics) -> np.ndarray:
        """Relative deviations, in the order of `NAMES`."""
        return np.array([getattr(statistics, name) / getattr(self, name) - 1.0 for name in NAMES])
