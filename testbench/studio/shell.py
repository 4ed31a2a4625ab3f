"""The frame around every page: navigation at the side, one page in the middle, addresses that can be shared."""

from __future__ import annotations

from collections.abc import Callable
from importlib.resources import files
from urllib.parse import parse_qs

from nicegui import ui

from gcode.support.colours import BLUE, VERMILION
from testbench.studio.pages import campaigns, effects, importing, investigation, plan, record, side
from testbench.studio.pages.campaign import (
    align,
    compare,
    compensate,
    experiment,
    ladder,
    missing,
    propose,
    recording,
)
from testbench.studio.parts.picture import load_plotly
from testbench.studio.parts.running_jobs import RunningNow
from testbench.studio.parts.widgets import invitation, way_on
from testbench.studio.studio import Studio

PAGES: dict[str, tuple[str, Callable]] = {
    "/": ("Campaigns", campaigns.page),
    "/import": ("Import a file", importing.page),
    "/plan": ("Plan and run", plan.page),
    "/record": ("Record", record.page),
    "/investigation": ("Investigations", investigation.page),
    "/effects": ("Own effects", effects.page),
    "/side": ("Side by side", side.page),
    "/recording": ("Recording", recording.page),
    "/align": ("Plan and recording", align.page),
    "/compare": ("Compare", compare.page),
    "/missing": ("Missing effect", missing.page),
    "/experiment": ("Experiment", experiment.page),
    "/propose": ("Propose a law", propose.page),
    "/ladder": ("Error ladder", ladder.page),
    "/compensate": ("Compensate", compensate.page),
}
NAVIGATION = {
    "/": "grid_view",
    "/import": "upload_file",
    "/plan": "timeline",
    "/record": "sensors",
    "/investigation": "travel_explore",
    "/effects": "functions",
}
# Two rows of knit stitches: the face side of a plain jersey, drawn as the V that everybody knows.
LOGO = (
    '<svg width="30" height="30" viewBox="0 0 30 30" fill="none" stroke-linecap="round" stroke-width="4.4" '
    f'aria-hidden="true"><path stroke="{BLUE}" d="M4 4 L8.5 12 M13 4 L8.5 12 M17 4 L21.5 12 M26 4 L21.5 12"/>'
    f'<path stroke="{VERMILION}" d="M4 15 L8.5 23 M13 15 L8.5 23"/>'
    f'<path stroke="{BLUE}" d="M17 15 L21.5 23 M26 15 L21.5 23"/></svg>'
)


def frame(studio: Studio) -> None:
    """Build the frame for one browser tab."""
    load_plotly()
    ui.add_css(files("testbench.studio").joinpath("theme.css").read_text("utf-8"))
    ui.colors(primary=BLUE, secondary="#5b6875", accent="#b34e00", positive="#00795a", negative="#b03a00")
    for field in (ui.input, ui.number, ui.select, ui.textarea):
        field.default_props("outlined dense")
    with ui.element("div").classes("frame"):
        with ui.element("aside").classes("side"):
            _side(studio)
        with ui.element("div").classes("w-full").style("min-width:0"):
            _Pages({path: page for path, (_, page) in PAGES.items()}, data={"studio": studio}).classes("w-full")


class _Pages(ui.sub_pages):
    """The pages; an address that leads to none of them says so as every other empty page does."""

    def _render_404(self) -> None:
        with (
            ui.column().classes("page gap-4"),
            invitation("No such page", f"Nothing is at {ui.context.client.sub_pages_router.current_path}."),
        ):
            way_on("Campaigns", "grid_view", "/")


def title_of(path: str, query: str) -> str:
    """What the browser's tab says: the page, and the campaign that it is about."""
    about = parse_qs(query).get("c", [""])[0]
    title = PAGES[path][0] if path in PAGES else ""
    return " · ".join(part for part in (about, title, "knitbench") if part)


def _side(studio: Studio) -> None:
    with ui.row().classes("items-center gap-2 no-wrap"):
        ui.html(LOGO, sanitize=False)
        ui.label("knitbench").classes("brand")
    links: dict[str, ui.link] = {}
    with ui.element("nav").classes("nav").props("aria-label='Main'"):
        for path, icon in NAVIGATION.items():
            with ui.link(target=path) as links[path]:
                ui.icon(icon, size="20px")
                ui.label(PAGES[path][0])

    def mark(address: str) -> None:
        here, _, query = address.partition("?")
        ui.page_title(title_of(here, query))
        for path, link in links.items():
            link.classes(add="here" if path == here else "", remove="" if path == here else "here")

    RunningNow(studio)
    router = ui.context.client.sub_pages_router
    mark(router.current_path)
    router.on_path_changed(mark)
    with ui.column().classes("gap-0 where"):
        ui.label("Working in").classes("quiet text-xs")
        ui.label(studio.workspace.root.name or "/").classes("mono").tooltip(str(studio.workspace.root))
