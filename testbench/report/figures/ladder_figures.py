"""Figures of the way from the first model to the last: the error falling, step by step, to the noise floor."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from testbench.comparing.numbers import over_noise, plain
from testbench.comparing.words import spoken
from testbench.report import style
from testbench.report.downsample import window
from testbench.report.figures.comparison_figures import CHANNEL_TITLES, Overlay, signal_traces
from testbench.report.words import PANEL_UNITS, with_unit

NAMED_STEPS = 3
BESIDE, NAMED = 4, 9  # steps whose names have room where panels stand side by side, and one above the other
HEADROOM = 1.3  # of the axis over the highest bar: for its number, and above it the name of the noise floor
LADDER_CAPTION = (
    "Error on the held-out samples, which no fit has seen, after each step; dashed: the noise floor, the least that "
    "any model can reach."
)
GLANCE_CAPTION = (
    "Left: the held-out samples where the first model is worst. "
    "Right: the held-out error after each step, and the noise floor."
)
LINE = 14  # characters of a name on one line, where there is room


@dataclass(frozen=True)
class Step:
    """One step of the ladder.

    Attributes
    ----------
    label : str
        What was done: ``baseline``, ``+ stress_relaxation``.
    errors : mapping of channel to float
        Held-out RMS in N and ln S.
    noise_floor : mapping of channel to float
    """

    label: str
    errors: Mapping[str, float]
    noise_floor: Mapping[str, float]

    @property
    def over_noise(self) -> dict[str, float]:
        """By channel: how many times the noise floor the error is."""
        return {channel: over_noise(error, self.noise_floor[channel]) for channel, error in self.errors.items()}


def ladder(steps: Sequence[Step], current: int | None = None) -> style.Figure:
    """Held-out error after each step, one panel a channel, with the noise floor below all.

    `current` is the step that is in use; later ones are drawn faint.
    """
    channels = list(steps[0].errors)
    current = len(steps) - 1 if current is None else current
    traces = [trace for column, channel in enumerate(channels) for trace in _rungs(steps, channel, column, current)]
    panels = [("", f"Held-out error ({PANEL_UNITS[channel]})") for channel in channels]
    axes = style.side_by_side_axes(panels, gap=0.12)
    height = 320
    if len(steps) > BESIDE:
        height *= len(channels)
        _stack(axes, len(channels))
    for column, channel in enumerate(channels):
        _label_steps(axes, column, steps, room=len(steps) <= NAMED)
        axes[style.axis_key("yaxis", column)]["range"] = _from_zero(steps, channel)
    floors, notes = _floors(channels, steps, range(len(channels)))
    margin = {"l": 64, "r": 20, "t": 26, "b": 60}
    return style.figure(traces, height=height, margin=margin, shapes=floors, annotations=notes, **axes)


def _from_zero(steps: Sequence[Step], channel: str) -> list[float]:
    return [0, HEADROOM * max(step.errors[channel] for step in steps)]


def _stack(axes: dict[str, Any], count: int) -> None:
    """Put panels one above the other: the names of many steps need the whole width."""
    for index, domain in enumerate(style.rows(count, 0.2)):
        axes[style.axis_key("xaxis", index)]["domain"] = [0, 1]
        axes[style.axis_key("yaxis", index)]["domain"] = domain


def _rungs(steps: Sequence[Step], channel: str, column: int, current: int) -> list[dict[str, Any]]:
    errors = [step.errors[channel] for step in steps]
    colours = [style.ORANGE] * current + [style.VERMILION] + [style.RULE] * (len(steps) - current - 1)
    more: dict[str, Any] = {
        "text": [plain(error) for error in errors],
        "textposition": "outside",
        "cliponaxis": False,
        "hovertext": [step.label for step in steps],
        **style.place(column),
    }
    hover = "%{hovertext}: %{y:.4g}<extra></extra>"
    return [style.upright_bars(np.arange(len(steps)), errors, 0.62, colours, hover, **more)]


def _label_steps(axes: dict[str, Any], column: int, steps: Sequence[Step], room: bool = True) -> None:
    """Names under the bars; numbers where there is no `room` for names (the bar tells its name when pointed at)."""
    axes[style.axis_key("xaxis", column)] |= {
        "tickvals": list(range(len(steps))),
        "ticktext": step_names([step.label for step in steps], room),
        "showgrid": False,
        "range": [-0.6, len(steps) - 0.4],
    }


def step_names(labels: Sequence[str], room: bool = True) -> list[str]:
    """Names of steps in spoken words, long ones on several lines; their numbers where names have no `room`."""
    if not room:
        return [str(number) for number in range(len(labels))]
    width = LINE if len(labels) <= BESIDE else 1  # many: a line a word
    words = [spoken(label).replace("+ ", "+\N{NO-BREAK SPACE}") for label in labels]  # a sign stays with its word
    return ["<br>".join(textwrap.wrap(one, width, break_long_words=False)) for one in words]


def _floors(
    channels: Sequence[str], steps: Sequence[Step], places: Iterable[int]
) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """The noise floor of each channel in its panel, and its number in words."""
    lines, words = [], []
    for channel, index in zip(channels, places, strict=True):
        floor = steps[-1].noise_floor.get(channel, 0.0)
        lines.append(style.level(floor, style.INK, index, 1.4))
        look: dict[str, Any] = {"font": {"size": 11, "color": style.INK}, "xanchor": "right", "yanchor": "top"}
        where = {"xref": f"{style.x_ref(index)} domain", "yref": f"{style.y_ref(index)} domain"}
        words.append(style.note(f"- - -  noise floor {with_unit(floor, channel, 2)}", 1, 1, **look, **where))
    return lines, words


def at_a_glance(both: Overlay, steps: Sequence[Step], span_s: tuple[float, float]) -> style.Figure:
    """The picture that says it all: measured against modelled on the left, the error falling on the right.

    Of `both`, which holds the first and the last model, the stretch `span_s` (start, end) is shown.
    """
    channels = list(both.measured)
    rows = window(both.time_s, *span_s)
    traces: list[dict[str, Any]] = []
    axes: dict[str, Any] = {}
    gap = 0.15  # room for names of steps on two lines
    for row, (channel, domain) in enumerate(zip(channels, style.rows(len(channels), gap), strict=True)):
        left, right = 2 * row, 2 * row + 1
        traces += signal_traces(both, channel, rows, left, xaxis=style.x_ref(left))
        traces += _rungs(steps, channel, right, len(steps) - 1)
        words, follows = "Time (s)" if row == len(channels) - 1 else "", "x" if row else None
        time = style.axis(words, domain=[0, 0.6], matches=follows, range=list(span_s))
        error = style.axis(PANEL_UNITS[channel], domain=domain, range=_from_zero(steps, channel))
        axes |= style.panel(left, time, style.axis(CHANNEL_TITLES[channel], domain=domain))
        axes |= style.panel(right, style.axis(domain=[0.68, 1]), error)
        _label_steps(axes, right, steps, room=len(steps) <= NAMED_STEPS)
    shapes, notes = _floors(channels, steps, range(1, 2 * len(channels), 2))
    notes.append(style.note("<b>Held-out error</b>", 0.68, 1.0, xanchor="left", yanchor="bottom"))
    return style.figure(traces, height=240 * len(channels) + 60, shapes=shapes, annotations=notes, **axes)
