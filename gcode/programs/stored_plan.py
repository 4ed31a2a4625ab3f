"""``trajectory.json``, read again: what was planned and how it is executed."""

from __future__ import annotations

from pathlib import Path

from gcode.motion.statistics import MotionStatistics
from gcode.support.strict import ExtraIgnored, load
from gcode.trajectories.trajectory import TrajectorySpec

MOST_BYTES = 16 << 20


class StoredPlan(ExtraIgnored):
    """``trajectory.json``, as far as other rooms read it."""

    spec: TrajectorySpec
    statistics: MotionStatistics


def read_plan(path: str | Path) -> StoredPlan:
    """What `gcode generate` wrote beside the program.

    Raises
    ------
    UserError
        If it is missing or is something else.
    """
    return load(path, StoredPlan, "plan", MOST_BYTES)
