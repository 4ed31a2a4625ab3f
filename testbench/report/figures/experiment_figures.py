"""Figure of a proposed experiment: every protocol's worth, the best one's motion, and what it would show."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from gcode.support.arrays import FloatArray
from testbench.report import style
from testbench.report.figures.recording_figures import line

LEAST = 0.1  # evidence below this is drawn as this, a short bar: a logarithmic axis has no zero
BEGIN = LEAST / 2  # of the axis
DECISIVE = 5.0
COLOURS = {"force": style.FORCE, "conductance": style.CONDUCTANCE}


def of_file(found: Mapping[str, Any], time_s: FloatArray, strain_percent: FloatArray) -> style.Figure:
    """Ranking, motion, and what the wrong model leaves.

    Parameters
    ----------
    found : mapping
        The JSON of a ``testbench experiment --json``.
    time_s, strain_percent : ndarray, shape (n,)
        Motion of the best.
    """
    motion = line(time_s, strain_percent, style.STRAIN, "strain", 1)
    misfits = [
        line(np.array(one["time_s"]), np.array(one["over_noise"]), COLOURS[channel], channel, 2)
        for channel, one in found["left"].items()
    ]
    for trace in (motion, *misfits):
        trace["xaxis"] = "x2"
    for trace in misfits:
        trace["showlegend"] = True
    legend = {"orientation": "h", "x": 1, "xanchor": "right", "y": 0.44, "yanchor": "bottom"}
    ranked = ranking([(option["protocol"], option["log_odds"]) for option in found["options"]])
    names = {**ranked["layout"]["yaxis"], "domain": [0.56, 1.0]}
    axes = {
        "yaxis": names,
        "xaxis2": style.axis("Time (s)", anchor="y3"),
        "yaxis2": style.axis("Strain (%)", anchor="x2", domain=[0.25, 0.44]),
        "yaxis3": style.axis("Left over / noise", anchor="x2", domain=[0.0, 0.21]),
    }
    layout = {**ranked["layout"], "height": 760, "showlegend": True, "legend": legend, **axes}
    return style.figure([*ranked["data"], motion, *misfits], **layout)


def ranking(evidence: Sequence[tuple[str, float]]) -> style.Figure:
    """The worth of every protocol, the best on top, and the line beyond which the evidence decides."""
    names = [name.replace("-", " ") for name, _ in evidence]
    values = np.array([value for _, value in evidence])
    lengths = np.maximum(values, LEAST)
    top = max(float(lengths.max()), 10 * DECISIVE)
    axes = {
        "xaxis": style.axis(
            "Expected evidence (log odds)",
            **style.log_ticks([BEGIN, top * 1.5]),
            anchor="y",
            range=[float(np.log10(BEGIN)), float(np.log10(top * 1.5))],
        ),
        "yaxis": style.names_of_bars(names, anchor="x"),
    }
    decisive: dict[str, Any] = {"type": "line", "line": {"color": style.VERMILION, "width": 1, "dash": "dash"}}
    decisive |= {"xref": "x", "yref": "y domain", "x0": DECISIVE, "x1": DECISIVE, "y0": 0, "y1": 1}
    words = style.note("decisive", float(np.log10(DECISIVE)), 1.0, xref="x", xanchor="left", yanchor="bottom")
    return style.figure(
        [
            style.bars(
                lengths, [style.BLUE] + [style.FAINT] * (len(evidence) - 1), "%{customdata:.3g}", customdata=values
            )
        ],
        height=380,
        margin={"l": 130, "r": 20, "t": 26, "b": 44},
        annotations=[words],
        shapes=[decisive],
        **axes,
    )
