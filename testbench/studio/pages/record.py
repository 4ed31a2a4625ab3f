"""Record: from a serial port, or from the simulated rig behind one; live, with limits and a stop within reach."""

from __future__ import annotations

import asyncio
import itertools
from pathlib import Path

from nicegui import ui

from gcode.support.errors import UserError
from gcode.support.files import make_folder
from testbench.studio.pages.campaign.compensate import compensators
from testbench.studio.pages.live import Live
from testbench.studio.pages.plan import SENSORS
from testbench.studio.parts.fields import check, number_field, typed
from testbench.studio.parts.unfinished import refuse_a_second, rig_port
from testbench.studio.parts.widgets import button, guarded, heading, invitation, way_on
from testbench.studio.studio import KEY_RECORDING, KEY_RIG, Studio

SIMULATED = "the simulated rig"
STARTS_WITHIN_S = 30


@guarded
def page(studio: Studio) -> None:
    """The form, or the recording that is under way; one at a time, seen by every tab."""
    heading("Record", "Progress, losses and limits in view; every sample is on disk before it is on the screen.")
    holder = ui.column().classes("w-full gap-4")
    with holder:
        if job := studio.jobs.under_way(KEY_RECORDING):
            Live(studio, job)
            return
        programs = sorted(path.parent.name for path in studio.workspace.program().glob("*/program.tap"))
        if programs:
            _Form(studio, holder, programs)
            return
        with invitation(
            "No program yet", "A recording follows a program. Plan a motion first; it is written for you."
        ):
            way_on("Plan and run", "timeline", "/plan")


class _Form:
    """What a person says before a recording, and its start."""

    def __init__(self, studio: Studio, holder: ui.column, programs: list[str]) -> None:
        self.studio, self.holder, self.begins = studio, holder, False
        with ui.column().classes("card gap-3"):
            with ui.row().classes("items-center"):
                self._rig(programs)
            with ui.row().classes("items-center"):
                self._campaign()
            ports = ", ".join(ports_here())
            seen = f"Serial devices here: {ports}." if ports else "No serial device is plugged in here now."
            under = "Beyond a limit the recording stops. The motion starts when the machine runs the program."
            ui.label(f"{seen} {under}").classes("quiet text-sm")
            button("Record", "fiber_manual_record", self.start, "unelevated color=accent")

    def _rig(self, programs: list[str]) -> None:
        self.port = ui.input("Port", value=SIMULATED, autocomplete=[SIMULATED, *ports_here()])
        self.port.style("min-width:230px")
        self.sensor = ui.select(SENSORS, value="pes", label="Simulated sensor")
        self.sensor.style("width:170px").bind_visibility_from(self.port, "value", lambda value: value == SIMULATED)
        self.program = ui.select(programs, value=programs[-1], label="Program")
        self.program.style("min-width:300px")

    def _campaign(self) -> None:
        self.name = ui.input("Campaign name", value=_free(self.studio, "recorded"))
        self.specimen = ui.input("Specimen")
        self.force = number_field("Force limit / N", None, optional=True)
        self.strain = number_field("Strain limit / %", None, optional=True)
        trained = compensators(self.studio)
        choices = {"": "none", **trained}
        self.compensator = ui.select(choices, value="", label="Compensator")
        self.compensator.style("min-width:200px").set_visibility(bool(trained))

    async def start(self) -> None:
        """Start the recorder, and follow it where the form stood; another click while it starts is none."""
        if self.begins:
            return
        self.begins = True
        try:
            await self._start()
        finally:
            self.begins = False

    async def _start(self) -> None:
        check(self.force, self.strain)
        target = self.studio.workspace.free_name(self.name.value)
        tap = self.studio.workspace.program(self.program.value) / "program.tap"
        refuse_a_second(self.studio)
        simulated = self.port.value == SIMULATED
        url = await _simulated_port(self.studio, self.sensor.value, tap) if simulated else self.port.value
        argv = ["testbench", "record", f"--port={url}", "--program", str(tap), "--progress-json", *self._said()]
        job = self.studio.jobs.start(KEY_RECORDING, f"Recording {self.name.value}", [*argv, "-o", str(target)])
        if self.holder.is_deleted:
            return  # the page was left while the rig started; “Running now” leads back to it
        self.holder.clear()
        with self.holder:
            Live(self.studio, job)

    def _said(self) -> list[str]:
        """Options of the command line, but for those whose field is empty."""
        said = {
            "--specimen": self.specimen.value,
            "--max-force-n": typed(self.force) if self.force.value else "",
            "--max-strain": f"{self.strain.value / 100:.12g}" if self.strain.value else "",
            "--compensator": self.compensator.value,
        }
        return [f"{flag}={text}" for flag, text in said.items() if text]  # a text may begin with a dash


def ports_here() -> list[str]:
    """Serial ports of this machine that have a device behind them."""
    from serial.tools.list_ports import comports

    return sorted(port.device for port in comports() if port.hwid != "n/a")


def _free(studio: Studio, stem: str) -> str:
    names = (f"{stem}-{number}" for number in itertools.count(1))
    return next(name for name in names if not (studio.workspace.root / name).exists())


async def _simulated_port(studio: Studio, sensor: str, program: Path) -> str:
    """Put the simulated rig behind a pseudo-terminal; the name of its port.

    Raises
    ------
    UserError
        If it does not start.
    """
    old = studio.jobs.find(KEY_RIG)
    if old:
        await studio.jobs.cancel(old)  # it may still be playing another program
    link = rig_port(studio)
    make_folder(link.parent)
    link.unlink(missing_ok=True)
    argv = ["testbench", "rig", "--sensor", sensor, "--program", str(program), "--link", str(link)]
    rig = studio.jobs.start(KEY_RIG, f"Simulated rig, {sensor}", argv)
    for _ in range(STARTS_WITHIN_S * 10):
        if link.exists():
            return str(link)
        if not rig.running:
            break
        await asyncio.sleep(0.1)
    raise UserError(f"the simulated rig did not start: {rig.problem}")
