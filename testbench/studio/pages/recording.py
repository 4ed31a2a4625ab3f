"""One recording: facts, every channel over time, loops, distributions."""

from __future__ import annotations

import contextlib
from functools import partial
from pathlib import Path

from nicegui import ui

from gcode.support.errors import UserError
from testbench.recording import DISPLACEMENT, Recording
from testbench.report import recording_figures as figures
from testbench.studio.models import model_path
from testbench.studio.pages.compare import view_of
from testbench.studio.picture import plot, zooming_plot
from testbench.studio.studio import Studio
from testbench.studio.widgets import address, aside, campaign_head, facts, guarded, later, trouble


@guarded
async def page(studio: Studio, c: str = "") -> None:
    """The recording of campaign `c`."""
    campaign_head(c, "/recording")
    problems = await aside(studio.workspace.problems, c)
    if problems:
        remedy = "Restore the file from a copy, or import it as a foreign CSV if you changed it on purpose."
        trouble("This campaign does not agree with its manifest: " + "; ".join(problems), remedy)
        return
    recording = await aside(studio.workspace.recording, c)
    facts(figures.summary(recording))
    caption = "Drag to zoom; double-click to see all again. A zoom draws every sample of its stretch."
    zooming_plot(partial(figures.time_series, recording), caption)
    path = studio.workspace.campaign(c).folder / "recording.csv"
    later(partial(_below, c, recording, path))
    later(partial(_prepare, studio, c))


def _below(c: str, recording: Recording, path: Path) -> None:
    loops = figures.hysteresis_loops(recording)
    if loops:
        plot(loops, "Six half minutes, the first dark, the last light: a shift along the colours is drift.")
    rate = f"; the speed is taken at {figures.speed_rate_hz(recording):.3g} Hz" if recording.has(DISPLACEMENT) else ""
    plot(figures.distributions(recording), f"How often each value occurred{rate}.")
    with ui.row():
        ui.button(
            "Download CSV", icon="download", on_click=lambda: ui.download(path, f"{path.parent.name}.csv")
        ).props("outline")
        if path.with_name("program.tap").is_file():
            align = ui.button("Compare with the plan", icon="compare_arrows").props("outline")
            align.on_click(lambda: ui.navigate.to(address("/align", c=c)))


async def _prepare(studio: Studio, c: str) -> None:
    """Work the comparison out while the recording is looked at: it is what comes next."""
    if model_path(studio, c).is_file():
        with contextlib.suppress(UserError):  # the page of the comparison will say it
            await aside(view_of, studio, c, c)
