"""A Plotly figure on a page: drawn when it comes near the screen, drawn again at full detail where it is zoomed."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from nicegui import events, ui
from nicegui.element import Element

from testbench.report import style
from testbench.report.packing import PLOTLY_VERSION, plotly_path, to_json

Drawn = Callable[[float | None, float | None], style.Figure]  # start and end in seconds (None: all) to a figure

PLOTLY_URL = f"/plotly-cartesian-{PLOTLY_VERSION}.min.js"
YEAR_S = 365 * 24 * 3600
PATIENCE_S = 10.0  # with a browser that does not say that it has drawn: it may sleep, or look elsewhere


class Picture(Element, component="picture.js"):
    """One figure.

    Parameters
    ----------
    figure : dict
        Of `testbench.report`; its arrays travel packed.
    """

    def __init__(self, figure: style.Figure) -> None:
        super().__init__()
        self.figure = figure
        self.classes("w-full js-plotly-plot")
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
        if now_s - self._sent_s < PATIENCE_S:
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
    from nicegui import app

    app.add_static_file(local_file=plotly_path(), url_path=PLOTLY_URL, max_cache_age=YEAR_S)


def load_plotly() -> None:
    """Have the page fetch it while everything else is still on its way."""
    ui.add_head_html(f'<script id="plotly" async src="{PLOTLY_URL}"></script>')


def plot(figure: style.Figure, caption: str) -> Picture:
    """A figure in a card."""
    with _card(caption):
        return Picture(figure)


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


def zooming_plot(drawn: Drawn, caption: str) -> Picture:
    """A plot over time that is drawn again at full detail for the stretch that is zoomed into."""
    with _card(caption) as below:
        picture = Picture(drawn(None, None))
    with below:
        stretch = _Stretch(picture)

    def zoom(event: events.GenericEventArguments) -> None:
        span = zoomed_span(event.args)
        if span is not None:
            stretch.tell(*span)
            picture.show(drawn(*span))

    picture.on("zoom", zoom)
    return picture


class _Stretch:
    """Fields for the stretch that is looked at: a zoom without a mouse, and to the second."""

    def __init__(self, picture: Picture) -> None:
        self.picture = picture
        with ui.row().classes("items-center gap-2 stretch"):
            self.start = self._field("From / s")
            self.end = self._field("to / s")
            whole = ui.button("All", on_click=lambda: picture.run_method("look", None, None))
            whole.props("flat dense").tooltip("The whole recording")

    def _field(self, label: str) -> ui.number:
        field = ui.number(label, format="%.6g").props("outlined dense").style("width:104px")
        return field.on("keydown.enter", self._look).on("blur", self._look)

    def _look(self) -> None:
        start_s, end_s = self.start.value, self.end.value
        if start_s is not None and end_s is not None and start_s < end_s:
            self.picture.run_method("look", start_s, end_s)

    def tell(self, start_s: float | None, end_s: float | None) -> None:
        """Show the stretch that was chosen with the mouse; None: all."""
        self.start.set_value(start_s)
        self.end.set_value(end_s)


def zoomed_span(change: dict[str, Any]) -> tuple[float | None, float | None] | None:
    """The stretch of time that a zoom asks for; (None, None) for all, None when the zoom was not along time."""
    if change.get("xaxis.autorange"):
        return None, None
    start, end = change.get("xaxis.range[0]"), change.get("xaxis.range[1]")
    if start is None and isinstance(change.get("xaxis.range"), list):
        start, end = change["xaxis.range"]
    if start is None or end is None:
        return None
    return float(start), float(end)
