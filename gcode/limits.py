"""Velocity and acceleration limits: slow down locally where a path asks for too much, keep the stroke exact."""

from __future__ import annotations

import numpy as np

from gcode.motion import Blocks, Motion, drive
from gcode.path import Path
from gcode.support.errors import UserError

MAX_STRETCH = 2.0  # a plan that the limits make longer than this is no longer the plan that was asked for


def path_blocks(path: Path, v_max_mm_per_s: float) -> Blocks:
    """The path as blocks with the speed each asks for, at most `v_max_mm_per_s`."""
    length = np.diff(path.position_mm)
    still = length == 0
    seconds = np.where(path.duration_s > 0, path.duration_s, np.inf)
    asked = np.where(path.duration_s > 0, np.abs(length) / seconds, v_max_mm_per_s)
    keep = ~still | (path.duration_s > 0)
    dwell = np.where(still, path.duration_s, 0.0)
    return Blocks(length[keep], np.minimum(asked, v_max_mm_per_s)[keep], dwell[keep])


def drive_within(path: Path, v_max_mm_per_s: float, a_max_mm_per_s2: float) -> Motion:
    """The fastest motion that is nowhere faster than the path asks for and keeps both limits.

    Raises
    ------
    UserError
        If the limits would make the path more than twice as long as it was.
    """
    motion = drive(path_blocks(path, v_max_mm_per_s), a_max_mm_per_s2, start_mm=float(path.position_mm[0]))
    wanted = float(path.duration_s.sum())
    if motion.end_s > MAX_STRETCH * wanted + 10.0:
        raise UserError(
            f"limits: v max {v_max_mm_per_s:g} mm/s and a max {a_max_mm_per_s2:g} mm/s2 would stretch this motion "
            f"from {wanted:.4g} s to {motion.end_s:.4g} s; raise them, or ask for a slower or smaller motion"
        )
    return motion
