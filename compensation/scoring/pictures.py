"""Pictures of scores, drawn from the score's JSON alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from gcode.support.colours import BLACK, BLUE, ORANGE
from gcode.support.figures import PRINT
from gcode.support.files import atomic_path

TRUTH, RAW, PREDICTION = BLACK, ORANGE, BLUE
SYMBOL = {"force": "F", "displacement": "d"}


def draw_scores(scores: dict[str, Any], path: str | Path) -> None:
    """Write a PNG, PDF or SVG: a band for each recording with F, G and p over time, two zooms, scatter plots."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    rows = scores["recordings"]
    figure = Figure(figsize=(12, 5.0 * len(rows)), layout="constrained")
    bands = figure.subfigures(len(rows), 1, squeeze=False)[:, 0]
    for band, row in zip(bands, rows, strict=True):
        _draw_band(band, row, scores["compensator"])
    with rc_context(PRINT), atomic_path(path) as temporary:
        figure.savefig(temporary, dpi=110)


def _draw_band(band, row: dict[str, Any], compensator: dict[str, Any]) -> None:
    label = f"{compensator['target']} ({compensator['unit']})"
    name = row["source"].removesuffix("/recording.csv").rsplit("/", 1)[-1]
    title = f"{name} ({row['role']}): r2 {row['r2_before']:.3f} raw, {row['r2_after']:.3f} compensated"
    axes = band.subplot_mosaic([["all"] * 6, ["z0", "z0", "z1", "z1", "before", "after"]])
    _over_time(axes["all"], row["trace"], SYMBOL[compensator["target"]])
    axes["all"].legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3, fontsize=8, frameon=False)
    axes["all"].set_title(title, loc="left", fontsize=11, fontweight="bold")
    axes["all"].set_ylabel(label)
    # The middle window says less than the two ends, between which the drift happens.
    for axis, zoom in zip((axes["z0"], axes["z1"]), (row["zooms"][0], row["zooms"][-1]), strict=True):
        _over_time(axis, zoom, SYMBOL[compensator["target"]])
    axes["z0"].set_ylabel(label)
    _scatter(axes["before"], row["trace"]["F"], row["trace"]["G_rescaled"], RAW, "G, rescaled")
    _scatter(axes["after"], row["trace"]["F"], row["trace"]["p"], PREDICTION, "p")
    for axis in (axes["before"], axes["after"]):
        axis.set_xlabel(f"measured {label}")


def _over_time(axis, trace: dict[str, list[float]], symbol: str) -> None:
    axis.plot(trace["time_s"], trace["G_rescaled"], color=RAW, lw=0.9, label="G: conductance, rescaled")
    axis.plot(trace["time_s"], trace["F"], color=TRUTH, lw=0.9, label=f"{symbol}: measured")
    axis.plot(trace["time_s"], trace["p"], color=PREDICTION, lw=0.9, label="p: compensated")
    axis.set_xlabel("time (s)")
    axis.margins(x=0)


def _scatter(axis, truth: list[float], other: list[float], colour: str, name: str) -> None:
    ends = [min(truth), max(truth)]
    axis.plot(truth, other, ".", color=colour, ms=2, alpha=0.5)
    axis.plot(ends, ends, color=TRUTH, lw=0.8)
    axis.set_ylabel(name)
