"""The house style of every figure and page, in one place: colours, type, axes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from gcode.support.colours import BLUE, GREEN, PURPLE, VERMILION
from gcode.support.colours import ORANGE as ORANGE
from gcode.support.colours import SKY as SKY
from testbench.comparing.numbers import bare

Figure = dict[str, Any]  # a Plotly figure as plain data: {"data": [...], "layout": {...}}

INK, MUTED, FAINT, RULE = "#1d2733", "#5b6875", "#a9b3bd", "#e4e1da"
PAPER = "#ffffff"

MEASURED, FLOOR = INK, FAINT
STRAIN, FORCE, CONDUCTANCE = PURPLE, BLUE, GREEN

FONT_STACK = "Inter, 'Segoe UI', system-ui, -apple-system, 'DejaVu Sans', sans-serif"
DIVERGING = [[0.0, BLUE], [0.5, "#f4f2ee"], [1.0, VERMILION]]
# The dark four fifths of cividis, which colour-blind and other readers see alike (Nunez, Anderton, Renslow 2018).
SEQUENCE = ("#00224e", "#2a3f6d", "#575d6d", "#7c7b78", "#a59c74", "#d2c060")

CONFIG = {"displaylogo": False, "responsive": True, "modeBarButtonsToRemove": ["select2d", "lasso2d"]}


def axis(title: str = "", **more: Any) -> dict[str, Any]:
    """One axis in the house style."""
    return {
        "title": {"text": title, "standoff": 6, "font": {"size": 12, "color": MUTED}},
        "gridcolor": RULE,
        "zeroline": False,
        "linecolor": FAINT,
        "ticks": "outside",
        "ticklen": 4,
        "tickcolor": FAINT,
        "tickfont": {"size": 11, "color": MUTED},
        "automargin": True,
        "exponentformat": "power",  # no "500µ" beside "0.001"
        "minexponent": 4,
        **more,
    }


def parts_of_title(title: str) -> tuple[str, str]:
    """``Force (N)`` as its quantity and its unit."""
    quantity, _, unit = title.rpartition(" (")
    return quantity, unit.removesuffix(")")


def log_ticks(values: Sequence[float]) -> dict[str, Any]:
    """Settings of a logarithmic axis: its decades are named, and their 2 and 5 where there are few of them."""
    low, high = min(values), max(values)
    steps = (1,) if high >= 100 * low else (1, 2, 5)
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    inside = [tick for decade in decades for step in steps if low <= (tick := step * 10.0**decade) <= high]
    ticks = inside or [low, high]
    return {"type": "log", "tickvals": ticks, "ticktext": [bare(tick) for tick in ticks]}


def figure(data: list[dict[str, Any]], *, height: int, **layout: Any) -> Figure:
    """A figure in the house style; `layout` adds axes and whatever else this one needs.

    A trace enters the legend only when it says so.
    """
    data = [{"showlegend": False, **trace} for trace in data]
    base: dict[str, Any] = {
        "height": height,
        "margin": {"l": 64, "r": 20, "t": 30, "b": 44},
        "paper_bgcolor": PAPER,
        "plot_bgcolor": PAPER,
        "font": {"family": FONT_STACK, "size": 12, "color": INK},
        "hoverlabel": {"font": {"family": FONT_STACK, "size": 12}},
        "legend": {"orientation": "h", "x": 0, "xanchor": "left", "y": 1.0, "yanchor": "bottom"},
        "showlegend": any(trace.get("showlegend") for trace in data),
        "dragmode": "zoom",
    }
    return {"data": data, "layout": {**base, **layout}}


def stacked_axes(
    titles: Sequence[str], x_title: str, heights: Sequence[float] = (), gap: float = 0.05
) -> dict[str, Any]:
    """Axes of rows that share one horizontal axis, top row first: zooming in one zooms all.

    Parameters
    ----------
    titles : sequence of str
    x_title : str
    heights : sequence of float, optional
        How tall each row is beside the others; default: all alike.
    gap : float
        Between two rows, as a share of the whole.

    Returns
    -------
    dict
        ``xaxis``, ``yaxis``, ``yaxis2``, ...: trace number i goes to ``"x"`` and `y_ref(i)`.
    """
    heights = heights or [1.0] * len(titles)
    unit = (1 - gap * (len(titles) - 1)) / (sum(heights) or 1.0)
    axes, top = {}, 1.0
    for row, (title, height) in enumerate(zip(titles, heights, strict=True)):
        low = max(top - height * unit, 0.0)
        axes[axis_key("yaxis", row)] = axis(title, domain=[low, top], anchor="x")
        top = low - gap
    axes["xaxis"] = axis(x_title, anchor=y_ref(len(titles) - 1), minexponent=6)  # a week has 604800 s
    return axes


def side_by_side_axes(panels: list[tuple[str, str]], gap: float = 0.09) -> dict[str, Any]:
    """Axes of panels in one row, each ``(x title, y title)``; trace number i goes to `x_ref(i)`, `y_ref(i)`."""
    axes: dict[str, Any] = {}
    for column, ((x_title, y_title), domain) in enumerate(zip(panels, parts(len(panels), gap), strict=True)):
        axes |= panel(column, axis(x_title, domain=domain), axis(y_title))
    return axes


def panel(index: int, x: dict[str, Any], y: dict[str, Any]) -> dict[str, Any]:
    """The two axes of panel number `index`, each tied to the other."""
    return {
        axis_key("xaxis", index): x | {"anchor": y_ref(index)},
        axis_key("yaxis", index): y | {"anchor": x_ref(index)},
    }


def parts(count: int, gap: float, whole: float = 1.0) -> list[list[float]]:
    """From 0 to `whole` in `count` equal parts, `gap` apart: where each begins and ends."""
    size = (whole - gap * (count - 1)) / max(count, 1)
    return [[n * (size + gap), min(n * (size + gap) + size, 1.0)] for n in range(count)]


def rows(count: int, gap: float, whole: float = 1.0) -> list[list[float]]:
    """As `parts`, the top one first."""
    return parts(count, gap, whole)[::-1]


def axis_key(kind: str, index: int) -> str:
    """``xaxis``, ``xaxis2``, ... for index 0, 1, ..."""
    return kind if index == 0 else f"{kind}{index + 1}"


def x_ref(index: int) -> str:
    """How a trace names horizontal axis number `index`."""
    return axis_key("x", index)


def y_ref(index: int) -> str:
    """How a trace names vertical axis number `index`."""
    return axis_key("y", index)


def place(index: int) -> dict[str, str]:
    """Both axes of a trace that lies in panel number `index`."""
    return {"xaxis": x_ref(index), "yaxis": y_ref(index)}


def curve(x: Any, y: Any, colour: str, index: int = 0, width: float = 1.3, **more: Any) -> dict[str, Any]:
    """A line through points in panel number `index`; one between two holes of the line is a dot."""
    look: dict[str, Any] = {"type": "scatter", "mode": "lines", "line": {"color": colour, "width": width}}
    hole = np.isnan(np.concatenate([[np.nan], y, [np.nan]]))
    alone = ~hole[1:-1] & hole[:-2] & hole[2:]
    if alone.any():
        look |= {"mode": "lines+markers", "marker": {"color": colour, "size": np.where(alone, 3.0, 0.0)}}
    return {**look, "x": x, "y": y, **place(index), **more}


def dots(x: Any, y: Any, colour: str, index: int = 0, size: float = 6, **more: Any) -> dict[str, Any]:
    """Points in panel number `index`; with ``mode="lines+markers"`` joined by lines."""
    look = {"type": "scatter", "mode": "markers", "marker": {"size": size, "color": colour}}
    return {**look, "x": x, "y": y, **place(index), **more}


def level(value: float, colour: str, index: int = 0, width: float = 1.0, dash: str = "dash") -> dict[str, Any]:
    """A line across panel number `index` at a height: a limit, a noise floor."""
    look = {"color": colour, "width": width, "dash": dash}
    where = {"xref": f"{x_ref(index)} domain", "yref": y_ref(index), "x0": 0, "x1": 1, "y0": value, "y1": value}
    return {"type": "line", "line": look, **where}


def bars(lengths: Any, colours: list[str], hover: str, **more: Any) -> dict[str, Any]:
    """Bars that lie below each other, the first on top; see `names_of_bars`."""
    return {
        "type": "bar",
        "orientation": "h",
        "x": lengths,
        "y": np.arange(len(lengths)),
        "width": 0.62,
        "marker": {"color": colours},
        "hovertemplate": f"{hover}<extra></extra>",
        **more,
    }


def upright_bars(places: Any, heights: Any, width: float, colour: Any, hover: str, **more: Any) -> dict[str, Any]:
    """Bars that stand side by side, each around its place; a list of colours has one for each."""
    return {
        "type": "bar",
        "x": places,
        "y": np.asarray(heights),
        "width": width,
        "marker": {"color": colour},
        "hovertemplate": hover,
        **more,
    }


def names_of_bars(names: list[str], **more: Any) -> dict[str, Any]:
    """The axis on which `bars` have their names."""
    ticks: dict[str, Any] = {"tickvals": list(range(len(names))), "ticktext": names}
    return axis(range=[len(names) - 0.5, -0.5], showgrid=False, **ticks, **more)


def note(text: str, x: float, y: float, **more: Any) -> dict[str, Any]:
    """A text on the paper (0 to 1 in both directions)."""
    return {
        "text": text,
        "x": x,
        "y": y,
        "xref": "paper",
        "yref": "paper",
        "showarrow": False,
        "font": {"size": 12, "color": MUTED},
        **more,
    }
