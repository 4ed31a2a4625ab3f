"""Measured and modelled signals on Matplotlib axes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from testbench.knit.model import KnitModel
from testbench.measurements.measurement import Measurement
from testbench.report.figures.comparison_figures import signals
from testbench.report.overlays import overlay_of
from testbench.report.writing.static import draw_on

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def plot_overlay(
    measurement: Measurement, models: Mapping[str, KnitModel], axes: Axes | Sequence[Axes] | None
) -> Any:
    """Measured and modelled over time, one panel a channel; returns the axes, shape (channels,)."""
    return draw_on(signals(overlay_of(measurement, models).within(measurement.counts)), axes)
