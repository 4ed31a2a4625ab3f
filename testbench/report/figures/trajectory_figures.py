"""Figures of a planned motion: position, speed and acceleration with their limits. Arrays in, figures out."""

from __future__ import annotations

import numpy as np

from gcode.support.arrays import FloatArray
from testbench.report import style
from testbench.report.figures.recording_figures import line


def motion(
    time_s: FloatArray,
    position_mm: FloatArray,
    v_max_mm_per_s: float | None = None,
    a_max_mm_per_s2: float | None = None,
) -> style.Figure:
    """Position, speed and acceleration over time; the limits as dashed lines.

    Parameters
    ----------
    time_s, position_mm : ndarray, shape (n,)
        Uniformly sampled.
    v_max_mm_per_s, a_max_mm_per_s2 : float, optional
        Limits of the executed motion.
    """
    rate_hz = (len(time_s) - 1) / (time_s[-1] - time_s[0])
    speed = np.diff(position_mm) * rate_hz
    acceleration = np.diff(position_mm, 2) * rate_hz**2
    traces = [
        line(time_s, position_mm, style.PURPLE, "position", 0),
        line(time_s[1:], speed, style.BLUE, "speed", 1),
        line(time_s[1:-1], acceleration, style.GREEN, "acceleration", 2),
    ]
    shapes = [
        style.level(sign * limit, style.VERMILION, row) | {"xref": "paper"}
        for row, limit in ((1, v_max_mm_per_s), (2, a_max_mm_per_s2))
        if limit
        for sign in (1, -1)
    ]
    axes = style.stacked_axes(["Position / mm", "Speed / mm/s", "Acceleration / mm/s²"], "Time / s")
    return style.figure(traces, height=520, shapes=shapes, **axes)
