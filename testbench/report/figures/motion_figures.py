"""Figures of a motion: as it is planned, with its limits, and as it was recorded, on the plan's clock."""

from __future__ import annotations

import numpy as np

from gcode.support.arrays import FloatArray
from testbench.recordings.recording import gaps_in
from testbench.report import style
from testbench.report.downsample import window
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
    axes = style.stacked_axes(["Position (mm)", "Speed (mm/s)", "Acceleration (mm/s²)"], "Time (s)")
    return style.figure(traces, height=520, shapes=shapes, **axes)


def alignment(
    time_s: FloatArray,
    recorded_mm: FloatArray,
    planned_mm: FloatArray,
    start_s: float | None = None,
    end_s: float | None = None,
) -> style.Figure:
    """Planned and recorded displacement over the plan's time, and their difference; zoom linked.

    Parameters
    ----------
    time_s : ndarray, shape (n,)
        On the plan's clock.
    recorded_mm, planned_mm : ndarray, shape (n,)
    start_s, end_s : float, optional
        Draw this stretch only.
    """
    rows, gaps = window(time_s, start_s, end_s), gaps_in(time_s)
    difference_um = 1e3 * (recorded_mm - planned_mm)
    traces = [
        line(time_s[rows], planned_mm[rows], style.ORANGE, "planned", 0, gaps=gaps, width=3, showlegend=True),
        line(time_s[rows], recorded_mm[rows], style.INK, "recorded", 0, gaps=gaps, showlegend=True),
        line(time_s[rows], difference_um[rows], style.BLUE, "recorded minus planned", 1, gaps=gaps),
    ]
    axes = style.stacked_axes(["Displacement (mm)", "Difference (µm)"], "Time of the plan (s)")
    return style.figure(traces, height=440, **axes)
