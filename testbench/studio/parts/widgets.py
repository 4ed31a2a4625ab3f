"""Pieces that several pages use: headings, facts, tables, troubles, tabs of a campaign."""

from __future__ import annotations

import asyncio
import contextlib
import functools
import inspect
import json
import logging
from collections.abc import Awaitable, Callable, Iterator, Sequence
from html import escape
from pathlib import Path
from typing import Any, TypeVar

from nicegui import Client, ui

from gcode.support import html
from gcode.support.errors import UserError
from testbench.studio.parts.address import Address, address
from testbench.studio.studio import Studio

T = TypeVar("T")

LOG = logging.getLogger("knitbench")
DEFECT = "This is a defect of the studio; its terminal shows where it happened."
LATER_S = 0.3
TABS = (
    ("/recording", "Recording"),
    ("/compare", "Compare"),
    ("/missing", "Missing effect"),
    ("/ladder", "Error ladder"),
    ("/compensate", "Compensate"),
)


def guarded(page: Callable) -> Callable:
    """Show a `UserError` of a page in its place: errors are read, not thrown."""

    @functools.wraps(page)
    async def build(*args: Any, **kwargs: Any) -> None:
        with ui.column().classes("page gap-4"):
            _ask_before_running(kwargs.get("studio") or args[0])
            await _built(lambda: page(*args, **kwargs))

    return build


async def _built(build: Callable[[], Any]) -> None:
    """Build a page or a part of it; what goes wrong is said where it would stand."""
    try:
        result = build()
        if inspect.isawaitable(result):
            await result
    except UserError as error:
        trouble(str(error))
    except Exception as error:
        LOG.exception("a page could not be built")
        trouble(f"This page could not be built: {_told(error)}.", DEFECT)


def _told(error: Exception) -> str:
    return f"{type(error).__name__}: {error}".removesuffix(": ").removesuffix(".")


def _ask_before_running(studio: Studio) -> None:
    """Own effects are code, and a workspace may be somebody else's: ask before it is run."""
    path = studio.effects.file
    if path is None or studio.effects.runnable is not None:
        return

    def agree() -> None:
        studio.effects.agree()
        ui.navigate.reload()

    with ui.column().classes("trouble gap-2").props("role=alert"):
        ui.label(f"This workspace brings its own effects: {path}. They are Python code and have not been run.")
        ui.label("Run them only if you know where they come from.").classes("text-sm")
        with ui.row():
            way_on("Look at the code", "code", "/effects", "outline")
            button("Run it", "play_arrow", agree, "unelevated color=accent")


async def aside(function: Callable[..., T], *arguments: Any) -> T:
    """Work in a thread, so that the other tabs stay alive meanwhile.

    Where the place on the page that waits for it is gone by then, whoever waits is cancelled.
    """
    place = ui.context.slot.parent
    try:
        return await asyncio.to_thread(function, *arguments)
    finally:
        if place.is_deleted:
            raise asyncio.CancelledError


async def attempt(action: Callable[[], Any]) -> Any:
    """Do something on a click; a `UserError` becomes a message at the screen's edge, were the button gone by then."""
    tab = ui.context.client
    try:
        result = action()
        return await result if inspect.isawaitable(result) else result
    except UserError as error:
        _notify(tab, str(error))
    except Exception as error:
        LOG.exception("a click could not be followed")
        _notify(tab, f"This could not be done: {_told(error)}. {DEFECT}")
    return None


def _notify(tab: Client, text: str) -> None:
    with tab:
        ui.notify(text, type="warning", position="top", multi_line=True, close_button="OK", timeout=12_000)


def button(title: str, icon: str, action: Callable[[], Any], look: str = "unelevated") -> ui.button:
    """A button that does something; see `attempt`."""
    return ui.button(title, icon=icon or None, on_click=lambda: attempt(action)).props(look)


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


def download_button(title: str, path: Path, name: str | None = None, look: str = "outline") -> None:
    """A button that hands out a file, as `name` where that is another; of one that is gone a browser says nothing."""

    def download() -> None:
        if not path.is_file():
            raise UserError(f"{path}: this file is gone, so it cannot be downloaded; bring it back, or make it again")
        ui.download(path, name)

    button(title, "download", download, look)


def way_on(title: str, icon: str, url: str, look: str = "unelevated") -> None:
    """A button that leads to another page."""
    button(title, icon, lambda: ui.navigate.to(url), look)


def heading(title: str, under: str = "") -> None:
    """The page's title and a line under it."""
    _headed("h1", title, under, "gap-1", "quiet")


def subheading(title: str, under: str = "") -> None:
    """A heading inside a page."""
    _headed("h2", title, under, "gap-0", "quiet text-sm")


def _headed(tag: str, title: str, under: str, gap: str, quiet: str) -> None:
    with ui.column().classes(gap):
        ui.html(f"<{tag}>{escape(title)}</{tag}>", sanitize=False)
        if under:
            ui.label(under).classes(quiet)


def facts(pairs: Sequence[tuple[str, str]]) -> None:
    """A few values at a glance."""
    cells = "".join(
        f'<div class="fact"><b>{escape(value)}</b><span>{escape(name)}</span></div>' for name, value in pairs
    )
    ui.html(f'<div class="facts">{cells}</div>', sanitize=False).classes("w-full")


KOHM = "resistance"  # what an address shows, and what figures call it: the resistance in kΩ
CONDUCTANCE_OR = {"": "Conductance", KOHM: "Resistance in kΩ"}


def quantity_toggle(where: Address) -> None:
    """Conductance or resistance: the choice is in the address and goes along from tab to tab."""
    shown = where.query.get("show", "")
    toggle = ui.toggle(CONDUCTANCE_OR, value=shown if shown in CONDUCTANCE_OR else "", clearable=False)
    toggle.props("no-caps dense unelevated aria-label='Conductance or resistance'").classes("quantity")
    toggle.on_value_change(lambda event: where.go(show=event.value))


def table(head: Sequence[str], rows: Sequence[Sequence[str]], caption: str = "") -> None:
    """A table of text; it scrolls by itself where the screen is narrow."""
    shown = ui.html(html.table(head, rows, caption), sanitize=False, tag="div")
    shown.classes("table wide" if len(head) > 3 else "table").props("tabindex=0")


def campaign_head(studio: Studio, name: str, here: str, show: str = "") -> None:
    """Title and tabs of one campaign; each tab is a deep link.

    Raises
    ------
    UserError
        Below them, where there is no such campaign (any more).
    """
    with ui.row().classes("crumbs gap-2"):
        ui.link("Campaigns", "/").classes("quiet")
        ui.icon("chevron_right").classes("quiet")
        ui.html(f"<h1>{escape(name)}</h1>", sanitize=False)
    with ui.element("nav").classes("tabs").props("aria-label='Steps'"):
        for path, title in TABS:
            link = ui.link(title, address(path, c=name, show=show))
            if path == here:
                link.classes("here").props("aria-current=page")
    ui.run_javascript("document.querySelector('.tabs .here')?.scrollIntoView({block: 'nearest', inline: 'center'})")
    studio.workspace.campaign(name)


def later(build: Callable[[], Awaitable[None] | None]) -> None:
    """Build what is below the first screen a moment later, so that the first screen is there at once."""
    holder = ui.column().classes("w-full gap-4")

    async def fill() -> None:
        with holder:
            await _built(build)

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
