"""A picture of a trajectory: position, speed and acceleration over time, their distributions, executed on planned."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from gcode.motion.statistics import differences
from gcode.programs.make import Made
from gcode.support import files
from gcode.support.colours import BLUE, GREY, VERMILION
from gcode.support.figures import histogram_range

_CLOSE_UP_S = 12.0


def write_plot(made: Made, path: str | Path) -> Path:
    """Write the picture as PNG, atomically; returns its path."""
    from matplotlib.figure import Figure  # without pyplot, which would look for a display

    figure = Figure(figsize=(12, 9), layout="constrained")
    grid = figure.add_gridspec(4, 2, width_ratios=(4, 1))
    rate, limits = made.spec.rate_hz, made.spec.limits
    played = made.executed.position_mm
    time_s = np.arange(len(played)) / rate
    rows = (
        ("position (mm)", time_s, played, None),
        ("speed (mm/s)", time_s[1:], differences(played, rate, 1), limits.v_max_mm_per_s),
        ("acceleration (mm/s²)", time_s[1:-1], differences(played, rate, 2), limits.a_max_mm_per_s2),
    )
    first = None
    for row, (label, times, values, limit) in enumerate(rows):
        axes = figure.add_subplot(grid[row, 0], sharex=first)
        first = first or axes
        _over_time(axes, label, times, values, limit)
        _distribution(figure.add_subplot(grid[row, 1], sharey=axes), values, limit)
    first.set_title(_title(made), loc="left", fontsize=11)  # type: ignore[union-attr]
    _close_up(figure.add_subplot(grid[3, 0]), made, played)
    _deviation(figure.add_subplot(grid[3, 1]), made, played)
    path = Path(path)
    with files.atomic_path(path) as temporary:
        figure.savefig(temporary, dpi=110, format="png")
    return path


def _title(made: Made) -> str:
    found = made.statistics
    return (
        f"{made.spec.name}, seed {made.seed}, gauge length {made.gauge_length_mm:g} mm, as executed: "
        f"|v| {found.v_mean_mm_per_s:.3f} ± {found.v_sd_mm_per_s:.3f} mm/s, "
        f"|a| {found.a_mean_mm_per_s2:.3f} ± {found.a_sd_mm_per_s2:.3f} mm/s² at {found.sample_rate_hz:g} Hz"
    )


def _over_time(axes: Any, label: str, time_s: np.ndarray, values: np.ndarray, limit: float | None) -> None:
    axes.plot(time_s, values, color=BLUE, linewidth=0.5)
    axes.set_ylabel(label)
    axes.set_xlabel("time (s)")
    axes.margins(x=0)
    _limit_lines(axes, limit)


def _limit_lines(axes: Any, limit: float | None) -> None:
    if limit is not None:
        for sign in (-1, 1):
            axes.axhline(sign * limit, color=VERMILION, linewidth=1, linestyle="--")


def _distribution(axes: Any, values: np.ndarray, limit: float | None) -> None:
    shown = histogram_range(values)
    axes.hist(values, bins=60, range=shown, orientation="horizontal", color=BLUE, density=True, log=limit is not None)
    axes.tick_params(labelleft=False)
    axes.set_xlabel("density")
    _limit_lines(axes, limit)


def _close_up(axes: Any, made: Made, played: np.ndarray) -> None:
    """Executed on planned, a few seconds around the sharpest reversal."""
    rate, planned = made.spec.rate_hz, made.trajectory.position_mm
    inside = np.abs(differences(planned, rate, 2))
    middle = int(inside.argmax()) if len(inside) else 0
    half = int(_CLOSE_UP_S * rate / 2)
    part = slice(max(middle - half, 0), min(middle + half, len(planned), len(played)))
    time_s = np.arange(len(planned)) / rate
    axes.plot(time_s[part], planned[part], "o", color=GREY, markersize=3, label="planned")
    axes.plot(time_s[part], played[part], color=VERMILION, linewidth=1.2, label="executed")
    axes.set_xlabel("time (s), around the sharpest reversal")
    axes.set_ylabel("position (mm)")
    axes.margins(x=0)
    axes.legend(frameon=False, ncols=2, loc="best")


def _deviation(axes: Any, made: Made, played: np.ndarray) -> None:
    size = min(len(played), len(made.trajectory.position_mm))
    off_um = 1000.0 * (played[:size] - made.trajectory.position_mm[:size])
    axes.hist(off_um, bins=50, range=histogram_range(off_um), color=BLUE, log=True)
    axes.set_xlabel("executed minus planned (µm)")
    axes.set_ylabel("samples")
