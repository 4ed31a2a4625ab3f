"""The figure of a recording under way: the last minute on the left, the whole recording on the right."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gcode.support.arrays import FloatArray
from testbench.report import style
from testbench.report.figures.recording_figures import line

LIVE_POINTS = 500
SIDES = (("Time, the last minute (s)", [0.0, 0.62]), ("Time, all (s)", [0.68, 1.0]))


@dataclass(frozen=True)
class LiveChannel:
    """One row of the live figure.

    Attributes
    ----------
    title, colour : str
    recent : (time_s, values)
        The last minute, in full.
    whole : (time_s, values)
        The outline of all so far.
    limit : float or None
        Of the absolute value, drawn as dashed lines; the recording stops beyond it.
    beside : LiveChannel or None
        Another signal of the same quantity, in the same row: what a compensator makes of the resistance.
    """

    title: str
    colour: str
    recent: tuple[FloatArray, FloatArray]
    whole: tuple[FloatArray, FloatArray]
    limit: float | None = None
    beside: LiveChannel | None = None


def live(channels: Sequence[LiveChannel]) -> style.Figure:
    """Rows of channels; a limit shows as dashed lines."""
    traces: list[dict[str, Any]] = []
    axes: dict[str, Any] = {}
    shapes: list[dict[str, Any]] = []
    for row, (channel, domain) in enumerate(zip(channels, style.rows(len(channels), 0.06), strict=True)):
        for side, (words, across) in enumerate(SIDES):
            index, place = 2 * row + side, style.x_ref(2 * row + side)
            for one in filter(None, (channel, channel.beside)):
                time_s, values = (one.recent, one.whole)[side]
                traces.append(line(time_s, values, one.colour, one.title, index, 2 * LIVE_POINTS, xaxis=place))
            x = style.axis(words if row == len(channels) - 1 else "", domain=across)
            axes |= style.panel(index, x, style.axis("" if side else channel.title, domain=domain))
            if channel.limit is not None and np.isfinite(channel.limit):
                shapes += [style.level(sign * channel.limit, style.VERMILION, index, 1.3) for sign in (1, -1)]
    return style.figure(traces, height=150 * max(len(channels), 1) + 80, shapes=shapes, **axes)
