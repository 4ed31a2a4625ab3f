"""Record: from a serial port, or from the simulated rig behind one; live, with limits and a stop within reach."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from pathlib import Path

from nicegui import ui

from gcode.support.errors import UserError
from testbench.studio.fields import check, number_field, typed
from testbench.studio.pages.compensate import compensators
from testbench.studio.pages.live import Live
from testbench.studio.pages.plan import PROGRAMS, SENSORS
from testbench.studio.studio import KEY_RECORDING, KEY_RIG, Studio
from testbench.studio.unfinished import rig_port
from testbench.studio.widgets import attempt, guarded, heading, invitation

SIMULATED = "the simulated rig"
PATIENCE_S = 30


@guarded
def page(studio: Studio) -> None:
    """The form, or the recording that is under way; one at a time, seen by every tab."""
    heading("Record", "Progress, losses and limits in view; every sample is on disk before it is on the screen.")
    holder = ui.column().classes("w-full gap-4")
    job = studio.jobs.find(KEY_RECORDING)
    with holder:
        if job and job.running:
            Live(studio, job)
            return
        programs = sorted(path.parent.name for path in (studio.workspace.root / PROGRAMS).glob("*/program.tap"))
        if programs:
            _form(studio, holder, programs)
            return
        with invitation(
            "No program yet", "A recording follows a program. Plan a motion first; it is written for you."
        ):
            ui.button("Plan and run", icon="timeline", on_click=lambda: ui.navigate.to("/plan")).props("unelevated")


def _form(studio: Studio, holder: ui.column, programs: list[str]) -> None:
    with ui.column().classes("card gap-3"):
        with ui.row().classes("items-center"):
            port = ui.input("Port", value=SIMULATED, autocomplete=[SIMULATED, *ports_here()])
            port.props("outlined dense").style("min-width:230px")
            sensor = ui.select(SENSORS, value="pes", label="Simulated sensor").props("outlined dense")
            sensor.style("width:170px").bind_visibility_from(port, "value", lambda value: value == SIMULATED)
            program = ui.select(programs, value=programs[-1], label="Program").props("outlined dense")
            program.style("min-width:300px")
        with ui.row().classes("items-center"):
            name = ui.input("Campaign name", value=_free(studio, "recorded")).props("outlined dense")
            specimen = ui.input("Specimen").props("outlined dense")
            force = number_field("Force limit / N", None, optional=True)
            strain = number_field("Strain limit / %", None, optional=True)
            trained = compensators(studio)
            compensator = ui.select({"": "none", **trained}, value="", label="Compensator").props("outlined dense")
            compensator.style("min-width:200px").set_visibility(bool(trained))
        ui.label(_hint(ports_here())).classes("quiet text-sm")

        async def start() -> None:
            check(force, strain)
            target = studio.workspace.free_name(name.value)
            tap = studio.workspace.root / PROGRAMS / program.value / "program.tap"
            _refuse_a_second(studio)
            url = await _simulated_port(studio, sensor.value, tap) if port.value == SIMULATED else port.value
            said = {
                "--specimen": specimen.value,
                "--max-force-n": typed(force) if force.value else "",
                "--max-strain": f"{strain.value / 100:.12g}" if strain.value else "",
                "--compensator": compensator.value,
            }
            argv = ["testbench", "record", "--port", url, "--program", str(tap), "--progress-json", *_said(said)]
            job = studio.jobs.start(KEY_RECORDING, f"Recording {name.value}", [*argv, "-o", str(target)])
            holder.clear()
            with holder:
                Live(studio, job)

        button = ui.button("Record", icon="fiber_manual_record", on_click=lambda: attempt(start))
        button.props("unelevated color=accent")


def _refuse_a_second(studio: Studio) -> None:
    running = studio.jobs.find(KEY_RECORDING)
    if running and running.running:
        raise UserError(f"{running.title}: this is still under way, and there is one recording at a time")


def _said(options: Mapping[str, str]) -> list[str]:
    """Options of the command line, but for those whose field is empty."""
    return [word for flag, text in options.items() if text for word in (flag, text)]


def ports_here() -> list[str]:
    """Serial ports of this machine that have a device behind them."""
    from serial.tools.list_ports import comports

    return sorted(port.device for port in comports() if port.hwid != "n/a")


def _hint(ports: list[str]) -> str:
    seen = f"Serial devices here: {', '.join(ports)}." if ports else "No serial device is plugged in here now."
    return f"{seen} Beyond a limit the recording stops. The motion starts when the machine runs the program."


def _free(studio: Studio, stem: str) -> str:
    number = 1
    while (studio.workspace.root / f"{stem}-{number}").exists():
        number += 1
    return f"{stem}-{number}"


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
    link.unlink(missing_ok=True)
    argv = ["testbench", "rig", "--sensor", sensor, "--program", str(program), "--link", str(link)]
    rig = studio.jobs.start(KEY_RIG, f"Simulated rig, {sensor}", argv)
    for _ in range(PATIENCE_S * 10):
        if link.exists():
            return str(link)
        if not rig.running:
            break
        await asyncio.sleep(0.1)
    raise UserError(f"the simulated rig did not start: {rig.problem}")
