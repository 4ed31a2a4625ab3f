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
        Drawn as a dashed line; the recording stops beyond it.
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
    """Rows of channels; a limit shows as a dashed line."""
    traces: list[dict[str, Any]] = []
    axes: dict[str, Any] = {}
    shapes: list[dict[str, Any]] = []
    for row, (channel, domain) in enumerate(zip(channels, style.rows(len(channels), 0.06), strict=True)):
        for side in (0, 1):
            index = 2 * row + side
            traces += [_trace(one, side, index) for one in (channel, channel.beside) if one is not None]
            axes |= _axes(index, side, domain, channel.title, row == len(channels) - 1)
            if channel.limit is not None and np.isfinite(channel.limit):
                shapes.append(style.level(channel.limit, style.VERMILION, index, 1.3))
    return style.figure(traces, height=150 * max(len(channels), 1) + 80, shapes=shapes, **axes)


def _trace(channel: LiveChannel, side: int, index: int) -> dict[str, Any]:
    time_s, values = (channel.recent, channel.whole)[side]
    return line(time_s, values, channel.colour, channel.title, index, LIVE_POINTS * 2, xaxis=style.x_ref(index))


def _axes(index: int, side: int, domain: list[float], title: str, last: bool) -> dict[str, Any]:
    across = [0.0, 0.62] if side == 0 else [0.68, 1.0]
    words = ("Time / s (the last minute)", "Time / s (all)")[side] if last else ""
    upright = style.axis(title if side == 0 else "", domain=domain)
    return style.panel(index, style.axis(words, domain=across), upright)
