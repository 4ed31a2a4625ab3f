"""Figure of a recording on its plan's clock: both motions, and what is between them."""

from __future__ import annotations

from gcode.support.arrays import FloatArray
from testbench.recordings.recording import gaps_in
from testbench.report import style
from testbench.report.downsample import window
from testbench.report.figures.recording_figures import line


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
    axes = style.stacked_axes(["Displacement / mm", "Difference / µm"], "Time of the plan / s")
    return style.figure(traces, height=440, **axes)
