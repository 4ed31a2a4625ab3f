"""Limits applied: slow down locally where a path asks for too much speed or acceleration; keep the stroke exact.

Jerk is limited by a running mean over the motion's time. A mean over T turns an acceleration of at most a into a
jerk of at most 2 a / T and passes neither limit already kept; it costs a T^2 / 24 of stroke at a sharp reversal.
"""

from __future__ import annotations

import numpy as np

from gcode.motion.blocks import Blocks, Motion, drive
from gcode.motion.path import Path
from gcode.support.errors import UserError

MAX_STRETCH = 2.0  # a plan that the limits make longer than this is no longer the plan that was asked for
_FINE = 16  # points of the running mean per sample


def path_blocks(path: Path, v_max_mm_per_s: float) -> Blocks:
    """The path as blocks with the speed each asks for, at most `v_max_mm_per_s`."""
    length = np.diff(path.position_mm)
    still = length == 0
    seconds = np.where(path.duration_s > 0, path.duration_s, np.inf)
    asked = np.where(path.duration_s > 0, np.abs(length) / seconds, v_max_mm_per_s)
    keep = ~still | (path.duration_s > 0)
    dwell = np.where(still, path.duration_s, 0.0)
    return Blocks(length[keep], np.minimum(asked, v_max_mm_per_s)[keep], dwell[keep])


def drive_within(path: Path, v_max_mm_per_s: float, a_max_mm_per_s2: float, remedy: str = "raise them") -> Motion:
    """The fastest motion that is nowhere faster than the path asks for and keeps both limits.

    `remedy` is what to do where they are too low.

    Raises
    ------
    UserError
        If the limits would make the path more than twice as long as it was.
    """
    motion = drive(path_blocks(path, v_max_mm_per_s), a_max_mm_per_s2, start_mm=float(path.position_mm[0]))
    wanted = float(path.duration_s.sum())
    if motion.end_s > MAX_STRETCH * wanted + 10.0:
        raise UserError(
            f"limits: v max {v_max_mm_per_s:.4g} mm/s and a max {a_max_mm_per_s2:.4g} mm/s2 would stretch this "
            f"motion from {wanted:.4g} s to {motion.end_s:.4g} s; {remedy}, or ask for a slower or smaller motion"
        )
    return motion


def sampled_positions(
    motion: Motion, rate_hz: float, a_max_mm_per_s2: float, j_max_mm_per_s3: float | None
) -> np.ndarray:
    """Positions at `rate_hz` from start to end, with the jerk limited if a limit is given."""
    if j_max_mm_per_s3 is None:
        return motion.positions(rate_hz)
    fine_hz = rate_hz * _FINE
    width = int(np.ceil(2.0 * a_max_mm_per_s2 / j_max_mm_per_s3 * fine_hz)) + 1
    samples = int(np.ceil((motion.end_s + width / fine_hz) * rate_hz)) + 1
    times = (np.arange((samples - 1) * _FINE + width) - (width - 1)) / fine_hz
    total = np.concatenate(([0.0], np.cumsum(motion.position_at(times))))
    first = np.arange(samples) * _FINE
    return (total[first + width] - total[first]) / width
