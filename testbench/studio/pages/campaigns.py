"""Campaigns: what is in the folder, intact or not, a thumbnail each."""

from __future__ import annotations

from nicegui import ui

from gcode.support.errors import UserError
from testbench.manifest import IN_PROGRESS
from testbench.report.recording_figures import summary, thumbnail
from testbench.studio.studio import Studio
from testbench.studio.unfinished import is_under_way, is_unfinished
from testbench.studio.widgets import address, aside, guarded, heading, invitation
from testbench.studio.workspace import Campaign


@guarded
async def page(studio: Studio) -> None:
    """Every campaign as a card; thumbnails and checksums follow one after the other."""
    campaigns = await aside(studio.workspace.campaigns)
    count = f"{len(campaigns)} campaign{'s' if len(campaigns) != 1 else ''}"
    heading("Campaigns", f"{count}, the newest first" if campaigns else "")
    if not campaigns:
        _empty()
        return
    with ui.element("div").classes("campaigns"):
        cards = [(campaign, _Card(campaign)) for campaign in campaigns]
    for campaign, card in cards:
        await card.fill(studio, campaign)


def _empty() -> None:
    with invitation("Nothing here yet", "Bring a measured CSV, or plan a motion and run it on the simulated rig."):
        ui.button("Import a CSV", icon="upload_file", on_click=lambda: ui.navigate.to("/import")).props("unelevated")
        ui.button("Plan and run", icon="timeline", on_click=lambda: ui.navigate.to("/plan")).props("outline")


class _Card:
    """One campaign: name and tags at once, picture and checksum when they are known."""

    def __init__(self, campaign: Campaign) -> None:
        with ui.link(target=address("/recording", c=campaign.name)).classes("campaign"):
            with ui.row().classes("items-center justify-between w-full no-wrap"):
                ui.label(campaign.name).style("font-weight:620")
                self.verdict = ui.label("…").classes("tag")
            self.picture = ui.html("", sanitize=False).classes("w-full").style("min-height:64px;margin:8px 0 4px")
            with ui.row().classes("items-center gap-2"):
                if campaign.origin:
                    ui.label(campaign.origin).classes("tag")
                self.state = ui.label().classes("tag bad")
                self.state.set_visibility(False)
                self.facts = ui.label("").classes("quiet text-sm")

    async def fill(self, studio: Studio, campaign: Campaign) -> None:
        """Check and draw; a campaign that cannot be read, or is not what was written, says why."""
        growing = campaign.status == IN_PROGRESS
        self._tell_state(studio, campaign)
        try:
            problems = [] if growing else await aside(studio.workspace.problems, campaign.name)
            if problems:
                self._mark("changed" if campaign.origin else "not ours", "bad", "; ".join(problems))
                return
            recording = await aside(studio.workspace.recording, campaign.name)
            picture = await aside(thumbnail, recording)
        except UserError as error:
            self._mark("unreadable", "bad", str(error))
            return
        if growing:
            self.verdict.set_visibility(False)  # there is nothing to hold its bytes against yet
        else:
            self._mark("verified", "good")
        self.picture.set_content(picture)
        self.facts.set_text(" · ".join(value for _, value in summary(recording)[:1] + summary(recording)[3:4]))

    def _tell_state(self, studio: Studio, campaign: Campaign) -> None:
        if is_under_way(studio, campaign):
            self.state.set_text("recording now")
        elif is_unfinished(campaign):
            self.state.set_text("unfinished")
        elif campaign.status not in ("", "complete"):
            self.state.set_text(campaign.status)
        self.state.set_visibility(bool(self.state.text))

    def _mark(self, text: str, kind: str, why: str = "") -> None:
        self.verdict.set_text(text)
        self.verdict.classes(add=kind)
        if why:
            self.verdict.tooltip(why)
            self.facts.set_text(why[:140])
