"""What is running now, on every page: how far it is, where it is looked at, and its end within reach."""

from __future__ import annotations

import json
from pathlib import Path

from nicegui import ui

from testbench.studio.jobs.job import Job
from testbench.studio.parts.address import address
from testbench.studio.parts.job_card import progress_in_words
from testbench.studio.studio import WITH_TARGET, Studio, campaign_of

REFRESHED_S = 1.0
PLACES = {
    "model": "/ladder",
    "diagnose": "/missing",
    "experiment": "/experiment",
    "propose": "/propose",
    "report": "/ladder",
    "train": "/compensate",
    "export": "/compensate",
    "align": "/align",
    "record": "/record",
    "run": "/plan",
}
WITHOUT_CAMPAIGN = {"plan": "/plan", "rig": "/record", "import": "/import", "effects": "/effects"}


class RunningNow:
    """Every job under way, whichever page or tab has started it, as one tab lists them."""

    def __init__(self, studio: Studio) -> None:
        self.studio = studio
        self.shown: list[Job] = []
        self.words: list[tuple[Job, ui.label]] = []
        self.holder = ui.column().classes("running gap-1").props("role=region aria-label='Running now'")
        self._build()
        self._look()
        ui.timer(REFRESHED_S, self._look)

    def _look(self) -> None:
        running = self.studio.jobs.running()
        if running != self.shown:
            self.shown = running
            self._build()
        for job, words in self.words:
            words.set_text(progress_in_words(job))

    def _build(self) -> None:
        self.words = []
        self.holder.clear()
        self.holder.set_visibility(bool(self.shown))
        with self.holder:
            ui.label("Running now").classes("quiet text-xs")
            for job in self.shown:
                self._line(job)

    def _line(self, job: Job) -> None:
        with ui.row().classes("items-center w-full no-wrap gap-1"):
            with ui.column().classes("grow gap-0"):
                if where := place_of(job):
                    ui.link(job.title, where).classes("text-sm")
                else:
                    ui.label(job.title).classes("text-sm")
                self.words.append((job, ui.label().classes("quiet text-xs")))
            end = ui.button(icon="stop", on_click=lambda: self.studio.jobs.cancel(job))
            end.props(f"flat dense round size=sm color=accent aria-label={json.dumps('End: ' + job.title)}")


def place_of(job: Job) -> str:
    """The page on which a job is looked at; empty where it has none of its own."""
    kind, campaign = job.key.partition(":")[0], campaign_of(job.key)
    if kind not in PLACES:
        return WITHOUT_CAMPAIGN.get(kind, "")
    if kind == "run":
        return address(PLACES[kind], program=Path(job.argv[job.argv.index("--program") + 1]).parent.name)
    target = job.key.rpartition(":")[2] if kind in WITH_TARGET else ""
    return address(PLACES[kind], c=campaign, target=target)
