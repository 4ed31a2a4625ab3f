"""Record: from a serial port, or from the simulated rig behind one; live, with limits and a stop within reach."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from nicegui import ui

from gcode.support.errors import UserError
from testbench.recording import DISPLACEMENT, FORCE, RESISTANCE, TIME
from testbench.report import style
from testbench.report.live_figures import LiveChannel, live
from testbench.studio.jobs import Job, State
from testbench.studio.live import Follower
from testbench.studio.pages.plan import PROGRAMS, SENSORS
from testbench.studio.picture import plot
from testbench.studio.studio import Studio
from testbench.studio.widgets import address, aside, attempt, guarded, heading, trouble

KEY = "record"
SIMULATED = "the simulated rig"
REFRESH_S = 0.5


@guarded
def page(studio: Studio) -> None:
    """The form, or the recording that is under way; one at a time, seen by every tab."""
    heading("Record", "Progress, losses and limits in view; every sample is on disk before it is on the screen.")
    holder = ui.column().classes("w-full gap-4")
    job = studio.jobs.find(KEY)
    with holder:
        if job and job.running:
            _Live(studio, job)
        else:
            _form(studio, holder)


def _form(studio: Studio, holder: ui.column) -> None:
    programs = sorted(path.parent.name for path in (studio.workspace.root / PROGRAMS).glob("*/program.tap"))
    if not programs:
        trouble("No program yet: a recording follows one.", "Plan a motion first; the plan page writes its program.")
        ui.button("Plan and run", icon="timeline", on_click=lambda: ui.navigate.to("/plan")).props("unelevated")
        return
    with ui.column().classes("card gap-3"):
        with ui.row().classes("items-center"):
            port = ui.input("Port", value=SIMULATED, autocomplete=[SIMULATED, "/dev/ttyUSB0", "/dev/ttyACM0"])
            port.props("outlined dense").style("min-width:230px")
            sensor = ui.select(SENSORS, value="pes", label="Simulated sensor").props("outlined dense")
            sensor.style("width:170px").bind_visibility_from(port, "value", lambda value: value == SIMULATED)
            program = ui.select(programs, value=programs[-1], label="Program").props("outlined dense")
            program.style("min-width:300px")
        with ui.row().classes("items-center"):
            name = ui.input("Campaign name", value=_free(studio, "recorded")).props("outlined dense")
            specimen = ui.input("Specimen").props("outlined dense")
            force = ui.number("Stop beyond / N", min=0, format="%.6g").props("outlined dense").style("width:150px")
            strain = ui.number("Stop beyond / % strain", min=0, format="%.6g").props("outlined dense")
            strain.style("width:170px")

        async def start() -> None:
            target = studio.workspace.free_name(name.value)
            tap = studio.workspace.root / PROGRAMS / program.value / "program.tap"
            url = _simulated_port(studio, sensor.value, tap) if port.value == SIMULATED else port.value
            argv = ["testbench", "record", "--port", url, "--program", str(tap), "--progress-json"]
            argv += ["--specimen", specimen.value] if specimen.value else []
            argv += ["--max-force-n", f"{force.value:g}"] if force.value else []
            argv += ["--max-strain", f"{strain.value / 100:g}"] if strain.value else []
            if port.value == SIMULATED:
                await _wait_for(Path(url))
            job = studio.jobs.start(KEY, f"Recording {name.value}", [*argv, "-o", str(target)])
            holder.clear()
            with holder:
                _Live(studio, job)

        ui.button("Record", icon="fiber_manual_record", on_click=lambda: attempt(start)).props(
            "unelevated color=accent"
        )


def _free(studio: Studio, stem: str) -> str:
    number = 1
    while (studio.workspace.root / f"{stem}-{number}").exists():
        number += 1
    return f"{stem}-{number}"


def _simulated_port(studio: Studio, sensor: str, program: Path) -> str:
    """Put the simulated rig behind a pseudo-terminal; the name of its port."""
    link = studio.workspace.results("rig") / "port"
    argv = ["testbench", "rig", "--sensor", sensor, "--program", str(program), "--link", str(link)]
    studio.jobs.start("rig", f"Simulated rig, {sensor}", argv)
    return str(link)


async def _wait_for(link: Path) -> None:
    import asyncio

    for _ in range(200):
        if link.exists():
            return
        await asyncio.sleep(0.1)
    raise UserError("the simulated rig did not start; its port never appeared")


class _Live:
    """The recording under way: figures that count, the plot, the stop."""

    def __init__(self, studio: Studio, job: Job) -> None:
        self.studio, self.job = studio, job
        self.folder = Path(job.argv[-1])
        self.follower = Follower(self.folder / "recording.csv")
        with ui.row().classes("items-center justify-between w-full card no-wrap") as head:
            self.facts = ui.html("", sanitize=False).classes("grow")
            self.stop = ui.button("Stop", icon="stop", on_click=self._stop)
            self.stop.props("unelevated color=accent size=lg")
        head.style("position:sticky;top:8px;z-index:5")  # the stop stays within reach
        self.news = ui.label().classes("trouble").props("role=alert")
        self.news.set_visibility(False)
        self.bar = ui.linear_progress(value=0, show_value=False).props("rounded size=8px")
        self.alarm = ui.column().classes("w-full")
        self.plot = plot(live([]), "Left: the last minute, every sample. Right: all so far. Dashed: your limits.")
        self.timer = ui.timer(REFRESH_S, self._look)

    async def _stop(self) -> None:
        self.stop.disable()
        await self.studio.jobs.cancel(self.job)
        rig = self.studio.jobs.find("rig")
        if rig:
            await self.studio.jobs.cancel(rig)

    async def _look(self) -> None:
        fresh = await aside(self.follower.look)
        self.facts.set_content(_facts(self.job.latest))
        self.bar.set_value(self.job.share or 0.0)
        said = str(self.job.latest.get("message") or "")
        self.news.set_text(said)
        self.news.set_visibility(bool(said) and self.job.running)
        if fresh:
            self.plot.show(live(self._channels()))
        if not self.job.running:
            self._ended()

    def _channels(self) -> list[LiveChannel]:
        found = []
        for name, title, colour, limit in (
            (DISPLACEMENT, "Displacement / mm", style.STRAIN, None),
            (FORCE, "Force / N", style.FORCE, _option(self.job, "--max-force-n")),
            (RESISTANCE, "Resistance / ohm", style.CONDUCTANCE, None),
        ):
            values, envelope = self.follower.channel(name), self.follower.envelope
            time_s = self.follower.channel(TIME)
            if values is not None and time_s is not None and envelope is not None:
                outline = envelope.outline(self.follower.names.index(name))
                found.append(LiveChannel(title, colour, (time_s, values), outline, limit))
        return found

    def _ended(self) -> None:
        self.timer.deactivate()
        self.stop.set_visibility(False)
        said = str(self.job.latest.get("message", ""))
        with self.alarm:
            if self.job.state is State.FAILED:
                trouble(said or self.job.problem, "Every sample up to that moment is on disk.")
            else:
                ui.label(f"{self.job.title}: {self.job.latest.get('state', self.job.state.value)}. {said}")
            if (self.folder / "datapackage.json").is_file():
                name = self.folder.relative_to(self.studio.workspace.root).as_posix()
                ui.button("Open the recording", on_click=lambda: ui.navigate.to(address("/recording", c=name)))


def _option(job: Job, name: str) -> float | None:
    return float(job.argv[job.argv.index(name) + 1]) if name in job.argv else None


def _facts(status: dict[str, Any]) -> str:
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
    return "".join(
        f'<span class="count"><b>{value}</b> <span class="quiet">{name}</span></span>' for name, value in pairs
    )
