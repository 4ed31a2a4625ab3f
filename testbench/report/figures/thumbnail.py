"""A recording as a small picture for lists, an SVG without axes."""

from __future__ import annotations

import numpy as np

from gcode.support.arrays import FloatArray
from testbench.recordings.channels import RESISTANCE
from testbench.recordings.recording import Recording
from testbench.report import style
from testbench.report.downsample import rows_to_draw, window
from testbench.report.figures.recording_figures import channels_of

THUMBNAIL_S, THUMBNAIL_SAMPLES = 60.0, 120


def thumbnail(recording: Recording) -> str:
    """A small SVG for lists: a minute of strain (faint) and force on the left, the loops on the right."""
    channels, width, height = channels_of(recording), 280, 66  # size in pixels
    middle_s = 0.5 * (recording.time_s[0] + recording.time_s[-1])
    shown_s = max(THUMBNAIL_S, THUMBNAIL_SAMPLES / recording.mean_rate_hz)
    rows = window(recording.time_s, middle_s - shown_s / 2, middle_s + shown_s / 2)
    if rows.stop - rows.start < 2:  # taken so unevenly that the middle is empty
        rows = slice(0, len(recording))
    time_s, split = recording.time_s[rows], width - 84
    _, first, _ = channels[0]
    paths = _path(time_s, first, rows, style.FAINT, split, height)
    if len(channels) > 1:
        _, values, colour = channels[1]
        paths += _path(time_s, values, rows, colour, split, height)
        _, values, colour = channels[-1] if recording.has(RESISTANCE) else channels[1]
        few = slice(None, None, max(1, len(recording) // 500))
        paths += _dots(first[few], values[few], colour, split + 14, width, height)
    return (
        f'<svg viewBox="0 0 {width} {height}" width="{width}" height="{height}" '
        f'xmlns="http://www.w3.org/2000/svg" aria-hidden="true">{paths}</svg>'
    )


def _scaled(values: FloatArray, low: float, high: float) -> FloatArray:
    return low + (values - values.min()) / (float(np.ptp(values)) or 1.0) * (high - low)


def _path(time_s: FloatArray, values: FloatArray, part: slice, colour: str, right: float, height: int) -> str:
    """A part of a channel, as high as it is in the whole: the noise of a hold is a line."""
    rows = rows_to_draw(values[part], int(2 * right))
    x, y = _scaled(time_s[rows], 0, right), _scaled(values, height - 3, 3)[part][rows]
    points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))
    return f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="1.3"/>'


def _dots(across: FloatArray, values: FloatArray, colour: str, left: float, right: float, height: int) -> str:
    x, y = _scaled(across, left, right - 2), _scaled(values, height - 3, 3)
    points = "".join(f"M{a:.1f} {b:.1f}h.1" for a, b in zip(x, y, strict=True))
    return f'<path d="{points}" stroke="{colour}" stroke-width="1.6" stroke-linecap="round" opacity=".6"/>'
