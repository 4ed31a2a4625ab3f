"""Figure of an investigation: what was believed after each run, over the time of motion, and the motions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from testbench.investigating.state import Investigation
from testbench.investigating.words import spoken
from testbench.knit.effect import FloatArray
from testbench.report import style
from testbench.report.figures.recording_figures import line

SHOWN, WORTH = 6, 0.05  # curves; a hypothesis that was never so probable is not drawn
COLOURS = (style.VERMILION, style.BLUE, style.GREEN, style.ORANGE, style.PURPLE, style.SKY)


def hypotheses(investigation: Investigation) -> list[str]:
    """The hypotheses that were ever worth a curve, the most probable at the end first."""
    beliefs = [run.belief.probabilities for run in investigation.runs if run.belief is not None]
    names = {name for one in beliefs for name, chance in one.items() if chance >= WORTH}
    return sorted(names, key=lambda name: -beliefs[-1].get(name, 0.0))[:SHOWN] if beliefs else []


def investigation(state: Investigation, motions: Sequence[tuple[FloatArray, FloatArray]] = ()) -> style.Figure:
    """Belief over the time of motion; below it the strain, where the motions of the runs are given, in turn.

    A motion is its time in s and its strain in percent, each shape (n,).
    """
    judged = [run for run in state.runs if run.belief is not None]
    ends_min = np.cumsum([run.seconds for run in judged]) / 60
    traces: list[dict[str, Any]] = []
    for colour, name in zip(COLOURS, hypotheses(state), strict=False):
        chances = [100 * run.belief.probabilities.get(name, 0.0) for run in judged if run.belief is not None]
        look: dict[str, Any] = {"mode": "lines+markers", "line": {"color": colour, "width": 2}, "showlegend": True}
        traces.append(style.dots(ends_min, np.array(chances), colour, size=7, name=spoken(name), **look))
    start_min = 0.0
    for time_s, strain_percent in motions:
        traces.append(line(start_min + time_s / 60, strain_percent, style.STRAIN, "strain", 1))
        start_min += float(time_s[-1]) / 60
    titles = ["Probability (%)", *(["Strain (%)"] if motions else [])]
    axes = style.stacked_axes(titles, "Time of motion (min)", [0.58, 0.34][: len(titles)], gap=0.08)
    axes["yaxis"]["range"] = [-3, 103]
    sure = style.level(100 * state.settings.sure, style.FAINT)
    return style.figure(traces, height=520, shapes=[sure], **axes)
