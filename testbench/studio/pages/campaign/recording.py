"""One recording: facts, every channel over time, loops, distributions."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from functools import partial
from typing import Any

from nicegui import ui

from gcode.support.errors import UserError
from gcode.support.strict import read_text
from testbench.comparing.words import spoken
from testbench.recordings.channels import RESISTANCE
from testbench.recordings.manifest import CSV, IN_PROGRESS, read_manifest
from testbench.recordings.recording import Recording
from testbench.report.figures import recording_figures as figures
from testbench.report.provenance import moment
from testbench.studio.models import has_model, judged_on
from testbench.studio.pages.campaign.align import program_of
from testbench.studio.pages.campaign.compare import view_of
from testbench.studio.parts.address import Address, address, span_of
from testbench.studio.parts.picture import ZoomingPlot, plot
from testbench.studio.parts.unfinished import is_under_way, is_unfinished, under_way_card, unfinished_card
from testbench.studio.parts.widgets import (
    KOHM,
    aside,
    campaign_head,
    download_button,
    facts,
    guarded,
    later,
    quantity_toggle,
    table,
    trouble,
    way_on,
)
from testbench.studio.studio import Studio
from testbench.studio.workspace import Campaign


@guarded
async def page(studio: Studio, c: str = "", show: str = "", start: str = "", end: str = "") -> None:
    """The recording of campaign `c`."""
    campaign_head(studio, c, "/recording", show)
    where = Address("/recording", c=c, show=show, start=start, end=end)
    campaign = studio.workspace.campaign(c)
    if is_under_way(studio, campaign):
        under_way_card()
    elif is_unfinished(campaign):
        unfinished_card(studio, campaign)
    problems = [] if campaign.status == IN_PROGRESS else await aside(studio.workspace.problems, c)
    if problems:
        remedy = "Restore the file from a copy, or import it as a foreign CSV if you changed it on purpose."
        trouble("This campaign does not agree with its manifest: " + "; ".join(problems), remedy)
        return
    recording = await aside(studio.workspace.recording, c)
    kohm = show == KOHM
    facts(figures.summary(recording, kohm))
    if recording.has(RESISTANCE):
        quantity_toggle(where)
    caption = "Drag to zoom; double-click to see all again. A zoom draws every sample of its stretch."
    drawn = partial(figures.time_series, recording, resistance=kohm)
    ZoomingPlot(drawn, caption, recording.time_s, span_of(start, end), where.note_span)
    later(partial(_below, studio, campaign, recording, kohm))
    later(partial(_origin, studio, campaign))
    later(partial(_prepare, studio, c))


def _below(studio: Studio, campaign: Campaign, recording: Recording, kohm: bool) -> None:
    loops = figures.hysteresis_loops(recording, kohm)
    if loops:
        plot(loops, figures.loops_caption(recording))
    shares = figures.distributions(recording, kohm)
    if shares:
        plot(shares, figures.distributions_caption(recording))
    with ui.row():
        download_button("Download CSV", campaign.folder / CSV, f"{campaign.folder.name}.csv")
        if program_of(studio, campaign.name).is_file():
            way_on("Compare with the plan", "compare_arrows", address("/align", c=campaign.name), "outline")


def _origin(studio: Studio, campaign: Campaign) -> None:
    """Where it came from: recipe, counts, software, files with their checksums, and what was run."""
    try:
        made, resources = read_manifest(campaign.folder)
    except UserError:
        return
    rows = [("Origin", made.origin), ("Ended", made.status), ("Manifest written", moment(campaign.made_s))]
    rows += [*_flat("Recipe", made.recipe), *_flat("Counts", made.counts), *_flat("Software", made.versions)]
    files = [(one.path, (one.hash or "").removeprefix("sha256:")) for one in resources]
    with ui.expansion("Where it comes from", icon="history_edu").classes("card").style("padding:0"):
        table(("", ""), rows)
        table(("File", "SHA-256"), files)
        path = studio.commands_path(campaign.name)
        if path.is_file():
            ui.label(read_text(path, "list of commands", 1 << 20)).classes("formula")


def _flat(title: str, values: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Plain values of a mapping; what is nested is in the manifest."""
    return [
        (f"{title}: {spoken(name)}", str(value))
        for name, value in values.items()
        if isinstance(value, str | int | float) and value != ""
    ]


async def _prepare(studio: Studio, c: str) -> None:
    """Work the comparison out while the recording is looked at: it is what comes next."""
    if has_model(studio, c):
        with contextlib.suppress(UserError):  # the page of the comparison will say it
            await aside(view_of, studio, c, judged_on(studio, c))
