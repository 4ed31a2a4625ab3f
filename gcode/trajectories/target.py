"""Target statistics of a noise piece, and the tuning of its shape to them, seed by seed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Protocol, Self, TypeVar

import numpy as np
from pydantic import Field

from gcode.motion.limits import drive_within
from gcode.motion.path import Frame, Path
from gcode.motion.statistics import MotionStatistics, motion_statistics
from gcode.support.errors import UserError
from gcode.trajectories.quantities import Positive, SpecModel

NAMES = ("v_mean_mm_per_s", "v_sd_mm_per_s", "a_mean_mm_per_s2", "a_sd_mm_per_s2")
TOO_FAR = 0.25  # a target missed by more than this cannot be met
_CLOSE = np.array([0.004, 0.02, 0.004, 0.02])
_TRIES = 8
# How the logarithms of the four statistics answer to log(cells_per_s), log(peak), log(min_speed) and pace_spread,
# measured as means over eight seeds between the presets paper-1 and fast; good enough to steer by.
_SENSITIVITY = np.array(
    [[0.89, -0.92, 0.06, 0.0], [1.02, -1.03, -0.03, 0.08], [1.88, -0.92, 0.06, 0.06], [1.37, -0.66, 0.3, 0.25]]
)
# The last two parameters act weakly; damping keeps them near what the spec says.
_DAMPING = np.diag([0.0, 0.0, 0.03, 0.02])


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


class Tunable(Protocol):
    """Motion whose shape can be tuned: a noise piece."""

    @property
    def cells_per_s(self) -> float: ...
    @property
    def level_at_end(self) -> float: ...
    @property
    def min_speed_mm_per_s(self) -> float: ...
    @property
    def pace_spread(self) -> float: ...

    def executed_path(self, frame: Frame) -> Path:
        """The path as executed within the frame's limits."""
        ...

    def model_copy(self, *, update: Mapping[str, Any]) -> Self:
        """The same motion with other parameters."""
        ...


Shape = TypeVar("Shape", bound=Tunable)


def trial(noise: Tunable, target: Target, frame: Frame) -> np.ndarray:
    """Deviations of the noise as executed within the frame's limits."""
    path = noise.executed_path(frame)
    motion = drive_within(path, frame.v_max_mm_per_s, frame.a_max_mm_per_s2)
    position = motion.position_at(np.arange(0.0, motion.end_s, 1.0 / target.rate_hz))
    return target.deviations(motion_statistics(position, target.rate_hz))


def tuned(noise: Shape, target: Target, frame: Frame) -> Shape:
    """The noise with its shape adjusted until this seed's executed motion has the target's statistics.

    Damped Gauss-Newton steps with a fixed sensitivity; the best shape seen is returned. The means are met within
    0.4 % for nearly every seed, the standard deviations as near as the seed allows.

    Raises
    ------
    UserError
        If a mean stays more than a quarter away from its target.
    """
    best, least = noise, np.inf
    step = -np.linalg.inv(_SENSITIVITY.T @ _SENSITIVITY + _DAMPING) @ _SENSITIVITY.T
    for _ in range(_TRIES):
        deviations = trial(noise, target, frame)
        worst = float((np.abs(deviations) / _CLOSE).max())
        if worst < least:
            best, least, reached = noise, worst, deviations
        if worst < 1.0:
            break
        noise = _stepped(noise, step @ np.clip(deviations, -0.5, 0.5), target)
    if np.abs(reached[[0, 2]]).max() > TOO_FAR:
        raise UserError(
            f"noise: the target cannot be reached within v max {frame.v_max_mm_per_s:g} mm/s, a max "
            f"{frame.a_max_mm_per_s2:g} mm/s2 and this strain range; the mean speed comes within {reached[0]:+.0%}, "
            f"the mean acceleration within {reached[2]:+.0%}"
        )
    return best


def _stepped(noise: Shape, change: np.ndarray, target: Target) -> Shape:
    factor = np.exp(np.clip(change, -0.7, 0.7))
    return noise.model_copy(
        update={
            "cells_per_s": float(noise.cells_per_s * factor[0]),
            "peak": float(np.clip(noise.level_at_end * factor[1], 0.1, 2.0)),
            "min_speed_mm_per_s": float(min(noise.min_speed_mm_per_s * factor[2], 0.9 * target.v_mean_mm_per_s)),
            "pace_spread": float(np.clip(noise.pace_spread + change[3], 0.0, 2.0)),
        }
    )
