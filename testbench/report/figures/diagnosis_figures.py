"""Figures of a diagnosis: candidates with their evidence, what the residual depends on, prediction over residual."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from gcode.support.arrays import FloatArray
from testbench.comparing.words import percent_left, spoken
from testbench.diagnosis.verdict import with_probability
from testbench.recordings.recording import gaps_in
from testbench.report import style
from testbench.report.downsample import binned, window
from testbench.report.figures.comparison_figures import RESIDUAL_TITLES, RESIDUALS
from testbench.report.figures.recording_figures import line
from testbench.report.words import PANEL_UNITS

SHOWN = 8
CANDIDATES_CAPTION = (
    "What a refit with each effect takes off the error that the model leaves without it, on samples that no fit has "
    "seen: the mean of the channels, with the 95 % interval over blocks of up to 60 s. In brackets: how probable it "
    "is that this effect is what is missing most. What was not refitted would hardly lower the error."
)


def removed_percent(gain: float) -> float:
    """Share of the held-out RMS error that a gain (ln of the ratio of squared errors) takes away, in per cent."""
    return 100 - percent_left(gain)


def candidates(diagnosis: Mapping[str, Any]) -> style.Figure:
    """What a refit with each effect takes off the error on samples that no fit has seen, best first.

    The bar is measured, with its 95 % interval over blocks of up to 60 s; an effect that was not refitted has none.
    Left of 0, an effect adds to the error. `diagnosis` is the JSON of ``testbench diagnose``.
    """
    ranking = diagnosis["ranking"][:SHOWN]
    look: dict[str, Any] = {"font": {"size": 11, "color": style.MUTED}, "xanchor": "left", "xref": "x", "yref": "y"}
    untried = [place for place, entry in enumerate(ranking) if not entry.get("held_out_gain")]
    notes = [style.note("not refitted", 1.0, place, **look) for place in untried]
    names = [with_probability(diagnosis, entry["effect"]) for entry in ranking]
    axes: dict[str, Any] = {
        "xaxis": style.axis("Error removed (%)", range=[_lowest(ranking), 104]),
        "yaxis": style.names_of_bars(names),
        "margin": {"l": 230, "r": 20, "t": 16, "b": 44},
    }
    height = 70 + 34 * max(len(ranking), 2)
    return style.figure([_measured(diagnosis, ranking)], height=height, annotations=notes, **axes)


def _measured(diagnosis: Mapping[str, Any], ranking: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Bars with intervals, for the candidates that were refitted."""
    places = [place for place, entry in enumerate(ranking) if entry.get("held_out_gain")]
    gains = [ranking[place]["held_out_gain"] for place in places]
    ends = np.array([[removed_percent(gain) for gain in one] for one in gains]).reshape(-1, 3)
    whiskers = {
        "array": np.maximum(ends[:, 2] - ends[:, 0], 0.0),
        "arrayminus": np.maximum(ends[:, 0] - ends[:, 1], 0.0),
        "symmetric": False,
        "color": style.INK,
    }
    colours = [_colour(diagnosis, place) for place in places]
    hover = "with it refitted: %{x:.0f} % of the held-out error is gone"
    return style.bars(ends[:, 0], colours, hover, y=np.array(places, dtype=float), error_x=whiskers)


def _lowest(ranking: Sequence[Mapping[str, Any]]) -> float:
    """Where the axis begins: at 0, or as far left of it as an interval goes, at most where the error has doubled."""
    gains = [gain for entry in ranking for gain in entry.get("held_out_gain") or ()]
    lowest = min([removed_percent(gain) for gain in gains], default=0.0)
    return max(1.04 * lowest, -104.0) if lowest < 0 else 0.0


def _colour(diagnosis: Mapping[str, Any], number: int) -> str:
    """What was found, and what is tied with the first of it, stands out."""
    entry = diagnosis["ranking"][number]
    named = diagnosis["verdict"] == "missing"
    found = {one["effect"] for one in diagnosis["found"]}
    return style.VERMILION if named and (entry["effect"] in found or entry.get("tied_for_first")) else style.SKY


def dependence(diagnosis: Mapping[str, Any]) -> style.Figure | None:
    """What the final model's residual depends on, force and conductance apart; None when it depends on nothing."""
    found = diagnosis.get("depends_on", [])[:SHOWN]
    if not found:
        return None
    names = [f"{entry['channel']} on {spoken(entry['coordinate'])}" for entry in found]
    colours = [style.BLUE if entry["channel"] == "force" else style.GREEN for entry in found]
    bars = style.bars(np.array([100 * entry["gain"] for entry in found]), colours, "%{x:.1f} %")
    axes: dict[str, Any] = {
        "xaxis": style.axis("Share of its squares that a free-form map explains (%)", rangemode="tozero"),
        "yaxis": style.names_of_bars(names),
        "margin": {"l": 250, "r": 20, "t": 16, "b": 44},
    }
    return style.figure([bars], height=70 + 30 * max(len(found), 2), **axes)


def prediction(
    time_s: FloatArray,
    residual: Mapping[str, FloatArray],
    contribution: Mapping[str, FloatArray],
    start_s: float | None = None,
    end_s: float | None = None,
    effect: str = "the effect",
) -> style.Figure:
    """What the model leaves, and what an effect would add, over time; zoom linked.

    Parameters
    ----------
    time_s : ndarray, shape (n,)
    residual, contribution : mapping of channel to ndarray, shape (n,)
        Measured minus modelled, and modelled with minus modelled without the effect.
    start_s, end_s : float, optional
        Draw this stretch only.
    effect : str
        What the legend calls it.
    """
    rows, gaps = window(time_s, start_s, end_s), gaps_in(time_s)
    traces = []
    for row, channel in enumerate(residual):
        first: dict[str, Any] = {"showlegend": row == 0, "gaps": gaps}
        left = "what the model leaves"
        traces.append(line(time_s[rows], residual[channel][rows], style.FAINT, left, row, **first))
        added, name = contribution[channel][rows], f"what {effect} would add"
        traces.append(line(time_s[rows], added, style.VERMILION, name, row, width=1.8, **first))
    axes = style.stacked_axes([RESIDUALS[channel] for channel in residual], "Time (s)")
    return style.figure(traces, height=190 * len(residual) + 70, **axes)


def slope(residual: Mapping[str, FloatArray], contribution: Mapping[str, FloatArray]) -> style.Figure:
    """Mean residual against predicted contribution: an effect that is really there lies on the 1:1 line."""
    channels = list(residual)
    traces: list[dict[str, Any]] = []
    for column, channel in enumerate(channels):
        # Both about their own mean: offsets belong to the mounting.
        x, y, _ = binned(*(values - values.mean() for values in (contribution[channel], residual[channel])))
        ends = np.array([x.min(), x.max()])
        dashed = {"color": style.INK, "width": 1, "dash": "dash"}
        traces.append(style.dots(x, y, style.VERMILION, column, 7))
        traces.append(style.curve(ends, ends, style.INK, column, line=dashed, hoverinfo="skip"))
    titles = [(f"Predicted {channel} ({PANEL_UNITS[channel]})", RESIDUAL_TITLES[channel]) for channel in channels]
    return style.figure(traces, height=330, **style.side_by_side_axes(titles, gap=0.17))
