"""The recording under way: figures that count, a plot that follows, a stop that is always within reach."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from nicegui import ui

from gcode.support.errors import UserError
from testbench.recordings.channels import DISPLACEMENT, FORCE, RESISTANCE, TIME
from testbench.recordings.manifest import CSV, read_manifest
from testbench.report import style
from testbench.report.figures.live_figures import LiveChannel, live
from testbench.studio.following import Follower
from testbench.studio.jobs.job import Job, State
from testbench.studio.parts.address import address
from testbench.studio.parts.picture import plot
from testbench.studio.parts.unfinished import is_unfinished, resume
from testbench.studio.parts.widgets import aside, button, trouble, way_on
from testbench.studio.studio import KEY_RIG, Studio
from testbench.studio.workspace import MANIFEST

REFRESH_S = 0.5
CAPTION = "Left: the last minute, every sample. Right: all so far. Dashed: your limits."
BESIDE = " Orange-red: what the compensator makes of the resistance alone."
ENDS = {
    "cancelled": "stopped by you before it began",
    "interrupted": "stopped by you, every sample is on disk",
    "alarm": "stopped by a limit",
}


class Live:
    """A recording job in one tab."""

    def __init__(self, studio: Studio, job: Job) -> None:
        from testbench.rig.acquisition.sink import COMPENSATED

        self.studio, self.job = studio, job
        self.folder = Path(job.argv[-1])
        self.follower = Follower(self.folder / CSV)
        self.compensated = Follower(self.folder / COMPENSATED)
        self.limits: dict[str, float] | None = None
        self.due = False  # samples have come that the plot does not show yet
        with ui.column().classes("card gap-2").style("position:sticky;top:8px;z-index:5"):
            with ui.row().classes("items-center justify-between w-full no-wrap"):
                self.facts = ui.html("", sanitize=False).classes("grow")
                self.stop = button("Stop", "stop", self._stop, "unelevated color=accent size=lg")
            self.bar = ui.linear_progress(value=0, show_value=False).props("rounded size=8px")
            self.bar.props("aria-label='Share of the program that is recorded'")
        self.news = ui.label().classes("trouble").props("role=alert")
        self.news.set_visibility(False)
        self.end = ui.column().classes("w-full")
        beside = BESIDE if any(word.startswith("--compensator=") for word in job.argv) else ""
        with ui.column().classes("w-full") as self.below:
            self.plot = plot(live([]), CAPTION + beside)
        self.below.set_visibility(False)  # until there is a sample
        self.timer = ui.timer(REFRESH_S, self._look)

    async def _stop(self) -> None:
        self.stop.disable()
        self.stop.set_text("Stopping …")
        await self.studio.jobs.cancel(self.job)
        await self._stop_rig()

    async def _stop_rig(self) -> None:
        """End the simulated rig, which would play on to nobody."""
        rig = self.studio.jobs.find(KEY_RIG)
        if rig:
            await self.studio.jobs.cancel(rig)

    async def _look(self) -> None:
        over = self.job.ended_s is not None  # asked before the look, so that the last look sees all
        self.due = await aside(self.follower.look) or self.due
        self.due = await aside(self.compensated.look) or self.due
        self.facts.set_content(facts_in_words(self.job.latest))
        self.bar.set_value(self.job.share or 0.0)
        said = str(self.job.latest.get("message") or "")
        self.news.set_text(said)
        self.news.set_visibility(bool(said) and not over)
        self.below.set_visibility(self.follower.envelope is not None)
        if self.due and self.plot.follow(live(self._channels())):
            self.due = False
        if over:
            await self._ended()

    def _channels(self) -> list[LiveChannel]:
        if self.limits is None:
            self.limits = limits_of(self.folder)
        found = []
        for name, title, factor, colour in (
            (DISPLACEMENT, "Displacement (mm)", 1.0, style.STRAIN),
            (FORCE, "Force (N)", 1.0, style.FORCE),
            (RESISTANCE, "Resistance (kΩ)", 1e-3, style.CONDUCTANCE),
        ):
            if one := channel_of(self.follower, name, title, factor, colour):
                words = f"Compensated {title[0].lower()}{title[1:]}"
                beside = channel_of(self.compensated, name, words, factor, style.VERMILION)
                found.append(replace(one, limit=self.limits.get(name), beside=beside))
        return found

    async def _ended(self) -> None:
        self.timer.deactivate()
        if self.follower.envelope is not None:
            self.plot.show(live(self._channels()))
        self.stop.set_visibility(False)
        if "samples" not in self.job.latest:
            self.facts.set_content('<span class="quiet">nothing was recorded</span>')
        said = str(self.job.latest.get("message") or "")
        state = str(self.job.latest.get("state") or self.job.state.value)
        failed, kept = self.job.state is State.FAILED, self.follower.path.is_file()
        with self.end:
            if failed:
                trouble(said or self.job.problem, "Every sample up to that moment is on disk." if kept else "")
            else:
                ui.label(f"{self.job.title}: {ENDS.get(state, state)}. {said}").classes("verdict")
            with ui.row():
                more = self._ways_on()
                button("Record another", "edit", ui.navigate.reload, "outline")
        if failed and not more:
            await self._stop_rig()

    def _ways_on(self) -> bool:
        """The ways to what was recorded; whether it may be gone on with."""
        if not (self.folder / MANIFEST).is_file():
            return False
        name = self.studio.workspace.name_of(self.folder)
        way_on("Open the recording", "", address("/recording", c=name))
        campaign = self.studio.workspace.campaign(name)
        if more := is_unfinished(campaign):
            again = partial(resume, self.studio, campaign, go=lambda _: ui.navigate.reload())
            button("Resume", "fiber_manual_record", again, "outline")
        return more


def channel_of(follower: Follower, name: str, title: str, factor: float, colour: str) -> LiveChannel | None:
    """A channel of a file that grows, as the figure wants it; None where the file does not have it (yet)."""
    time_s, values, envelope = follower.channel(TIME), follower.channel(name), follower.envelope
    if time_s is None or values is None or envelope is None:
        return None
    whole_s, outline = envelope.outline(follower.names.index(name))
    return LiveChannel(title, colour, (time_s, factor * values), (whole_s, factor * outline))


def limits_of(folder: Path) -> dict[str, float]:
    """The limits that a recording was started with, by channel; empty where it has none."""
    try:
        campaign, _ = read_manifest(folder)
    except UserError:
        return {}
    force_N, strain = campaign.recipe.get("max_force_N"), campaign.recipe.get("max_strain")
    limits = {FORCE: force_N, DISPLACEMENT: strain and strain * campaign.gauge_length_mm}
    return {name: limit for name, limit in limits.items() if limit is not None and np.isfinite(limit)}


def facts_in_words(status: dict[str, Any]) -> str:
    """What the recorder last said of itself, as HTML."""
    if "samples" not in status:
        return '<span class="quiet">waiting for the first sample</span>'
    duration = status.get("duration_s")
    whole = f" / {duration:.0f}" if duration and math.isfinite(duration) else ""
    pairs = [
        ("Time", f"{status['time_s']:.1f}{whole} s"),
        ("Rate", f"{status['rate_hz']:.1f} Hz"),
        ("Samples", str(status["samples"])),
        ("Lost", str(status["lost"])),
        ("Rejected", str(status["rejected"])),
        ("Strain", f"{100 * status['strain']:.1f} %"),
    ]
    if status.get("force_N") is not None:
        pairs.append(("Force", f"{status['force_N']:.3f} N"))
    if status.get("compensated") is not None:
        pairs.append(("Compensated", f"{status['compensated']:.3f} {status['compensated_unit']}"))
    return "".join(
        f'<span class="count"><b>{value}</b> <span class="quiet">{name}</span></span>' for name, value in pairs
    )
