"""Figures of where a residual sits: over each coordinate, and over strain and strain rate. No files, no fitting."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from gcode.support.arrays import FloatArray
from gcode.support.figures import histogram_range
from testbench.comparing.cell import Cell
from testbench.report import style
from testbench.report.figures.comparison_figures import RESIDUAL_TITLES, RESIDUALS, Overlay
from testbench.report.words import PANEL_UNITS

HEAT_MAPS_CAPTION = (
    "Residual over strain and strain rate: orange where the model is too low, blue where it is too high."
)
COORDINATE_TITLES = {
    "strain": "Strain (%)",
    "strain_rate": "Strain rate (%/s)",
    "elapsed_s": "Elapsed time (s)",
    "largest_strain": "Largest strain so far (%)",
    "since_reversal_s": "Since the last reversal (s)",
    "since_hold_s": "Into a hold (s)",
    "cycle": "Cycle",
    "temperature_C": "Temperature (°C)",
}
IN_PERCENT = ("strain", "largest_strain", "strain_rate")
LOG_COORDINATES = ("since_reversal_s", "since_hold_s")
DIRECTIONS = ((1, "stretching", style.BLUE, "triangle-up"), (-1, "releasing", style.VERMILION, "diamond"))
COLUMNS = 3
HEAT_BINS = 24  # at most
FEW = 8  # cells of a map with fewer samples are left blank; a short recording has larger cells, of four times as many


def profiles_caption(channel: str) -> str:
    """What stands under the `profiles` of a channel."""
    return f"Mean residual of the {channel} over each coordinate, with two standard errors."


def profiles(maps: Mapping[str, Sequence[Cell]], channel: str) -> style.Figure:
    """Mean residual over each coordinate with two standard errors, stretching and releasing apart."""
    shown = [name for name in COORDINATE_TITLES if len(maps.get(name, ())) > 1]
    count = -(-len(shown) // COLUMNS)
    across, down = style.parts(COLUMNS, 0.07), style.rows(count, 0.3 / max(count, 1))
    traces: list[dict[str, Any]] = []
    axes: dict[str, Any] = {}
    for index, coordinate in enumerate(shown):
        (row, column), cells = divmod(index, COLUMNS), maps[coordinate]
        traces += _profile(cells, coordinate, index)
        title = RESIDUAL_TITLES[channel] if column == 0 else ""
        axes |= _panel(index, coordinate, cells, title, across[column], down[row])
    return style.figure(_legend_once(traces), height=230 * max(count, 1) + 60, **axes)


def profile(maps: Mapping[str, Mapping[str, Sequence[Cell]]], coordinates: Mapping[str, str]) -> style.Figure:
    """The mean residual of each channel over one coordinate, as `profiles` shows it over all; one row a channel."""
    traces: list[dict[str, Any]] = []
    axes: dict[str, Any] = {}
    down = style.rows(len(coordinates), 0.2)
    for index, (channel, coordinate) in enumerate(coordinates.items()):
        cells = maps[channel][coordinate]
        traces += _profile(cells, coordinate, index)
        axes |= _panel(index, coordinate, cells, RESIDUALS[channel], [0, 1], down[index])
    return style.figure(_legend_once(traces), height=230 * len(coordinates) + 60, **axes)


def _profile(cells: Sequence[Cell], coordinate: str, index: int) -> list[dict[str, Any]]:
    split = any(cell.direction for cell in cells)
    groups = DIRECTIONS if split else ((0, "both directions", style.INK, "circle"),)
    traces = []
    for direction, name, colour, symbol in groups:
        mine = [cell for cell in cells if cell.direction == direction]
        if not mine:
            continue
        x = np.array([centre(cell, coordinate) for cell in mine])
        mean, error = (np.array([getattr(cell, key) for cell in mine]) for key in ("mean", "standard_error"))
        trace = style.dots(x, mean, colour, index, mode="lines+markers", line={"width": 1, "color": colour})
        trace["marker"]["symbol"] = symbol
        whiskers = {"array": 2 * error, "color": colour}
        traces.append(trace | {"name": name, "error_y": whiskers, "hovertemplate": "%{y:.3g} at %{x:.3g}"})
    return traces


def centre(cell: Cell, coordinate: str) -> float:
    """Where a cell is drawn over its coordinate: strains in %, times since an event on a logarithmic axis."""
    if coordinate in LOG_COORDINATES:
        return float(np.sqrt(max(cell.low, cell.high / 20, 1e-3) * max(cell.high, 1e-3)))
    return (100 if coordinate in IN_PERCENT else 1) * (cell.low + cell.high) / 2


def _legend_once(traces: list[dict[str, Any]]) -> list[dict[str, Any]]:
    seen: set[str] = set()
    for trace in traces:
        trace["showlegend"] = trace["name"] not in seen
        seen.add(trace["name"])
    return traces


def _panel(
    index: int, coordinate: str, cells: Sequence[Cell], title: str, across: list[float], down: list[float]
) -> dict[str, Any]:
    log = coordinate in LOG_COORDINATES
    kind = style.log_ticks([centre(cell, coordinate) for cell in cells]) if log and cells else {}
    x = style.axis(COORDINATE_TITLES[coordinate], domain=across, **kind)
    return style.panel(index, x, style.axis(title, domain=down, zeroline=True, zerolinecolor=style.FAINT))


def heat_maps(both: Overlay) -> style.Figure:
    """Mean residual over strain and strain rate, one map a channel: blue where the model is too high."""
    rate = np.gradient(both.strain, both.time_s)
    limit = float(np.quantile(np.abs(rate), 0.995)) or 1.0
    inside = np.abs(rate) <= limit
    panels = [("Strain (%)", "Strain rate (%/s)" if i == 0 else "") for i in range(len(both.measured))]
    traces = []
    for column, channel in enumerate(both.measured):
        x, y, z = _heat(100 * both.strain[inside], 100 * rate[inside], both.residual(channel)[inside])
        bar_x = (1.0 if column == len(both.measured) - 1 else 0.42) + 0.01
        bar = {"title": {"text": PANEL_UNITS[channel]}, "thickness": 10, "outlinewidth": 0, "x": bar_x}
        size = float(np.nanquantile(np.abs(z), 0.98)) if np.isfinite(z).any() else 1.0
        look = {"colorscale": style.DIVERGING, "zmin": -size, "zmax": size, "colorbar": bar}
        look["hovertemplate"] = "strain %{x:.1f} %, rate %{y:.2f} %/s: %{z:.3g}<extra></extra>"
        traces.append({"type": "heatmap", "x": x, "y": y, "z": z, **look, **style.place(column)})
    axes = style.side_by_side_axes(panels, gap=0.16)
    notes = [
        style.note(f"<b>Residual of the {channel}</b>", index * 0.58, 1.0, xanchor="left", yanchor="bottom")
        for index, channel in enumerate(both.measured)
    ]
    return style.figure(traces, height=360, margin={"l": 64, "r": 80, "t": 36, "b": 44}, annotations=notes, **axes)


def _heat(x: FloatArray, y: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    bins = min(int(np.sqrt(len(x) / (4 * FEW))) + 1, HEAT_BINS)
    counts, x_edges, y_edges = np.histogram2d(x, y, bins=bins, range=(histogram_range(x), histogram_range(y)))
    sums, _, _ = np.histogram2d(x, y, bins=(x_edges, y_edges), weights=z)
    with np.errstate(invalid="ignore", divide="ignore"):
        means = np.where(counts >= FEW, sums / counts, np.nan)
    return (x_edges[1:] + x_edges[:-1]) / 2, (y_edges[1:] + y_edges[:-1]) / 2, means.T
