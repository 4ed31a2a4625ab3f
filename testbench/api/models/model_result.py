"""What the results of `fit`, `diagnose` and `propose` have in common: each holds a model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from testbench.api.arguments import WithModel
from testbench.api.models.ladder import Ladder
from testbench.knit.model import KnitModel
from testbench.measurements.measurement import Measurement
from testbench.report.figures.comparison_figures import signals
from testbench.report.overlays import overlay_of
from testbench.report.writing.static import draw_on

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class ModelResult:
    """A result with a model in its ``file``."""

    @property
    def model(self: WithModel) -> KnitModel:
        """The model, refitted; ``result.model + effect`` is another one, with an effect put in."""
        return self.file.model

    @property
    def ladder(self: WithModel) -> Ladder:
        """The errors of this model, and of those that it was made from."""
        return Ladder(self.file)

    def save(self: WithModel, path: str | Path) -> None:
        """Write the model as ``model.json``."""
        self.file.save(path)


def plot_overlay(
    measurement: Measurement, models: Mapping[str, KnitModel], axes: Axes | Sequence[Axes] | None
) -> Any:
    """Measured and modelled over time, one panel a channel; returns the axes, shape (channels,)."""
    return draw_on(signals(overlay_of(measurement, models).within(measurement.counts)), axes)
