"""Our Plotly figures as PNG, PDF or SVG for a paper, drawn by matplotlib: no browser needed.

It knows what our figures use and no more: lines, markers, filled bands, bars with error bars, heat maps,
annotations, lines and rectangles, linear and log axes placed by their domain. Anything else is refused by name,
so that a picture can never lose a part in silence.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gcode.support.errors import UserError
from gcode.support.figures import PRINT, panels
from gcode.support.files import atomic_path, check_place
from testbench.report import style
from testbench.report.writing.static_page import DASHES, Page, plain, tick

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# What is left out of a file, so that the same figure gives the same bytes.
METADATA: Any = {"png": {"Software": None}, "pdf": {"CreationDate": None}, "svg": {"Date": None}}
SYMBOLS = {"circle": "o", "diamond": "D", "triangle-up": "^"}
WIDTH_PX, DOTS_PER_INCH = 1000, 100
RC: Any = {"font.family": "sans-serif", "font.size": 9, **PRINT}


def write_figure(figure: style.Figure, path: str | Path) -> None:
    """Write one figure; the format follows the suffix of `path`.

    Parameters
    ----------
    figure : dict
        A Plotly figure as plain data.
    path : path
        ``.png``, ``.pdf`` or ``.svg``; written atomically.

    Raises
    ------
    UserError
        For another suffix.
    """
    suffix = _format(path)
    drawing = draw(figure)
    from matplotlib import rc_context

    with rc_context(RC), atomic_path(path) as temporary:
        # Wide tick labels push the axis title out of the page: the page grows as far as needed.
        look: Any = {"dpi": 2 * DOTS_PER_INCH, "bbox_inches": "tight", "pad_inches": 0.05}
        drawing.savefig(temporary, format=suffix, metadata=METADATA[suffix], **look)


def check_figure(path: str | Path | None) -> None:
    """Refuse a place for a figure before the work whose picture would be lost there; None is let through.

    Raises
    ------
    UserError
        If its suffix is none of a figure, or no file can be written there.
    """
    if path is not None:
        check_place(path)
        _format(path)


def _format(path: str | Path) -> str:
    """``png``, ``pdf`` or ``svg``, as the suffix of `path` says."""
    suffix = Path(path).suffix.lstrip(".").lower()
    if suffix not in METADATA:
        raise UserError(f"{path}: a figure is written as {', '.join(METADATA)}; got {suffix or 'no suffix'!r}")
    return suffix


def draw(figure: style.Figure):
    """Draw a figure with matplotlib.

    Returns
    -------
    matplotlib.figure.Figure
    """
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    layout = figure["layout"]
    height_px = layout.get("height", 400)
    with rc_context(RC):
        drawing = Figure(figsize=(WIDTH_PX / DOTS_PER_INCH, height_px / DOTS_PER_INCH), facecolor=style.PAPER)
        _fill(Page(drawing, layout, WIDTH_PX, height_px), figure)
    return drawing


def draw_on(figure: style.Figure, axes: Axes | Sequence[Axes] | None) -> NDArray[Any]:
    """Draw each panel of a figure on axes that are given (default: of a new figure).

    Returns
    -------
    ndarray of Axes, shape (panels,)
    """
    layout = figure["layout"]
    names = [(layout[key].get("anchor", "x"), key.replace("axis", "")) for key in layout if key.startswith("yaxis")]
    on = panels(axes, len(names))
    page = Page(on[0].figure, layout, given=dict(zip(names, on, strict=True)))
    for x_name, y_name in names:
        page.axes_of({"xaxis": x_name, "yaxis": y_name})
    _fill(page, figure)
    return np.array(on)


def _fill(page: Page, figure: style.Figure) -> None:
    for trace in figure["data"]:
        kind = trace.get("type", "scatter")
        if kind not in DRAWERS:
            raise UserError(
                f"figures of type {kind} cannot be drawn without a browser; allowed: {', '.join(DRAWERS)}"
            )
        DRAWERS[kind](page.axes_of(trace), trace, page)
    page.finish()


def _scatter(axes, trace: dict[str, Any], page: Page) -> None:
    x, y = np.asarray(trace["x"]), np.asarray(trace["y"])
    mode, line, marker = trace.get("mode", "lines"), trace.get("line", {}), trace.get("marker", {})
    label = trace.get("name") if trace.get("showlegend") else None
    alpha = trace.get("opacity", 1)
    if "lines" in mode:
        look = {"color": line.get("color", style.BLUE), "ls": DASHES[line.get("dash", "solid")]}
        axes.plot(x, y, lw=line.get("width", 1.2) * 0.8, alpha=alpha, label=label, **look)
        label = None
    if "markers" in mode:
        size, symbol = marker.get("size", 6) * 0.72, SYMBOLS[marker.get("symbol", "circle")]
        look = {"marker": symbol, "color": marker.get("color", style.BLUE), "alpha": alpha, "label": label}
        axes.scatter(x, y, s=size**2, zorder=3, linewidths=0, edgecolors="none", **look)
    _error_bars(axes, trace, x, y)


def _colour_bar(axes, mappable, settings: dict[str, Any], page: Page) -> None:
    box = axes.get_position()
    bar_axes = page.drawing.add_axes((box.x1 + 0.012, box.y0 + 0.05 * box.height, 0.01, 0.9 * box.height))
    bar = page.drawing.colorbar(mappable, cax=bar_axes)
    bar_axes.yaxis.set_major_formatter(tick)
    bar.outline.set_visible(False)
    bar_axes.tick_params(colors=style.MUTED, labelsize=8)
    bar_axes.set_title(plain(settings.get("title", {}).get("text", "")), fontsize=8, color=style.MUTED)


def _error_bars(axes, trace: dict[str, Any], x, y) -> None:
    for key, direction in (("error_x", "xerr"), ("error_y", "yerr")):
        if key in trace:
            look = {"fmt": "none", "ecolor": trace[key].get("color", style.MUTED), "elinewidth": 1, "capsize": 2}
            high = np.asarray(trace[key]["array"])
            low = np.asarray(trace[key].get("arrayminus", high))
            axes.errorbar(x, y, **{direction: np.stack([low, high])}, **look)


def _bar(axes, trace: dict[str, Any], page: Page) -> None:
    flat = trace.get("orientation") == "h"
    along, length = (trace["y"], trace["x"]) if flat else (trace["x"], trace["y"])
    along, length = np.asarray(along), np.asarray(length)
    look = {"color": trace.get("marker", {}).get("color", style.BLUE), "alpha": trace.get("opacity", 1)}
    look["label"] = trace.get("name") if trace.get("showlegend") else None
    (axes.barh if flat else axes.bar)(along, length, trace.get("width", 0.8), **look)
    _error_bars(axes, trace, *((length, along) if flat else (along, length)))
    for place, end, text in zip(along, length, trace.get("text", []), strict=False):
        look = {"xytext": (0, 2), "textcoords": "offset points", "ha": "center", "va": "bottom", "fontsize": 8}
        axes.annotate(plain(str(text)), (place, end), **look)


def _heatmap(axes, trace: dict[str, Any], page: Page) -> None:
    from matplotlib.colors import LinearSegmentedColormap

    z = np.ma.masked_invalid(np.asarray(trace["z"], dtype=float))
    look = {"vmin": trace.get("zmin"), "vmax": trace.get("zmax"), "rasterized": True}
    look["cmap"] = LinearSegmentedColormap.from_list("house", trace["colorscale"])
    cells = axes.pcolormesh(trace["x"], trace["y"], z, shading="nearest", **look)
    _colour_bar(axes, cells, trace["colorbar"], page)


DRAWERS = {"scatter": _scatter, "bar": _bar, "heatmap": _heatmap}
