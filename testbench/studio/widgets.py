"""Pieces that several pages use: headings, facts, troubles, tabs of a campaign, zooming plots, running jobs."""

from __future__ import annotations

import asyncio
import functools
import inspect
from collections.abc import Awaitable, Callable, Sequence
from typing import Any, TypeVar
from urllib.parse import urlencode

import numpy as np
from nicegui import events, ui

from gcode.support.errors import UserError
from testbench.report import style
from testbench.studio.jobs import Job, State
from testbench.studio.studio import Studio

T = TypeVar("T")
Drawn = Callable[[float | None, float | None], style.Figure]

LATER_S = 0.3
TABS = (
    ("/recording", "Recording"),
    ("/compare", "Compare"),
    ("/missing", "Missing effect"),
    ("/ladder", "Error ladder"),
    ("/compensate", "Compensate"),
)


def address(path: str, **query: str | None) -> str:
    """A deep link."""
    given = {key: value for key, value in query.items() if value}
    return f"{path}?{urlencode(given)}" if given else path


def guarded(page: Callable) -> Callable:
    """Show a `UserError` of a page in its place: errors are read, not thrown."""

    @functools.wraps(page)
    async def build(*args: Any, **kwargs: Any) -> None:
        with ui.column().classes("page gap-4"):
            try:
                result = page(*args, **kwargs)
                if inspect.isawaitable(result):
                    await result
            except UserError as error:
                trouble(str(error))

    return build


async def aside(function: Callable[..., T], *arguments: Any) -> T:
    """Work in a thread, so that the other tabs stay alive meanwhile."""
    return await asyncio.to_thread(function, *arguments)


async def attempt(action: Callable[[], Any]) -> Any:
    """Do something on a click; a `UserError` becomes a message at the screen's edge."""
    try:
        result = action()
        return await result if inspect.isawaitable(result) else result
    except UserError as error:
        ui.notify(str(error), type="warning", position="top", multi_line=True, close_button="OK", timeout=12_000)
        return None


def trouble(text: str, remedy: str = "") -> None:
    """An error in the page, in words."""
    with ui.row().classes("trouble items-start no-wrap").props("role=alert"):
        ui.icon("error_outline", size="22px")
        with ui.column().classes("gap-1"):
            ui.label(text)
            if remedy:
                ui.label(remedy).classes("text-sm")


def heading(title: str, under: str = "") -> None:
    """The page's title and a line under it."""
    with ui.column().classes("gap-1"):
        ui.html(f"<h1>{_text(title)}</h1>", sanitize=False)
        if under:
            ui.label(under).classes("quiet")


def _text(text: str) -> str:
    from html import escape

    return escape(text)


def subheading(title: str, under: str = "") -> None:
    """A heading inside a page."""
    with ui.column().classes("gap-0"):
        ui.html(f"<h2>{_text(title)}</h2>", sanitize=False)
        if under:
            ui.label(under).classes("quiet text-sm")


def facts(pairs: Sequence[tuple[str, str]]) -> None:
    """A few values at a glance."""
    cells = "".join(
        f'<div class="fact"><b>{_text(value)}</b><span>{_text(name)}</span></div>' for name, value in pairs
    )
    ui.html(f'<div class="facts">{cells}</div>', sanitize=False).classes("w-full")


def campaign_head(name: str, here: str) -> None:
    """Title and tabs of one campaign; each tab is a deep link."""
    with ui.row().classes("items-center gap-2"):
        ui.link("Campaigns", "/").classes("quiet")
        ui.icon("chevron_right").classes("quiet")
        ui.html(f"<h1>{_text(name)}</h1>", sanitize=False)
    with ui.element("nav").classes("tabs").props("aria-label='Steps'"):
        for path, title in TABS:
            link = ui.link(title, address(path, c=name))
            if path == here:
                link.classes("here").props("aria-current=page")


def plot(figure: style.Figure, caption: str = "") -> ui.plotly:
    """A figure in a card."""
    with ui.element("figure").classes("card").style("margin:0"):
        element = ui.plotly(float32({**figure, "config": style.CONFIG})).classes("w-full")
        element.style(f"height:{figure['layout']['height']}px")
        if caption:
            ui.label(caption).classes("quiet text-sm")
    return element


def redraw(element: ui.plotly, figure: style.Figure) -> None:
    """Put another figure in a plot's place."""
    element.style(f"height:{figure['layout']['height']}px")
    element.update_figure(float32({**figure, "config": style.CONFIG}))


def float32(value: Any) -> Any:
    """A figure with its arrays in single precision: half the bytes, and no digit lost that a pixel shows."""
    if isinstance(value, dict):
        return {key: float32(entry) for key, entry in value.items()}
    if isinstance(value, list):
        return [float32(entry) for entry in value]
    if isinstance(value, np.ndarray) and value.dtype == np.float64:
        return np.ascontiguousarray(value, dtype=np.float32)
    return value


def later(build: Callable[[], None]) -> None:
    """Build what is below the first screen a moment later, so that the first screen is there at once."""
    holder = ui.column().classes("w-full gap-4")

    def fill() -> None:
        with holder:
            build()

    ui.timer(LATER_S, fill, once=True)


def zooming_plot(drawn: Drawn, caption: str = "") -> ui.plotly:
    """A plot over time that is drawn again at full detail for the stretch that is zoomed into.

    Parameters
    ----------
    drawn : callable
        Start and end in seconds (None: all) to a figure.
    """
    element = plot(drawn(None, None), caption)

    def relayout(event: events.GenericEventArguments) -> None:
        span = zoomed_span(event.args)
        if span is not None:
            redraw(element, drawn(*span))

    element.on("plotly_relayout", relayout)
    return element


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


def job_card(studio: Studio, job: Job, on_end: Callable[[Job], Awaitable[None] | None] | None = None) -> None:
    """A job with its progress, its command and a stop; `on_end` is called once in this tab when it has ended."""
    with ui.column().classes("card gap-2") as card:
        with ui.row().classes("items-center justify-between w-full no-wrap"):
            title = ui.label(job.title).style("font-weight:600")
            stop = ui.button("Stop", icon="stop", on_click=lambda: studio.jobs.cancel(job)).props(
                "outline color=accent"
            )
        bar = ui.linear_progress(show_value=False).props("rounded size=8px")
        note = ui.label().classes("quiet text-sm")
        ui.label(job.command).classes("mono")
        problem = ui.label().classes("text-sm").style("color:#9a4300")
    seen = {"version": -1}

    async def look() -> None:
        if job.running:
            said = job.note or (job.errors[-1] if job.errors else "")
            note.set_text(" · ".join(part for part in (f"{job.elapsed_s:.0f} s", said) if part))
        if job.version == seen["version"] and job.running:
            return
        seen["version"] = job.version
        bar.props(remove="indeterminate") if job.share is not None else bar.props("indeterminate")
        bar.set_value(job.share or 0.0)
        if job.running:
            return
        timer.deactivate()
        stop.set_visibility(False)
        bar.set_visibility(False)
        note.set_text(f"{job.state.value} after {job.elapsed_s:.1f} s")
        problem.set_text(job.problem if job.state is State.FAILED else "")
        title.set_text(job.title)
        result = on_end(job) if on_end else None
        if inspect.isawaitable(result):
            await result

    timer = ui.timer(0.2, look)
    card.props("role=status")
