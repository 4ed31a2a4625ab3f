"""Recordings that ended early or were cut off: what is said of them, and how they are gone on with."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable
from pathlib import Path

from nicegui import ui

from gcode.support.errors import UserError
from testbench.recordings.manifest import CSV, IN_PROGRESS, read_manifest
from testbench.rig.connection.ports import remembered_port
from testbench.studio.parts.widgets import button, way_on
from testbench.studio.studio import KEY_RECORDING, KEY_RIG, Studio
from testbench.studio.workspace import Campaign

GROWN_S = 15.0  # a recording that has grown within this time is being written, by whomever
ENDINGS = {
    IN_PROGRESS: "The recorder was cut off before the motion was over.",
    "interrupted": "It was stopped before the motion was over.",
    "port lost": "The port was lost before the motion was over.",
    "disk full": "The disk was full before the motion was over.",
}


def is_unfinished(campaign: Campaign) -> bool:
    """Whether there is more to be recorded; a limit that was passed is an end."""
    return campaign.origin == "recorded" and campaign.status in ENDINGS


def is_under_way(studio: Studio, campaign: Campaign) -> bool:
    """Whether it is being recorded now, by this studio or by a command in a terminal."""
    if campaign.status != IN_PROGRESS:
        return False
    if studio.jobs.last_command(KEY_RECORDING)[-1:] == (str(campaign.folder),):
        job = studio.jobs.under_way(KEY_RECORDING)  # it was our recorder, and of that we know
        return job is not None and Path(job.argv[-1]) == campaign.folder
    with contextlib.suppress(FileNotFoundError):
        return time.time() - (campaign.folder / CSV).stat().st_mtime < GROWN_S
    return False


def unfinished_card(studio: Studio, campaign: Campaign) -> None:
    """Say that a recording is unfinished, and offer to go on with it."""
    with ui.column().classes("trouble gap-2").props("role=status"):
        with ui.row().classes("items-center gap-2"):
            ui.label("unfinished").classes("tag bad")
            ui.label(ENDINGS[campaign.status]).style("font-weight:600")
        ui.label("Every sample up to then is on disk and is shown below. Resume records the rest into it.")
        with ui.row().classes("items-center gap-2"):
            port = ui.input("Port", value=_port_of(campaign)).style("width:min(420px, 76vw)")
            look = "unelevated color=accent"
            button("Resume", "fiber_manual_record", lambda: resume(studio, campaign, port.value or ""), look)


def under_way_card() -> None:
    """Say that it is being recorded now."""
    with ui.row().classes("card items-center justify-between").props("role=status"):
        ui.label("This is being recorded now; what is on disk so far is shown below.")
        way_on("Watch it live", "sensors", "/record")


def resume(
    studio: Studio, campaign: Campaign, port: str = "", go: Callable[[str], None] = lambda url: ui.navigate.to(url)
) -> None:
    """Go on recording into a campaign, and watch it.

    Raises
    ------
    UserError
        If a recording is under way, or what it was recorded from is not there.
    """
    refuse_a_second(studio)
    if is_under_way(studio, campaign):
        raise UserError(
            f"{campaign.name} has grown in the last {GROWN_S:.0f} s: another program is recording into it"
        )
    port = port or _port_of(campaign)
    if not port:
        raise UserError(f"{campaign.name}: name the port to record from: a device such as /dev/ttyUSB0")
    if port == str(rig_port(studio)) and not rig_port(studio).exists():
        raise UserError(
            "the simulated rig that this was recorded from has ended, and its motion with it; "
            "record anew, or name another port"
        )
    argv = ["testbench", "record", "--resume", f"--port={port}", "--progress-json"]
    argv += [*_compensator_of(studio, campaign), "-o", str(campaign.folder)]
    studio.jobs.start(KEY_RECORDING, f"Recording {campaign.name}", argv)
    go("/record")


def refuse_a_second(studio: Studio) -> None:
    """Raise `UserError` while a recording is under way: there is one at a time."""
    if running := studio.jobs.under_way(KEY_RECORDING):
        raise UserError(f"{running.title}: this is still under way, and there is one recording at a time")


def rig_port(studio: Studio) -> Path:
    """The port that the simulated rig of this studio hangs on."""
    return studio.workspace.results(KEY_RIG) / "port"


def _port_of(campaign: Campaign) -> str:
    """The port that it was recorded from, if that is opened on the word of a manifest; others are to be typed."""
    found, _ = read_manifest(campaign.folder)
    try:
        return remembered_port(str(found.recipe.get("port") or ""), campaign.folder)
    except UserError:
        return ""


def _compensator_of(studio: Studio, campaign: Campaign) -> list[str]:
    """The option that it was recorded with last, where this studio recorded it with one."""
    words = list(studio.jobs.last_command(KEY_RECORDING))
    if words[-1:] != [str(campaign.folder)]:
        return []
    return [word for word in words if word.startswith("--compensator=")]
