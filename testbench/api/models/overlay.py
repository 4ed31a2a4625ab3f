"""Measured and modelled signals on Matplotlib axes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gcode.support.figures import outline, panels
from testbench.comparing.model_errors import channel_name
from testbench.knit.model import KnitModel
from testbench.measurements.measurement import Measurement
from testbench.measurements.responses import UNIT_OF
from testbench.recordings.recording import gaps_in
from testbench.report import style
from testbench.report.figures.comparison_figures import CHANNEL_TITLES, model_colour

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def plot_overlay(
    measurement: Measurement, models: Mapping[str, KnitModel], axes: Axes | Sequence[Axes] | None
) -> Any:
    """Measured and modelled over time, one panel a channel; returns the axes, shape (channels,)."""
    modelled = {label: measurement.modelled(model) for label, model in models.items()}
    on = panels(axes, len(measurement.channels))
    rows = measurement.counts
    time_s = measurement.grid_s[rows]
    gaps = gaps_in(time_s)
    for axis, channel in zip(on, measurement.channels, strict=True):
        measured = outline(time_s, measurement.measured[channel][rows], 2000, gaps)
        axis.plot(*measured, color=style.MEASURED, linewidth=1.6, label="measured")
        for index, (label, signals) in enumerate(modelled.items()):
            colour = model_colour(index, len(modelled))
            drawn = outline(time_s, signals[channel][rows], 2000, gaps)
            axis.plot(*drawn, color=colour, linewidth=0.9, label=label)
        axis.set_ylabel(in_a_sentence(CHANNEL_TITLES[channel]))
        axis.margins(x=0)
    on[0].legend(frameon=False, ncols=3)
    on[-1].set_xlabel("time / s")
    return np.array(on)


def in_a_sentence(title: str) -> str:
    """A title of the reports as a label of an axis, which begins with a small letter."""
    return title[:1].lower() + title[1:]


def residual_label(channel: str) -> str:
    """Label of a vertical axis, on two lines: one would be longer than a panel is high."""
    return f"{channel_name(channel)}\nresidual / {UNIT_OF[channel]}"
