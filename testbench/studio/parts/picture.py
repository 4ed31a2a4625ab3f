"""A Plotly figure on a page: drawn when it comes near the screen, drawn again at full detail where it is zoomed."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.resources import files
from typing import Any

import numpy as np
from nicegui import app, events, ui
from nicegui.element import Element
from numpy.typing import NDArray

from gcode.support.errors import UserError
from testbench.report import style
from testbench.report.writing.packing import PLOTLY_VERSION, plotly_path, to_json
from testbench.studio.parts.fields import comma_taking_number

Drawn = Callable[[float | None, float | None], style.Figure]  # start and end in seconds (None: all) to a figure

PLOTLY_URL = f"/plotly-cartesian-{PLOTLY_VERSION}.min.js"
YEAR_S = 365 * 24 * 3600
DRAWN_WITHIN_S = 10.0  # with a browser that does not say that it has drawn: it may sleep, or look elsewhere


class Picture(Element, component="picture.js"):
    """One figure of `testbench.report`, whose arrays travel packed; `name` is what a screen reader says of it."""

    def __init__(self, figure: style.Figure, name: str = "") -> None:
        super().__init__()
        self.figure = figure
        self.classes("w-full js-plotly-plot")
        self._props["role"], self._props["aria-label"] = "img", name or "plot"
        self._sent_s = -math.inf  # when the figure was sent that the browser has not drawn yet
        self.on("drawn", self._drawn)
        self.show(figure)

    def follow(self, figure: style.Figure) -> bool:
        """Show the next figure of many, unless the browser is still busy with the last: a slow one sees fewer.

        Returns
        -------
        bool
            Whether it was sent.
        """
        now_s = time.monotonic()
        if now_s - self._sent_s < DRAWN_WITHIN_S:
            return False
        self._sent_s = now_s
        self.show(figure)
        return True

    def _drawn(self) -> None:
        self._sent_s = -math.inf

    def show(self, figure: style.Figure) -> None:
        """Put another figure in its place; where the user has zoomed, the zoom stays."""
        self.figure = figure
        self.style(f"height:{figure['layout']['height']}px")
        layout = {"uirevision": "kept", **figure["layout"]}
        self._props["figure"] = to_json({"data": figure["data"], "layout": layout, "config": style.CONFIG})
        self.update()


def serve_plotly() -> None:
    """Let the studio's own server hand out plotly.js."""
    app.add_static_file(local_file=plotly_path(), url_path=PLOTLY_URL, max_cache_age=YEAR_S)


def load_plotly() -> None:
    """Have the page fetch it while everything else is still on its way."""
    narrow = files("testbench.report").joinpath("narrow.js").read_text("utf-8")
    ui.add_head_html(f'<script>{narrow}</script><script id="plotly" async src="{PLOTLY_URL}"></script>')


def plot(figure: style.Figure, caption: str) -> Picture:
    """A figure in a card."""
    with _card(caption):
        return Picture(figure, caption)


@contextmanager
def _card(caption: str) -> Iterator[ui.row]:
    """A card for a picture; yields the row below it, which begins with the caption."""
    with ui.element("figure").classes("card").style("margin:0"):
        holder = ui.column().classes("w-full gap-0")
        below = ui.row().classes("items-center justify-between w-full no-wrap gap-4 below")
        with below, ui.element("figcaption").classes("quiet text-sm"):
            ui.label(caption)
        with holder:
            yield below


Span = tuple[float | None, float | None]  # start and end in seconds; None: as far as it goes


def not_there(span: Span, ends: tuple[float, float]) -> str:
    """Why nothing would be seen of a stretch; empty where something would."""
    start_s, end_s = span
    if start_s is None or end_s is None or (start_s < ends[1] and end_s > ends[0]):
        return ""
    return f"there is nothing before {ends[0]:.1f} s" if end_s <= ends[0] else f"it ends at {ends[1]:.1f} s"


class ZoomingPlot:
    """A plot over time, and fields for its stretch; it is drawn again at full detail where it is zoomed into.

    It opens on `span`, and tells `on_span` of every stretch that is looked at, for the address.

    Raises
    ------
    UserError
        If it is to open on times that there are not.
    """

    def __init__(
        self,
        drawn: Drawn,
        caption: str,
        time_s: NDArray[np.float64],
        span: Span,
        on_span: Callable[[Span], None],
    ) -> None:
        ends = float(time_s[0]), float(time_s[-1])
        if wrong := not_there(span, ends):
            raise UserError(f"the address asks for times from {span[0]:g} to {span[1]:g} s; {wrong}")
        self.drawn, self._on_span, self._ends = drawn, on_span, ends
        with _card(caption) as below:
            self.picture = Picture(looking_at(drawn(*span), span), caption)
        # A zoom without a mouse, and to the second.
        with below, ui.row().classes("items-center gap-2 stretch"):
            self.start, self.end = self._field("From / s"), self._field("to / s")
            whole = ui.button("All", on_click=lambda: self.look(None, None))
            whole.props("flat dense").tooltip("The whole recording")
        self._tell(*span)
        self.picture.on("zoom", self._zoomed)

    def _field(self, label: str) -> ui.number:
        field = comma_taking_number(label, look="%.6g").props("hide-bottom-space").style("width:104px")
        return field.on("keydown.enter", self._asked).on("blur", self._left)

    def look(self, start_s: float | None, end_s: float | None) -> None:
        """Zoom to a stretch, as the mouse would."""
        self.picture.run_method("look", start_s, end_s)

    def _zoomed(self, event: events.GenericEventArguments) -> None:
        span = zoomed_span(event.args)
        if span is not None:
            self._tell(*span)
            # The range goes with the figure: plotly keeps only a range that the mouse has set.
            self.picture.show(looking_at(self.drawn(*span), span))
            self._on_span(span)

    def _left(self) -> None:
        """A field was left: the other may not have been filled yet."""
        if self.start.value is not None and self.end.value is not None:
            self._asked()

    def _asked(self) -> None:
        start_s, end_s = self.start.value, self.end.value
        if (start_s, end_s) == self._told:
            return
        self._mark(self.start, "from when?" if start_s is None else "")
        self._mark(self.end, self._wrong_end(start_s, end_s))
        if start_s is not None and end_s is not None and not self._wrong_end(start_s, end_s):
            self.look(start_s, end_s)

    def _wrong_end(self, start_s: float | None, end_s: float | None) -> str:
        if end_s is None:
            return "to when?"
        if start_s is not None and start_s >= end_s:
            return f"before {start_s:g} s"
        return not_there((start_s, end_s), self._ends)

    def _mark(self, field: ui.number, wrong: str) -> None:
        field.props(f'error error-message="{wrong}"') if wrong else field.props(remove="error error-message")

    def _tell(self, *span: float | None) -> None:
        """Show the stretch that is looked at; None: all."""
        self._told = tuple(None if time_s is None else round(time_s, 2) for time_s in span)
        for field, time_s in zip((self.start, self.end), self._told, strict=True):
            field.set_value(time_s)
            self._mark(field, "")


def looking_at(figure: style.Figure, span: Span) -> style.Figure:
    """The figure, opened on a stretch of time."""
    if span[0] is None or span[1] is None:
        return figure
    layout = figure["layout"]
    return {**figure, "layout": {**layout, "xaxis": {**layout["xaxis"], "range": [span[0], span[1]]}}}


def zoomed_span(change: dict[str, Any]) -> Span | None:
    """The stretch of time that a zoom asks for; (None, None) for all, None when the zoom was not along time."""
    if change.get("xaxis.autorange"):
        return None, None
    start, end = change.get("xaxis.range[0]"), change.get("xaxis.range[1]")
    if start is None and isinstance(change.get("xaxis.range"), list):
        start, end = change["xaxis.range"]
    if start is None or end is None:
        return None
    return float(start), float(end)
