"""The paper of a figure that matplotlib draws: axes placed by their domain, legend, shapes, annotations."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from testbench.comparing.numbers import in_powers
from testbench.report import style

DASHES = {"dash": "--", "dot": ":", "solid": "-"}


class Page:
    """Where the axes lie on the paper, if they are not `given` by the names of a panel's two axes."""

    def __init__(
        self,
        drawing,
        layout: dict[str, Any],
        width_px: float = 1.0,
        height_px: float = 1.0,
        given: Mapping[tuple[str, str], Any] | None = None,
    ) -> None:
        self.drawing, self.layout, self.given = drawing, layout, given or {}
        margin = layout.get("margin", {})
        self.left, self.right = margin.get("l", 60) / width_px, 1 - margin.get("r", 20) / width_px
        self.bottom, self.top = margin.get("b", 40) / height_px, 1 - margin.get("t", 30) / height_px
        self._axes: dict[tuple[str, str], Any] = {}

    def place(self, x: float, y: float) -> tuple[float, float]:
        """From Plotly's paper coordinates to the figure's."""
        return self.left + x * (self.right - self.left), self.bottom + y * (self.top - self.bottom)

    def axes_of(self, trace: dict[str, Any]):
        """The axes that a trace is drawn on, made when they are first asked for."""
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
        box = left, bottom, right - left, top - bottom
        axes = self.given.get((x_name, y_name)) or self.drawing.add_axes(box, sharex=shared)
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
        """Settings of the axis that a trace names ``x2``; empty where the layout has none."""
        return self.layout.get(f"{name[0]}axis{name[1:]}", {})

    def finish(self) -> None:
        """Put in what lies over the traces: shapes, annotations, the legend."""
        for shape in self.layout.get("shapes", []):
            self._shape(shape)
        for item in self.layout.get("annotations", []):
            self._annotation(item)
        if self.layout.get("showlegend"):
            self._legend()

    def _legend(self) -> None:
        named: dict[str, Any] = {}
        for axes in self._axes.values():
            for handle, name in zip(*axes.get_legend_handles_labels(), strict=True):
                named.setdefault(name, handle)
        if not named:
            return
        holder, side, anchor = self.drawing, "right", (self.right, self.top)
        if self.given:
            holder, side, anchor = next(iter(self.given.values())), "left", (0, 1)
        elif self.layout.get("legend", {}).get("xanchor") == "left":
            side, anchor = "left", (self.left, self.top)
        look = {"ncols": len(named), "frameon": False, "fontsize": 8.5}
        holder.legend([*named.values()], [*named], loc=f"lower {side}", bbox_to_anchor=anchor, **look)

    def _target(self, item: dict[str, Any]):
        x_name, y_name = item.get("xref", "x"), item.get("yref", "y")
        wanted = (x_name.removesuffix(" domain"), y_name.removesuffix(" domain"))
        return next(
            axes
            for (x, y), axes in self._axes.items()
            if wanted[0] in (x, "paper") and (wanted[1] in (y, "paper") or y_name.endswith("domain"))
        )

    def _shape(self, shape: dict[str, Any]) -> None:
        """A band or a line across the whole page or a panel, upright where its vertical axis is the paper."""
        line, upright = shape["line"], shape["yref"].endswith(("paper", "domain"))
        for axes in self._shape_axes(shape):
            if shape["type"] == "rect":
                look = {"color": shape["fillcolor"], "alpha": shape["opacity"], "lw": 0, "zorder": 0}
                span = (axes.axvspan, "x0", "x1") if upright else (axes.axhspan, "y0", "y1")
                span[0](shape[span[1]], shape[span[2]], **look)
            else:
                look = {"color": line["color"], "linewidth": line["width"], "linestyle": DASHES[line["dash"]]}
                (axes.axvline if upright else axes.axhline)(shape["x0" if upright else "y0"], **look)

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
        # On a logarithmic axis Plotly counts an annotation's place in decades.
        x = 10 ** item["x"] if coords[0] == "data" and axes.get_xscale() == "log" else item["x"]
        axes.annotate(text, (x, item["y"]), xycoords=coords, xytext=(0, 0), textcoords="offset points", **look)


def plain(text: str) -> str:
    """Plain text of a label that holds the few HTML tags Plotly knows."""
    return re.sub("</?[bi]>", "", text).replace("<br>", "\n")


def tick(value: float, _: Any = None) -> str:
    """A number at an axis, whole: a power of ten in a corner is overlooked, or lies on another word."""
    return in_powers(f"{value:.10g}").replace("-", "−")


def _dress(axis, set_scale, set_limits, settings: dict[str, Any]) -> None:
    text = settings.get("title", {}).get("text", "")
    axis.set_label_text(plain(text), fontsize=9, color=style.MUTED)
    log = settings.get("type") == "log"
    if log:
        set_scale("log")
        axis.set_minor_formatter("")
    axis.set_major_formatter(tick)
    if "range" in settings:
        limits = [float(value) for value in settings["range"]]
        set_limits(*(10 ** np.array(limits) if log else limits))
    if "tickvals" in settings:
        axis.set_ticks(settings["tickvals"], [plain(str(label)) for label in settings["ticktext"]])
    if not settings.get("showgrid", True):
        axis.grid(False)
