"""Figure of a proposed law: what the channel lacks over the law's own coordinate, and before and after, held out."""

from __future__ import annotations

from typing import Any

import numpy as np

from gcode.support.arrays import FloatArray
from testbench.comparing.model_errors import channel_name
from testbench.comparing.remounting import brought_together
from testbench.knit.model import KnitModel
from testbench.measurements.measurement import Measurement
from testbench.measurements.responses import UNIT_OF
from testbench.proposing.laws.formulas import in_words, plain
from testbench.proposing.laws_found import Proposed, Step, numbered
from testbench.report import style
from testbench.report.downsample import binned

POINTS, DOTS = 1500, 800
ROW_PX, LEGEND_PX = 270, 24  # the legend stands above the first row's title, which may be long
LEGEND = {"orientation": "h", "x": 1, "xanchor": "right", "y": 1.0, "yanchor": "bottom"}


def proposal(proposed: Proposed) -> style.Figure:
    """One row for each law (partial dependence), and one for each channel (held-out residual before and after)."""
    traces: list[dict[str, Any]] = []
    panels: list[tuple[str, str]] = []
    for step in proposed.steps:
        traces += _dependence(step, len(panels))
        channel = step.option.law.place.channel
        panels.append((part_of(step), f"What the {channel_name(channel)} lacks ({UNIT_OF[channel]})"))
    before, after = (_residuals(model, proposed.held) for model in (proposed.before.model, proposed.after.model))
    for channel, values in after.items():
        traces += _over_time(before[channel], values, proposed.held, len(panels))
        panels.append(("Time (s)", f"Measured − modelled, {channel_name(channel)} ({UNIT_OF[channel]})"))
    axes: dict[str, Any] = {}
    domains = style.rows(len(panels), 0.32 / len(panels), 1 - LEGEND_PX / (ROW_PX * len(panels)))
    for index, ((x_title, y_title), domain) in enumerate(zip(panels, domains, strict=True)):
        axes |= style.panel(index, style.axis(x_title), style.axis(y_title, domain=domain))
    titles = [
        f"<b>{numbered(proposed.name, index)}</b>: {in_words(step.option.law)}"
        for index, step in enumerate(proposed.steps)
    ]
    titles += [
        f"<b>held out</b>: {proposed.error_before[channel]:.3g} → {proposed.error_after[channel]:.3g} "
        f"{UNIT_OF[channel]}, noise floor {proposed.noise_floor[channel]:.2g}"
        for channel in after
    ]
    notes = [
        style.note(title, 0, top, xanchor="left", yanchor="bottom")
        for title, (_, top) in zip(titles, domains, strict=True)
    ]
    height = ROW_PX * len(panels) + 60
    return style.figure(traces, height=height, annotations=notes, legend=LEGEND, **axes)


def part_of(step: Step) -> str:
    """The changing part of a law as a formula, with its unit."""
    term = step.option.law.term
    return f"z = {plain(term.latex)}" + ("" if str(term.unit) == "1" else f", in {term.unit}")


def _dependence(step: Step, index: int) -> list[dict[str, Any]]:
    """Residual without the law over z, its mean in bins with two standard errors, and what is left with it."""
    z, without, left = step.dependence
    every = max(1, len(z) // DOTS)
    traces = [style.dots(z[::every], without[::every], style.FAINT, index, 3)]
    for name, values, colour in (("without the law", without, style.VERMILION), ("with it", left, style.BLUE)):
        x, mean, error = binned(z, values)
        look: dict[str, Any] = {"mode": "lines+markers", "line": {"width": 1.5, "color": colour}}
        look |= {"error_y": {"array": 2 * error, "color": colour}, "showlegend": index == 0, "name": name}
        traces.append(style.dots(x, mean, colour, index, 5, **look))
    return traces


def _residuals(model: KnitModel, held: Measurement) -> dict[str, FloatArray]:
    model, there = brought_together(model, held)
    found = there.residual(model)
    return {channel: values - values[held.counts].mean() for channel, values in found.items()}


def _over_time(before: FloatArray, after: FloatArray, held: Measurement, index: int) -> list[dict[str, Any]]:
    rows = np.flatnonzero(held.counts)
    rows = rows[:: max(1, len(rows) // POINTS)]
    both = ((before, style.VERMILION), (after, style.BLUE))
    return [style.curve(held.grid_s[rows], values[rows], colour, index, 1) for values, colour in both]
