"""Pieces that several pages use: headings, facts, troubles, tabs of a campaign, running jobs."""

from __future__ import annotations

import asyncio
import contextlib
import functools
import inspect
import json
from collections.abc import Awaitable, Callable, Iterator, Sequence
from typing import Any, TypeVar
from urllib.parse import urlencode

from nicegui import ui

from gcode.support.errors import UserError
from testbench.comparing.numbers import plain
from testbench.studio.jobs import Job, State
from testbench.studio.pace import duration_in_words
from testbench.studio.studio import Studio

T = TypeVar("T")

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


class Address:
    """The address of a page: every choice on it is kept there, so that it can be shared and gone back to.

    Parameters
    ----------
    path : str
    **query : str
        What is chosen now.
    """

    def __init__(self, path: str, **query: str) -> None:
        self.path, self.query = path, dict(query)

    def note(self, **chosen: str) -> None:
        """Put what was chosen into the address, without leaving the page."""
        self.query |= chosen
        ui.navigate.history.replace(self.with_())

    def note_span(self, span: tuple[float | None, float | None]) -> None:
        """Keep the stretch of time that is looked at."""
        self.note(**dict(zip(("start", "end"), ("" if end is None else f"{end:.2f}" for end in span), strict=True)))

    def with_(self, **chosen: str) -> str:
        """The address with something else chosen."""
        return address(self.path, **(self.query | chosen))

    def go(self, **chosen: str) -> None:
        """Open it with something else chosen."""
        ui.navigate.to(self.with_(**chosen))


def span_of(start: str, end: str) -> tuple[float | None, float | None]:
    """The stretch of time in an address.

    Raises
    ------
    UserError
        If it is no stretch.
    """
    if not start and not end:
        return None, None
    try:
        start_s, end_s = float(start), float(end)
    except ValueError:
        raise UserError(f"the address asks for times from {start!r} to {end!r}; both must be seconds") from None
    if not start_s < end_s:
        raise UserError(
            f"the address asks for times from {start_s:g} to {end_s:g} s; the end must come after the start"
        )
    return start_s, end_s


def guarded(page: Callable) -> Callable:
    """Show a `UserError` of a page in its place: errors are read, not thrown."""

    @functools.wraps(page)
    async def build(*args: Any, **kwargs: Any) -> None:
        with ui.column().classes("page gap-4"):
            _ask_before_running(kwargs.get("studio") or args[0])
            try:
                result = page(*args, **kwargs)
                if inspect.isawaitable(result):
                    await result
            except UserError as error:
                trouble(str(error))

    return build


def _ask_before_running(studio: Studio) -> None:
    """Own effects are code, and a workspace may be somebody else's: ask before it is run."""
    path = studio.effects_file
    if path is None or studio.runnable_effects is not None:
        return

    def agree() -> None:
        studio.agree_to_effects()
        ui.navigate.reload()

    with ui.column().classes("trouble gap-2").props("role=alert"):
        ui.label(f"This workspace brings its own effects: {path}. They are Python code and have not been run.")
        ui.label("Run them only if you know where they come from.").classes("text-sm")
        with ui.row():
            ui.button("Look at the code", icon="code", on_click=lambda: ui.navigate.to("/effects")).props("outline")
            ui.button("Run it", icon="play_arrow", on_click=agree).props("unelevated color=accent")


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


@contextlib.contextmanager
def invitation(title: str, text: str) -> Iterator[None]:
    """What an empty page says: what is missing, and the buttons that bring it."""
    with ui.column().classes("card items-center gap-3").style("padding:44px 20px"):
        ui.label(title).classes("verdict")
        ui.label(text).classes("quiet")
        with ui.row():
            yield


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


RESISTANCE = "resistance"
CONDUCTANCE_OR = {"": "Conductance", RESISTANCE: "Resistance in kΩ"}


def quantity_toggle(where: Address) -> None:
    """Conductance or resistance: the choice is in the address and goes along from tab to tab."""
    toggle = ui.toggle(CONDUCTANCE_OR, value=where.query.get("show", ""), clearable=False)
    toggle.props("no-caps dense unelevated aria-label='Conductance or resistance'").classes("quantity")
    toggle.on_value_change(lambda event: where.go(show=event.value))


def table(head: Sequence[str], rows: Sequence[Sequence[str]], caption: str = "") -> None:
    """A table of text; it scrolls by itself where the screen is narrow."""
    names = "".join(f"<th scope='col'>{_text(name)}</th>" for name in head)
    body = "".join("<tr>" + "".join(f"<td>{_text(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    under = f"<caption>{_text(caption)}</caption>" if caption else ""
    ui.html(
        f"<table>{under}<thead><tr>{names}</tr></thead><tbody>{body}</tbody></table>", sanitize=False, tag="div"
    ).classes("table wide" if len(head) > 3 else "table").props("tabindex=0")


def campaign_head(name: str, here: str, show: str = "") -> None:
    """Title and tabs of one campaign; each tab is a deep link."""
    with ui.row().classes("crumbs gap-2"):
        ui.link("Campaigns", "/").classes("quiet")
        ui.icon("chevron_right").classes("quiet")
        ui.html(f"<h1>{_text(name)}</h1>", sanitize=False)
    with ui.element("nav").classes("tabs").props("aria-label='Steps'"):
        for path, title in TABS:
            link = ui.link(title, address(path, c=name, show=show))
            if path == here:
                link.classes("here").props("aria-current=page")
    ui.run_javascript("document.querySelector('.tabs .here')?.scrollIntoView({block: 'nearest', inline: 'center'})")


def later(build: Callable[[], Awaitable[None] | None]) -> None:
    """Build what is below the first screen a moment later, so that the first screen is there at once."""
    holder = ui.column().classes("w-full gap-4")

    async def fill() -> None:
        with holder:
            result = build()
            if inspect.isawaitable(result):
                await result

    ui.timer(LATER_S, fill, once=True)


def name_in_page(selector: str, name: str) -> None:
    """Give a part that its component leaves nameless a name for screen readers, as soon as it is there."""
    ui.run_javascript(
        f"const named = () => {{ const parts = document.querySelectorAll({json.dumps(selector)});"
        f" parts.forEach(e => e.ariaLabel = {json.dumps(name)}); return parts.length; }};"
        " if (!named()) { const waiting = new MutationObserver(() => named() && waiting.disconnect());"
        " waiting.observe(document.body, { childList: true, subtree: true }); }"
    )


@contextlib.contextmanager
def working(what: str) -> Iterator[None]:
    """Say what is being done while the work below it goes on."""
    with ui.row().classes("items-center gap-2 quiet").props("role=status") as sign:
        ui.spinner(size="20px")
        ui.label(f"{what} …")
    try:
        yield
    finally:
        with contextlib.suppress(ValueError):  # the page was left meanwhile, and is gone with all that was on it
            sign.delete()


def job_card(studio: Studio, job: Job, on_end: Callable[[Job], Awaitable[None] | None] | None = None) -> None:
    """A job with its progress, its command and a stop; `on_end` is called once in this tab when it has ended."""
    _JobCard(studio, job, on_end)


class _JobCard:
    """What is seen of a job in one tab."""

    def __init__(self, studio: Studio, job: Job, on_end: Callable[[Job], Awaitable[None] | None] | None) -> None:
        self.job, self.on_end, self.drawn = job, on_end, 0
        with ui.column().classes("card gap-2").props("role=status"):
            with ui.row().classes("items-center justify-between w-full no-wrap"):
                self.title = ui.label(job.title).style("font-weight:600")
                self.stop = ui.button("Stop", icon="stop", on_click=lambda: studio.jobs.cancel(job))
                self.stop.props("outline color=accent")
            self.bar = ui.linear_progress(show_value=False).props("rounded size=8px instant-feedback")
            self.bar.props(f"aria-label={json.dumps('Progress: ' + job.title)}")
            self.note = ui.label().classes("quiet text-sm")
            self.curve = ui.html("", sanitize=False).classes("curve")
            ui.label(job.command).classes("mono")
            self.problem = ui.label().classes("text-sm").style("color:#9a4300")
            self.timer = ui.timer(0.2, self._look)

    async def _look(self) -> None:
        if self.job.running:
            self._tell()
            return
        self.timer.deactivate()
        for gone in (self.stop, self.bar):
            gone.set_visibility(False)
        self.note.set_text(f"{self.job.state.value} after {self.job.elapsed_s:.1f} s")
        self.problem.set_text(self.job.problem if self.job.state is State.FAILED else "")
        result = self.on_end(self.job) if self.on_end else None
        if inspect.isawaitable(result):
            await result

    def _tell(self) -> None:
        job = self.job
        self.note.set_text(progress_in_words(job))
        share = job.pace.done(job.elapsed_s) if job.pace.marks or job.pace.profile else job.share
        self.bar.props(remove="indeterminate") if share is not None else self.bar.props("indeterminate")
        self.bar.set_value(share or 0.0)
        if len(job.pace.scores) > max(self.drawn, 1):
            self.drawn = len(job.pace.scores)
            self.curve.set_content(spark_line(job.pace.score_name, job.pace.scores))


def progress_in_words(job: Job) -> str:
    """``motion 7 of 13 · 40 s so far, about 35 s left · imitating on long hold``."""
    left_s = job.pace.left_s(job.elapsed_s)
    time = f"{job.elapsed_s:.0f} s so far"
    if left_s is not None:
        time += f", {duration_in_words(left_s)} left"
    return " · ".join(part for part in (job.step, time, job.note) if part)


def spark_line(name: str, values: Sequence[float]) -> str:
    """A small curve of how a fit or a training gets on, as SVG."""
    width, height = 260, 46
    low, high = min(values), max(values)
    step = width / max(len(values) - 1, 1)
    points = " ".join(
        f"{i * step:.1f},{height - 3 - (value - low) / ((high - low) or 1.0) * (height - 6):.1f}"
        for i, value in enumerate(values)
    )
    words = f"{name} {plain(values[0])} → {plain(values[-1])}"
    return (
        f'<svg viewBox="0 0 {width} {height}" width="{width}" height="{height}" role="img" '
        f'aria-label="{_text(words)}">'
        f'<polyline points="{points}" fill="none" stroke="#0072B2" stroke-width="1.6"/></svg>'
        f'<span class="quiet text-sm">{_text(words)}</span>'
    )
