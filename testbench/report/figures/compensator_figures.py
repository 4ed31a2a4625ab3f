"""Figures of a compensator, from the JSON of ``compensation score``: F, G and p over time, and scatter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from testbench.report import style
from testbench.report.figures.recording_figures import line

RAW, TRUTH, PREDICTION = style.ORANGE, style.INK, style.BLUE
# Mean r² over A and B after compensation that Aigner and Stoeckl report (arXiv:2306.12129), by knit.
PAPER = {"force": {"PES": 0.779, "Lycra": 0.829}, "displacement": {"PES": 0.667, "Lycra": 0.639}}
SYMBOLS = {"force": "F", "displacement": "d"}
BEFORE_AND_AFTER_CAPTION = (
    "r² before and after compensation (1 is perfect); whiskers: 95 % intervals over blocks of up to 60 s; "
    "dotted: the means that the paper reports for its two knits."
)
SCATTER_CAPTION = "Against the measurement: on the line, the sensor would be right."
TITLES = {"force": "Force (N)", "displacement": "Displacement (mm)"}


def over_time(row: Mapping[str, Any], target: str) -> style.Figure:
    """Truth, rescaled conductance and prediction: the whole recording, and below it its two ends.

    `row` is one entry of the score's ``recordings``, `target` is ``force`` or ``displacement``.
    """
    windows = [row["trace"], row["zooms"][0], row["zooms"][-1]]
    lines = [
        ("G_rescaled", RAW, "G: conductance, rescaled"),
        ("F", TRUTH, f"{SYMBOLS[target]}: measured"),
        ("p", PREDICTION, "p: compensated"),
    ]
    traces = []
    for panel, window in enumerate(windows):
        place: dict[str, Any] = {"xaxis": style.x_ref(panel), "showlegend": panel == 0}
        for key, colour, name in lines:
            time_s, values = np.asarray(window["time_s"]), np.asarray(window[key])
            traces.append(line(time_s, values, colour, name, panel, **place))
    upper, lower = [0.58, 1.0], [0.0, 0.42]
    left, right = (style.axis("Time (s)", domain=across) for across in ([0.0, 0.47], [0.53, 1.0]))
    axes = style.panel(0, style.axis(domain=[0, 1]), style.axis(TITLES[target], domain=upper))
    axes |= style.panel(1, left, style.axis(TITLES[target], domain=lower))
    axes |= style.panel(2, right, style.axis(domain=lower))
    return style.figure(traces, height=460, **axes)


def ends_in_words(row: Mapping[str, Any]) -> str:
    """The two ends that `over_time` shows: ``the first and the last minute``; shorter ones in seconds."""
    time_s = row["zooms"][0]["time_s"]
    length_s = time_s[-1] - time_s[0]
    return f"the first and the last {'minute' if round(length_s) == 60 else f'{length_s:.2g} s'}"


def scatter(row: Mapping[str, Any], target: str) -> style.Figure:
    """Against the truth: the raw signal on the left, the compensated one on the right; the line is 1:1."""
    truth = np.asarray(row["trace"]["F"])
    ends = np.array([truth.min(), truth.max()])
    panels = [
        ("G_rescaled", RAW, f"raw: r² {row['r2_before']:.3f}"),
        ("p", PREDICTION, f"after: r² {row['r2_after']:.3f}"),
    ]
    traces: list[dict[str, Any]] = []
    for column, (key, colour, _) in enumerate(panels):
        values = np.asarray(row["trace"][key])
        traces.append(style.dots(truth, values, colour, column, 3, opacity=0.5, hoverinfo="skip"))
        traces.append(style.curve(ends, ends, TRUTH, column, 1, hoverinfo="skip"))
    quantity, unit = style.parts_of_title(TITLES[target])
    titles = [
        (f"Measured {quantity.lower()} ({unit})", f"{name} ({unit})")
        for name in ("Conductance, rescaled", "Compensated")
    ]
    axes = style.side_by_side_axes(titles)
    notes = [
        style.note(f"<b>{title}</b>", 0.545 * column, 1.0, xanchor="left", yanchor="bottom")
        for column, (_, _, title) in enumerate(panels)
    ]
    return style.figure(traces, height=360, annotations=notes, **axes)


def before_and_after(rows: Sequence[Mapping[str, Any]], names: Sequence[str], target: str) -> style.Figure:
    """r² of every recording before and after, with the 95 % interval where it has one; the paper's means as lines."""
    places = np.arange(len(rows))
    after = np.array([row["r2_after"] for row in rows])
    span = np.array([row["r2_after_interval"] or (np.nan, np.nan) for row in rows])
    up, down = span[:, 1] - after, after - span[:, 0]
    whiskers = {"array": up, "arrayminus": down, "symmetric": False, "color": TRUTH}
    bar = partial(style.upright_bars, width=0.36, hover="%{y:.3f}", showlegend=True)
    bars = [
        bar(places - 0.2, [row["r2_before"] for row in rows], colour=RAW, name="raw conductance"),
        bar(places + 0.2, after, colour=PREDICTION, name="compensated", error_y=whiskers),
    ]
    ticks = {"tickvals": list(range(len(rows))), "ticktext": list(names), "showgrid": False}
    axes: dict[str, Any] = {
        "xaxis": style.axis("", **ticks),
        "yaxis": style.axis("r²", range=[float(np.nanmin([span.min(axis=1), after], initial=0.0)), 1.02]),
    }
    lines = [style.level(value, style.MUTED, dash="dot") for value in PAPER[target].values()]
    words = [_paper_words(knit, value, value == max(PAPER[target].values())) for knit, value in PAPER[target].items()]
    margin = {"l": 64, "r": 120, "t": 30, "b": 44}
    return style.figure(bars, height=300, bargap=0.3, shapes=lines, annotations=words, margin=margin, **axes)


def _paper_words(knit: str, value: float, upper: bool) -> dict[str, Any]:
    place = {"yref": "y", "xanchor": "left", "yanchor": "bottom" if upper else "top"}  # the two lie close together
    return style.note(f"paper, {knit} {value:.2f}", 1.01, value, font={"size": 11, "color": style.MUTED}, **place)
