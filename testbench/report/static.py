"""Our Plotly figures as PNG, PDF or SVG for a paper, drawn by matplotlib: no browser needed.

It knows what our figures use and no more: lines, markers, filled bands, bars with error bars, heat maps,
annotations, lines and rectangles, linear and log axes placed by their domain. Anything else is refused by name,
so that a picture can never lose a part in silence.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from gcode.support.errors import UserError
from gcode.support.files import atomic_path
from testbench.report import style

FORMATS = ("png", "pdf", "svg")
WIDTH_PX, DOTS_PER_INCH = 1000, 100
RC: Any = {"font.family": "sans-serif", "font.size": 9, "svg.hashsalt": "knitbench"}
DASHES = {"dash": "--", "dot": ":", "dashdot": "-.", "solid": "-"}
SYMBOLS = {"circle": "o", "square": "s", "diamond": "D", "x": "x", "triangle-up": "^", "cross": "P"}


def write_figure(figure: style.Figure, path: str | Path, width_px: int = WIDTH_PX, scale: float = 2.0) -> None:
    """Write one figure; the format follows the suffix of `path`.

    Parameters
    ----------
    figure : dict
        A Plotly figure as plain data.
    path : path
        ``.png``, ``.pdf`` or ``.svg``; written atomically.
    width_px : int
        Width in CSS pixels; the height is the figure's own.
    scale : float
        Pixels of a PNG for each CSS pixel.

    Raises
    ------
    UserError
        For another suffix.
    """
    suffix = Path(path).suffix.lstrip(".").lower()
    if suffix not in FORMATS:
        raise UserError(f"{path}: a figure is written as {', '.join(FORMATS)}; got {suffix or 'no suffix'!r}")
    drawing = draw(figure, width_px)
    # Fixed metadata: the same figure gives the same bytes.
    metadata: dict[str, Any] = {"png": {"Software": None}, "pdf": {"CreationDate": None}, "svg": {"Date": None}}[
        suffix
    ]
    from matplotlib import rc_context

    with rc_context(RC), atomic_path(path) as temporary:
        drawing.savefig(temporary, dpi=DOTS_PER_INCH * scale, format=suffix, metadata=metadata)


def draw(figure: style.Figure, width_px: int = WIDTH_PX):
    """Draw a figure with matplotlib.

    Returns
    -------
    matplotlib.figure.Figure
    """
    from matplotlib import rc_context
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    layout = figure["layout"]
    height_px = layout.get("height", 400)
    with rc_context(RC):
        drawing = Figure(figsize=(width_px / DOTS_PER_INCH, height_px / DOTS_PER_INCH), facecolor=style.PAPER)
        FigureCanvasAgg(drawing)
        page = _Page(drawing, layout, width_px, height_px)
        for trace in figure["data"]:
            DRAWERS[_known(trace)](page.axes_of(trace), trace, page)
        page.finish(figure["data"])
    return drawing


def _known(trace: dict[str, Any]) -> str:
    kind = trace.get("type", "scatter")
    if kind not in DRAWERS:
        raise UserError(f"figures of type {kind} cannot be drawn without a browser; allowed: {', '.join(DRAWERS)}")
    return kind


class _Page:
    """Where the axes lie on the paper."""

    def __init__(self, drawing, layout: dict[str, Any], width_px: float, height_px: float) -> None:
        self.drawing, self.layout = drawing, layout
        margin = layout.get("margin", {})
        self.left, self.right = margin.get("l", 60) / width_px, 1 - margin.get("r", 20) / width_px
        self.bottom, self.top = margin.get("b", 40) / height_px, 1 - margin.get("t", 30) / height_px
        self._axes: dict[tuple[str, str], Any] = {}

    def place(self, x: float, y: float) -> tuple[float, float]:
        """From Plotly's paper coordinates to the figure's."""
        return self.left + x * (self.right - self.left), self.bottom + y * (self.top - self.bottom)

    def axes_of(self, trace: dict[str, Any]):
        key = (trace.get("xaxis", "x"), trace.get("yaxis", "y"))
        if key not in self._axes:
            self._axes[key] = self._make(*key)
        return self._axes[key]

    def _make(self, x_name: str, y_name: str):
        x_axis, y_axis = self.axis(x_name), self.axis(y_name)
        (x0, x1), (y0, y1) = x_axis.get("domain", [0, 1]), y_axis.get("domain", [0, 1])
        left, bottom = self.place(x0, y0)
        right, top = self.place(x1, y1)
        shared = next((axes for (name, _), axes in self._axes.items() if name == x_name), None)
        axes = self.drawing.add_axes((left, bottom, right - left, top - bottom), sharex=shared)
        axes.spines[["top", "right"]].set_visible(False)
        axes.spines[["left", "bottom"]].set_color(style.FAINT)
        axes.grid(color=style.RULE, linewidth=0.6)
        axes.set_axisbelow(True)
        axes.margins(x=0.02)
        axes.tick_params(colors=style.MUTED, labelsize=8)
        _dress(axes.xaxis, axes.set_xscale, axes.set_xlim, x_axis)
        _dress(axes.yaxis, axes.set_yscale, axes.set_ylim, y_axis)
        if x_axis.get("anchor", "y") != y_name:  # the shared axis is written once, under the row it belongs to
            axes.set_xlabel("")
            axes.tick_params(labelbottom=False)
        return axes

    def axis(self, name: str) -> dict[str, Any]:
        return self.layout.get(f"{name[0]}axis{name[1:]}", {})

    def finish(self, data: list[dict[str, Any]]) -> None:
        """Title, legend, shapes and annotations."""
        for shape in self.layout.get("shapes", []):
            self._shape(shape)
        for item in self.layout.get("annotations", []):
            self._annotation(item)
        title = self.layout.get("title", {}).get("text")
        if title:
            self.drawing.text(self.left, 0.985, title, ha="left", va="top", fontsize=11, color=style.INK)
        if self.layout.get("showlegend"):
            self._legend(data)

    def _legend(self, data: list[dict[str, Any]]) -> None:
        handles, names = [], []
        for axes in self._axes.values():
            found, labels = axes.get_legend_handles_labels()
            for handle, name in zip(found, labels, strict=True):
                if name not in names:
                    handles.append(handle)
                    names.append(name)
        if handles:
            _, top = self.place(0, 1)
            left = self.layout.get("legend", {}).get("xanchor") == "left"
            place, anchor = ("lower left", (self.left, top)) if left else ("lower right", (self.right, top))
            look = {"ncols": len(names), "frameon": False, "fontsize": 8.5}
            self.drawing.legend(handles, names, loc=place, bbox_to_anchor=anchor, **look)

    def _target(self, item: dict[str, Any]):
        x_name, y_name = item.get("xref", "x"), item.get("yref", "y")
        wanted = (x_name.removesuffix(" domain"), y_name.removesuffix(" domain"))
        return next(
            axes
            for (x, y), axes in self._axes.items()
            if wanted[0] in (x, "paper") and (wanted[1] in (y, "paper") or y_name.endswith("domain"))
        )

    def _shape(self, shape: dict[str, Any]) -> None:
        line = shape.get("line", {})
        look = {"color": line.get("color", style.INK), "linewidth": line.get("width", 1)}
        for axes in self._shape_axes(shape):
            if shape["type"] == "rect" and shape.get("yref", "").endswith(("paper", "domain")):
                axes.axvspan(
                    shape["x0"], shape["x1"], color=shape["fillcolor"], alpha=shape.get("opacity", 1), lw=0, zorder=0
                )
            elif shape["type"] == "rect":
                axes.axhspan(
                    shape["y0"], shape["y1"], color=shape["fillcolor"], alpha=shape.get("opacity", 1), lw=0, zorder=0
                )
            elif shape.get("xref", "x").endswith(("paper", "domain")):
                axes.axhline(shape["y0"], linestyle=DASHES[line.get("dash", "solid")], **look)
            elif shape.get("yref", "y").endswith(("paper", "domain")):
                axes.axvline(shape["x0"], linestyle=DASHES[line.get("dash", "solid")], **look)
            else:
                axes.plot(
                    [shape["x0"], shape["x1"]],
                    [shape["y0"], shape["y1"]],
                    linestyle=DASHES[line.get("dash", "solid")],
                    **look,
                )

    def _shape_axes(self, shape: dict[str, Any]) -> list[Any]:
        if shape.get("yref") == "paper":
            return [axes for (x, _), axes in self._axes.items() if x == shape.get("xref", "x")]
        return [self._target(shape)]

    def _annotation(self, item: dict[str, Any]) -> None:
        font = item.get("font", {})
        look = {
            "fontsize": 0.75 * font.get("size", 12),
            "color": font.get("color", style.INK),
            "ha": {"left": "left", "right": "right"}.get(item.get("xanchor", ""), "center"),
            "va": {"top": "top", "bottom": "bottom"}.get(item.get("yanchor", ""), "center"),
            "weight": "bold" if item["text"].startswith("<b>") else "normal",
        }
        text = plain(item["text"])
        if item.get("xref") == "paper" and item.get("yref") == "paper":
            self.drawing.text(*self.place(item["x"], item["y"]), text, **look)
            return
        axes = self._target(item)
        coords = ("axes fraction" if item.get("xref", "x").endswith(("paper", "domain")) else "data",
                  "axes fraction" if item.get("yref", "y").endswith(("paper", "domain")) else "data")  # fmt: skip
        offset = (item.get("xshift", 0) * 0.72, item.get("yshift", 0) * 0.72)
        # On a logarithmic axis Plotly counts an annotation's place in decades.
        x = 10 ** item["x"] if coords[0] == "data" and axes.get_xscale() == "log" else item["x"]
        axes.annotate(text, (x, item["y"]), xycoords=coords, xytext=offset, textcoords="offset points", **look)


def plain(text: str) -> str:
    """Plotly's little HTML as plain text."""
    for tag in ("<b>", "</b>", "<i>", "</i>"):
        text = text.replace(tag, "")
    return text.replace("<br>", "\n")


def _dress(axis, set_scale, set_limits, settings: dict[str, Any]) -> None:
    text = settings.get("title", {}).get("text", "")
    axis.set_label_text(plain(text), fontsize=9, color=style.MUTED)
    log = settings.get("type") == "log"
    if log:
        set_scale("log")
    if "range" in settings:
        limits = [float(value) for value in settings["range"]]
        set_limits(*(10 ** np.array(limits) if log else limits))
    elif settings.get("autorange") == "reversed":
        axis.set_inverted(True)
    if "tickvals" in settings:
        axis.set_ticks(settings["tickvals"], [plain(str(label)) for label in settings["ticktext"]])
    if not settings.get("showgrid", True):
        axis.grid(False)
    if not settings.get("showticklabels", True):
        axis.set_ticklabels([])


def _colours(values: Any, marker: dict[str, Any]):
    """Single colours pass through; numbers are mapped by the trace's colour scale."""
    if isinstance(values, str | type(None)) or isinstance(values[0], str):
        return {"color": values or style.BLUE}
    return {"c": values, "cmap": _colour_map(marker["colorscale"])}


def _colour_map(scale: list[list[Any]]):
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list("house", [(float(place), colour) for place, colour in scale])


def _scatter(axes, trace: dict[str, Any], page: _Page) -> None:
    x, y = np.asarray(trace["x"]), np.asarray(trace["y"])
    mode, line, marker = trace.get("mode", "lines"), trace.get("line", {}), trace.get("marker", {})
    label = trace.get("name") if trace.get("showlegend") else None
    alpha = trace.get("opacity", 1)
    if trace.get("fill") == "toself":
        axes.fill(x, y, color=trace["fillcolor"], alpha=alpha, lw=0, label=label)
        return
    if "lines" in mode:
        drawstyle = "steps-post" if line.get("shape") == "hv" else "default"
        axes.plot(
            x,
            y,
            color=line.get("color", style.BLUE),
            lw=line.get("width", 1.2) * 0.8,
            ls=DASHES[line.get("dash", "solid")],
            drawstyle=drawstyle,
            alpha=alpha,
            label=label,
        )
        label = None
    if "markers" in mode:
        _markers(axes, x, y, marker, label, alpha, page)
    if "error_x" in trace or "error_y" in trace:
        _error_bars(axes, trace, x, y)
    if "text" in mode:
        for place, text in zip(zip(x, y, strict=True), trace["text"], strict=True):
            offset = {"top": (0, 6), "bottom": (0, -12), "middle": (0, 0)}[
                trace.get("textposition", "top").split()[0]
            ]
            axes.annotate(plain(str(text)), place, xytext=offset, textcoords="offset points", ha="center", fontsize=8)


def _markers(axes, x, y, marker: dict[str, Any], label: str | None, alpha: float, page: _Page) -> None:
    size = marker.get("size", 6) * 0.72
    symbol = SYMBOLS[marker.get("symbol", "circle")]
    look = _colours(marker.get("color"), marker)
    if marker.get("cmin") is not None:
        look |= {"vmin": marker["cmin"], "vmax": marker["cmax"]}
    edge = marker.get("line", {})
    points = axes.scatter(
        x, y, s=size**2, marker=symbol, label=label, alpha=alpha, zorder=3,
        linewidths=edge.get("width", 0), edgecolors=edge.get("color", "none") if symbol != "x" else None, **look,
    )  # fmt: skip
    if marker.get("showscale"):
        _colour_bar(axes, points, marker.get("colorbar", {}), page)


def _colour_bar(axes, mappable, settings: dict[str, Any], page: _Page) -> None:
    box = axes.get_position()
    bar_axes = page.drawing.add_axes((box.x1 + 0.012, box.y0 + 0.05 * box.height, 0.01, 0.9 * box.height))
    bar = page.drawing.colorbar(mappable, cax=bar_axes)
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


def _bar(axes, trace: dict[str, Any], page: _Page) -> None:
    flat = trace.get("orientation") == "h"
    along, length = (trace["y"], trace["x"]) if flat else (trace["x"], trace["y"])
    colour = trace.get("marker", {}).get("color", style.BLUE)
    look = {
        "color": colour,
        "label": trace.get("name") if trace.get("showlegend") else None,
        "alpha": trace.get("opacity", 1),
    }
    width = trace.get("width", 0.8)
    along, length = np.asarray(along), np.asarray(length)
    along = along + trace.get("offset", -width / 2) + width / 2 if along.dtype.kind in "fiu" else along
    (axes.barh if flat else axes.bar)(along, length, width, **look)
    if "error_x" in trace or "error_y" in trace:
        _error_bars(axes, trace, *((length, along) if flat else (along, length)))
    for place, end, text in zip(along, length, trace.get("text", []), strict=False):
        spot, ha, va = ((end, place), "left", "center") if flat else ((place, end), "center", "bottom")
        offset = (4, 0) if flat else (0, 2)
        axes.annotate(plain(str(text)), spot, xytext=offset, textcoords="offset points", ha=ha, va=va, fontsize=8)


def _heatmap(axes, trace: dict[str, Any], page: _Page) -> None:
    z = np.ma.masked_invalid(np.asarray(trace["z"], dtype=float))
    limits = {"vmin": trace.get("zmin"), "vmax": trace.get("zmax")}
    cells = axes.pcolormesh(
        _edges(trace["x"]), _edges(trace["y"]), z, cmap=_colour_map(trace["colorscale"]), rasterized=True, **limits
    )
    if trace.get("showscale", True):
        _colour_bar(axes, cells, trace.get("colorbar", {}), page)


def _edges(centres: Any) -> np.ndarray:
    centres = np.asarray(centres, dtype=float)
    if len(centres) == 1:
        return centres[0] + np.array([-0.5, 0.5])
    middle = (centres[1:] + centres[:-1]) / 2
    return np.concatenate([[2 * centres[0] - middle[0]], middle, [2 * centres[-1] - middle[-1]]])


DRAWERS = {"scatter": _scatter, "bar": _bar, "heatmap": _heatmap}
