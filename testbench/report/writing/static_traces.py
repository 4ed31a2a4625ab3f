"""How matplotlib draws each kind of trace: lines, markers, filled bands, bars with error bars, heat maps."""

from __future__ import annotations

from typing import Any

import numpy as np

from testbench.report import style
from testbench.report.writing.static_page import DASHES, Page, plain, tick

SYMBOLS = {"circle": "o", "diamond": "D", "triangle-up": "^"}


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
    cells = axes.pcolormesh(_edges(trace["x"]), _edges(trace["y"]), z, **look)
    _colour_bar(axes, cells, trace["colorbar"], page)


def _edges(centres: Any) -> np.ndarray:
    centres = np.asarray(centres, dtype=float)
    if len(centres) == 1:
        return centres[0] + np.array([-0.5, 0.5])
    middle = (centres[1:] + centres[:-1]) / 2
    return np.concatenate([[2 * centres[0] - middle[0]], middle, [2 * centres[-1] - middle[-1]]])


DRAWERS = {"scatter": _scatter, "bar": _bar, "heatmap": _heatmap}
