"""Figures of a recording: what was moved, what was felt, what was read. Data in, Plotly figures out; no files."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gcode.support.arrays import FloatArray
from gcode.support.errors import UserError
from gcode.support.figures import POINTS, histogram_range, outline, rows_to_draw
from testbench.comparing.numbers import span
from testbench.recordings.channels import DISPLACEMENT, FORCE, RESISTANCE, TEMPERATURE
from testbench.recordings.recording import Recording
from testbench.report import style
from testbench.report.downsample import window
from testbench.report.words import duration_in_words

Channel = tuple[str, FloatArray, str]  # axis title, values, colour

LOOPS, LOOP_S, LOOP_SAMPLES, LOOP_POINTS = 6, 30.0, 30, 300
SWING = 0.2  # of the range: a smaller one is no loop
COUNTED = {3: "three", 6: "six"}
WHOLE = "the whole recording"
BINS = 60
SPEED_RATE_HZ = 20.0
THUMBNAIL_S, THUMBNAIL_SAMPLES = 60.0, 120


def conductance_scale(conductance_S: FloatArray) -> tuple[float, str]:
    """Factor and unit that give readable numbers: S, mS, µS or nS."""
    middle_S = float(np.median(np.abs(conductance_S)))
    for factor, unit in ((1.0, "S"), (1e3, "mS"), (1e6, "µS")):
        if middle_S * factor >= 0.5:
            return factor, unit
    return 1e9, "nS"


def channels_of(recording: Recording, resistance: bool = False) -> list[Channel]:
    """Strain, force, conductance (or resistance) and temperature, as far as they were recorded."""
    found: list[Channel] = []
    if recording.has(DISPLACEMENT):
        found.append(("Strain (%)", 100 * recording.strain, style.STRAIN))
    if recording.has(FORCE):
        found.append(("Force (N)", recording[FORCE], style.FORCE))
    if recording.has(RESISTANCE) and resistance:
        found.append(("Resistance (kΩ)", 1e-3 * recording[RESISTANCE], style.CONDUCTANCE))
    elif recording.has(RESISTANCE):
        factor, unit = conductance_scale(recording.conductance_S)
        found.append((f"Conductance ({unit})", factor * recording.conductance_S, style.CONDUCTANCE))
    if recording.has(TEMPERATURE):
        found.append(("Temperature (°C)", recording[TEMPERATURE], style.ORANGE))
    return found


def time_series(
    recording: Recording, start_s: float | None = None, end_s: float | None = None, resistance: bool = False
) -> style.Figure:
    """Every channel over time, one row each, zoom linked; with the `resistance` in kΩ instead of the conductance.

    From `start_s` to `end_s` only, at full detail for it, where they are given.
    """
    rows = window(recording.time_s, start_s, end_s)
    time_s = recording.time_s[rows]
    channels = channels_of(recording, resistance)
    traces = [
        line(time_s, values[rows], colour, style.parts_of_title(title)[0], row, gaps=recording.gaps)
        for row, (title, values, colour) in enumerate(channels)
    ]
    axes = style.stacked_axes([title for title, _, _ in channels], "Time (s)")
    return style.figure(traces, height=150 * len(channels) + 90, **axes)


def line(
    time_s: FloatArray,
    values: FloatArray,
    colour: str,
    name: str,
    row: int = 0,
    points: int = POINTS,
    gaps: Sequence[tuple[float, float]] = (),
    width: float = 1.2,
    **more: Any,
) -> dict[str, Any]:
    """A line over time in row `row` of a stacked figure, downsampled to `points` so that peaks stay.

    It is broken at each of the `gaps`, (last time before, first time after).
    """
    x, y = outline(time_s, values, points // 2, gaps)
    look = {"name": name, "yaxis": style.y_ref(row), "hovertemplate": "%{y:.4g} at %{x:.1f} s", **more}
    return style.curve(x, y, colour, width=width, **look)


def hysteresis_loops(recording: Recording, resistance: bool = False) -> style.Figure | None:
    """Force and log-conductance over strain, and log-conductance over force: a few stretches, dark to light.

    With `resistance` in kΩ instead of the conductance.

    Whole stretches of motion are drawn, not a cloud of samples, so that the loops are seen as loops.
    None when neither force nor resistance was recorded.
    """
    panels = _loop_panels(recording, resistance)
    if not panels:
        return None
    windows = stretches(recording.time_s, _motion(recording))
    colours, several = shades(len(windows)), len(windows) > 1
    points = LOOPS * LOOP_POINTS // len(windows)
    traces = []
    for column, (_, _, x, y) in enumerate(panels):
        shown: dict[str, Any] = {"showlegend": several and column == 0, "hovertemplate": "%{x:.4g}, %{y:.4g}"}
        for rows, colour in zip(windows, colours, strict=True):
            name = duration_in_words(float(recording.time_s[rows.start] - recording.time_s[0]))
            every = max(1, (rows.stop - rows.start) // points)
            ends = [rows.start + end(values[rows]) for values in (x, y) for end in (np.argmin, np.argmax)]
            kept = np.union1d(np.arange(rows.start, rows.stop, every), ends)
            few = unbroken(kept, recording.time_s, recording.gaps)
            traces.append(style.curve(at_rows(x, few), at_rows(y, few), colour, column, name=name, **shown))
    axes = style.side_by_side_axes([(x_title, y_title) for x_title, y_title, _, _ in panels])
    return style.figure(traces, height=400, **axes)


def stretches(time_s: FloatArray, motion: FloatArray, count: int = LOOPS) -> list[slice]:
    """Rows of a few stretches of motion, evenly spread from the first sample to the last; see `_stretch_s`."""
    length_s = _stretch_s(time_s, motion)
    if _takes_all(time_s, count * length_s):
        return [slice(0, len(time_s))]
    begins = np.linspace(time_s[0], time_s[-1] - length_s, count)
    return [window(time_s, float(begin), float(begin) + length_s) for begin in begins]


def _stretch_s(time_s: FloatArray, motion: FloatArray) -> float:
    """Half a minute; longer where thirty samples take longer, or the way there and back, without which no loop is."""
    from testbench.knit.kernels import turns

    turned = np.unique(turns(np.array(motion, float), SWING * float(np.ptp(motion)))[0].astype(int))
    ways_s = np.diff(time_s[turned]) if len(turned) > 1 else time_s[-1:] - time_s[0]
    return max(LOOP_S, LOOP_SAMPLES * float(time_s[-1] - time_s[0]) / len(time_s), 2 * float(np.median(ways_s)))


def _takes_all(time_s: FloatArray, length_s: float) -> bool:
    return bool(time_s[-1] - time_s[0] <= length_s)


def stretches_in_words(time_s: FloatArray, motion: FloatArray, count: int = LOOPS) -> str:
    """What `stretches` shows: ``six half minutes``, ``six stretches of 5.0 min``, or ``the whole recording``."""
    length_s = _stretch_s(time_s, motion)
    if _takes_all(time_s, count * length_s):
        return WHOLE
    long = "half minutes" if length_s == LOOP_S else f"stretches of {duration_in_words(length_s)}"
    return f"{COUNTED[count]} {long}"


def loops_in_words(recording: Recording) -> str:
    """What the `hysteresis_loops` of a recording show, and how their colours tell when."""
    shown = stretches_in_words(recording.time_s, _motion(recording))
    return shown if shown == WHOLE else f"{shown}, the first dark, the last light"


def loops_caption(recording: Recording) -> str:
    """What stands under the `hysteresis_loops` of a recording."""
    shown = loops_in_words(recording)
    drift = "" if shown == WHOLE else ": a shift along the colours is drift"
    return f"Loops of {shown}{drift}."


def _motion(recording: Recording) -> FloatArray:
    """What the loops are drawn over: the displacement, or where none was recorded, the force."""
    return recording[DISPLACEMENT if recording.has(DISPLACEMENT) else FORCE]


def unbroken(rows: NDArray[np.intp], time_s: FloatArray, gaps: Sequence[tuple[float, float]]) -> NDArray[np.intp]:
    """The rows of a stretch, with -1 between two of them where nothing was recorded; see `at_rows`."""
    cuts = np.searchsorted(time_s[rows], [end_s for _, end_s in gaps])
    return np.insert(rows, cuts[(cuts > 0) & (cuts < len(rows))], -1)


def at_rows(values: FloatArray, rows: NDArray[np.intp]) -> FloatArray:
    """Values at `rows`, NaN (a gap in the line) at -1."""
    return np.where(rows < 0, np.nan, values[rows])


def shades(count: int) -> list[str]:
    """Colours from dark (first) to light (last); see `testbench.report.style.SEQUENCE`."""
    if count == 1:
        return [style.BLUE]
    places = np.linspace(0, len(style.SEQUENCE) - 1, count).round().astype(int)
    return [style.SEQUENCE[place] for place in places]


def _loop_panels(recording: Recording, resistance: bool) -> list[tuple[str, str, FloatArray, FloatArray]]:
    strain = 100 * recording.strain if recording.has(DISPLACEMENT) else None
    panels = []
    if recording.has(FORCE) and strain is not None:
        panels.append(("Strain (%)", "Force (N)", strain, recording[FORCE]))
    if recording.has(RESISTANCE):
        title, values = "ln (G / S)", np.log(recording.conductance_S)
        if resistance:
            title, values = "Resistance (kΩ)", 1e-3 * recording[RESISTANCE]
        if strain is not None:
            panels.append(("Strain (%)", title, strain, values))
        if recording.has(FORCE):
            panels.append(("Force (N)", title, recording[FORCE], values))
    return panels


def distributions(recording: Recording, resistance: bool = False) -> style.Figure | None:
    """How often each strain, speed, force and conductance (or resistance) occurred, in per cent of the time.

    None where a recording of hardly a sample has no times to count.
    """
    rate_hz = _speed_rate_hz(recording)
    try:
        even = recording.resampled(rate_hz)
    except UserError:
        return None
    panels = channels_of(even, resistance)[:3]
    if recording.has(DISPLACEMENT):
        panels.insert(1, ("Speed (mm/s)", np.gradient(even[DISPLACEMENT], 1 / rate_hz), style.MUTED))
    traces = []
    for column, (_, values, colour) in enumerate(panels):
        counts, edges = np.histogram(values, bins=BINS, range=histogram_range(values))
        centres, width, share = (edges[:-1] + edges[1:]) / 2, float(edges[1] - edges[0]), 100 * counts / counts.sum()
        hover = "%{y:.2f} % of the time near %{x:.3g}<extra></extra>"
        place: dict[str, Any] = style.place(column)
        traces.append(style.upright_bars(centres, share, width, colour, hover, **place))
        traces[-1]["marker"]["line"] = {"width": 0}
    titles = [(title, "Time (%)" if column == 0 else "") for column, (title, _, _) in enumerate(panels)]
    return style.figure(traces, height=240, bargap=0, **style.side_by_side_axes(titles, gap=0.06))


def distributions_caption(recording: Recording) -> str:
    """What stands under the `distributions` of a recording."""
    speed = f"; the speed is taken at {_speed_rate_hz(recording):.3g} Hz" if recording.has(DISPLACEMENT) else ""
    return f"How often each value occurred{speed}."


def _speed_rate_hz(recording: Recording) -> float:
    """The rate at which the speed is taken: 20 Hz, or the recording's own where its samples are rarer."""
    return min(SPEED_RATE_HZ, recording.mean_rate_hz)


def summary(recording: Recording, resistance: bool = False) -> list[tuple[str, str]]:
    """What a person asks first of a recording: pairs of name and value, in words."""
    facts = [
        ("Duration", duration_in_words(recording.duration_s)),
        ("Samples", f"{len(recording):,}".replace(",", " ") + f" at {recording.mean_rate_hz:.3g} Hz"),
    ]
    if recording.has(DISPLACEMENT):
        facts.append(("Gauge length", f"{recording.gauge_length_mm:g} mm"))
    for title, values, _ in channels_of(recording, resistance):
        name, unit = style.parts_of_title(title)
        facts.append((name, span(float(values.min()), float(values.max()), unit)))
    return facts


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
