"""Plan and run: a motion within limits, its picture and its program; then a simulated campaign with it."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

from nicegui import ui

from gcode.support.errors import UserError
from gcode.support.files import read_json
from testbench.report.trajectory_figures import motion
from testbench.studio.jobs import Job, State
from testbench.studio.picture import plot
from testbench.studio.studio import Studio
from testbench.studio.widgets import address, aside, attempt, facts, guarded, heading, job_card, number, subheading

PRESETS = {
    "paper-1": "paper-1, 0–30 % strain",
    "paper-2": "paper-2, 0–30 % strain",
    "paper-3": "paper-3, 0–30 % strain",
    "fast": "fast, 0–50 % strain",
}
SENSORS = {"pes": "PES knit", "lycra": "Lycra knit"}
PROGRAMS = "programs"


@guarded
def page(studio: Studio, program: str = "") -> None:
    """The form; below it the plan, when `program` (a folder below ``programs``) is made."""
    heading("Plan and run", "A pseudo-natural motion that never repeats, written for the machine and checked.")
    _form(studio)
    if program:
        _result(studio, program)


def _form(studio: Studio) -> None:
    with ui.column().classes("card gap-3"):
        with ui.row().classes("items-center"):
            preset = ui.select(PRESETS, value="paper-1", label="Motion").props("outlined dense").style("width:220px")
            seed = number("Seed", 51, "%d")
            gauge = number("Gauge length / mm", 25)
            minutes = number("Duration / min", 23)
        with ui.expansion("Limits of the machine").classes("w-full"), ui.row().classes("items-center"):
            limits = {
                "--v-max": number("Speed / mm/s", None),
                "--a-max": number("Acceleration / mm/s²", None),
                "--x-min": number("Travel from / mm", None),
                "--x-max": number("to / mm", None),
            }
        holder = ui.column().classes("w-full")

        def start() -> None:
            name = f"{preset.value}-seed{_whole(seed.value, 'seed')}-{gauge.value:g}mm-{minutes.value:g}min"
            argv = ["gcode", "generate", "--preset", preset.value, "--seed", str(int(seed.value))]
            argv += ["--gauge-length-mm", f"{gauge.value:g}", "--duration-s", f"{60 * minutes.value:g}"]
            for option, field in limits.items():
                argv += [option, f"{field.value:g}"] if field.value is not None else []
            argv += ["-o", str(studio.workspace.root / PROGRAMS / name)]
            job = studio.jobs.start(f"plan:{name}", f"Planning {name}", argv)
            holder.clear()
            with holder:
                job_card(studio, job, _planned)

        ui.button("Plan", icon="timeline", on_click=lambda: attempt(start)).props("unelevated")


def _planned(job: Job) -> None:
    if job.state is State.DONE:
        ui.navigate.to(address("/plan", program=Path(job.argv[-1]).name))


def _whole(value: float | None, what: str) -> int:
    if value is None or value != int(value) or value < 0:
        raise UserError(f"the {what} must be a whole number, 0 or more; got {value}")
    return int(value)


def _result(studio: Studio, program: str) -> None:
    folder = (studio.workspace.root / PROGRAMS / program).resolve()
    if not folder.is_relative_to(studio.workspace.root) or not (folder / "trajectory.json").is_file():
        raise UserError(f"no plan called {program!r}; plan it again")
    made = read_json(folder / "trajectory.json", "plan")
    statistics, limits = made["statistics"], made["spec"]["limits"]
    subheading(program, "as executed by the controller, sampled at the plan's rate")
    facts(_figures(statistics))
    with ui.row():
        program_downloads(folder, program)
    _picture(folder, limits)
    _run_form(studio, folder, program)


def program_downloads(folder: Path, name: str) -> None:
    """Buttons for what `gcode` wrote into a folder."""
    files = (("Download the Mach4 program", "program.tap"), ("Trajectory as CSV", "trajectory.csv"))
    for title, file in files:
        button = ui.button(title, icon="download").props("outline")
        button.on_click(partial(ui.download, folder / file, f"{name}{Path(file).suffix}"))


def _figures(statistics: dict[str, Any]) -> list[tuple[str, str]]:
    return [
        ("Duration", f"{statistics['duration_s'] / 60:.1f} min"),
        ("Travel", f"{statistics['x_min_mm']:.2f} to {statistics['x_max_mm']:.2f} mm"),
        ("Mean speed", f"{statistics['v_mean_mm_per_s']:.3f} mm/s"),
        ("Largest speed", f"{statistics['v_max_mm_per_s']:.2f} mm/s"),
        ("Largest acceleration", f"{statistics['a_max_mm_per_s2']:.1f} mm/s²"),
    ]


def _picture(folder: Path, limits: dict[str, float]) -> None:
    from gcode.trajectory import read_csv

    holder = ui.column().classes("w-full")

    async def draw() -> None:
        planned = await aside(read_csv, folder / "trajectory.csv")
        figure = motion(
            planned.time_s, planned.position_mm, limits.get("v_max_mm_per_s"), limits.get("a_max_mm_per_s2")
        )
        with holder:
            plot(figure, "The planned motion; dashed: the limits of the machine.")

    ui.timer(0.01, draw, once=True)


def _run_form(studio: Studio, folder: Path, program: str) -> None:
    with ui.column().classes("card gap-3"):
        subheading("Run it on the simulated rig", "The same bytes as the real rig, in about a second.")
        with ui.row().classes("items-center"):
            sensor = ui.select(SENSORS, value="pes", label="Sensor").props("outlined dense").style("width:160px")
            seed = number("Seed of noise", 1, "%d")
            name = ui.input("Campaign name", value=f"pes-{program}").props("outlined dense").style("min-width:300px")
        sensor.on_value_change(lambda event: name.set_value(f"{event.value}-{program}"))
        holder = ui.column().classes("w-full")

        def start() -> None:
            target = studio.workspace.free_name(name.value)
            argv = ["testbench", "run", "--sensor", sensor.value, "--program", str(folder / "program.tap")]
            argv += ["--seed", str(_whole(seed.value, "seed")), "--progress-json", "-o", str(target)]
            job = studio.jobs.start(f"run:{name.value}", f"Running {name.value}", argv)
            holder.clear()
            with holder:
                job_card(studio, job, lambda ended: _ran(studio, ended))

        ui.button("Run", icon="play_arrow", on_click=lambda: attempt(start)).props("unelevated")


def _ran(studio: Studio, job: Job) -> None:
    if job.state is State.DONE:
        name = Path(job.argv[-1]).relative_to(studio.workspace.root).as_posix()
        ui.navigate.to(address("/recording", c=name))
