"""Plan and run: a motion within limits, its picture and its program; then a simulated campaign with it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from nicegui import ui

from gcode.programs.make import read_plan
from gcode.support.errors import UserError
from gcode.trajectories.trajectory import read_csv
from testbench.report.figures.motion_figures import motion
from testbench.report.words import duration_in_words
from testbench.studio.jobs.job import Job, State
from testbench.studio.parts.address import Address
from testbench.studio.parts.fields import asked, check, keep_in, number_field, typed
from testbench.studio.parts.picture import plot
from testbench.studio.parts.starting import join_newest, offer_campaign_of, open_campaign_of, start_in
from testbench.studio.parts.widgets import aside, button, download_button, facts, guarded, heading, later, subheading
from testbench.studio.studio import Studio

PRESETS = {
    "paper-1": "paper-1, 0–30 % strain",
    "paper-2": "paper-2, 0–30 % strain",
    "paper-3": "paper-3, 0–30 % strain",
    "fast": "fast, 0–50 % strain",
}
SENSORS = {"pes": "PES knit", "lycra": "Lycra knit"}
LIMITS = {  # by name in the address: option of the command, name in a preset, label of the field
    "speed": ("--v-max", "v_max_mm_per_s", "Speed / mm/s"),
    "acceleration": ("--a-max", "a_max_mm_per_s2", "Acceleration / mm/s²"),
    "lowest": ("--x-min", "x_min_mm", "Travel from / mm"),
    "highest": ("--x-max", "x_max_mm", "Travel to / mm"),
}


@guarded
def page(
    studio: Studio,
    program: str = "",
    motion: str = "",
    seed: str = "",
    gauge: str = "",
    minutes: str = "",
    speed: str = "",
    acceleration: str = "",
    lowest: str = "",
    highest: str = "",
) -> None:
    """The form as it was filled in; below it the plan, when `program` (a folder below ``programs``) is made."""
    heading("Plan and run", "A pseudo-natural motion that never repeats, written for the machine and checked.")
    limits = {"speed": speed, "acceleration": acceleration, "lowest": lowest, "highest": highest}
    form = {"motion": motion, "seed": seed, "gauge": gauge, "minutes": minutes}
    _form(studio, Address("/plan", program=program, **form, **limits), lambda: below.clear())
    below = ui.column().classes("w-full")
    if program:
        with below:
            _result(studio, program)


def _form(studio: Studio, where: Address, begun: Callable[[], object]) -> None:
    """What is wanted; `begun` is called when a plan is begun, for the one that is shown is another."""
    wanted = where.query["motion"] or "paper-1"
    if wanted not in PRESETS:
        raise UserError(f"the address asks for the motion {wanted!r}; there are {', '.join(PRESETS)}")
    with ui.column().classes("card gap-3"):
        with ui.row().classes("items-start"):
            preset = ui.select(PRESETS, value=wanted, label="Motion").style("width:220px")
            seed = number_field("Seed", asked(where, "seed", 51), whole=True)
            seed.tooltip("another seed is another motion of the same kind")
            gauge = number_field("Gauge length / mm", asked(where, "gauge", 25))
            minutes = number_field("Duration / min", asked(where, "minutes", 23))
        limits = _limits(where)
        keep_in(where, motion=preset, seed=seed, gauge=gauge, minutes=minutes)
        _say_which_hold(limits, str(preset.value))
        preset.on_value_change(lambda event: _say_which_hold(limits, str(event.value)))

        def start() -> None:
            check(seed, gauge, minutes, *limits.values())
            name = f"{preset.value}-seed{typed(seed)}-{typed(gauge)}mm-{typed(minutes)}min"
            argv = ["gcode", "generate", "--preset", preset.value, "--seed", str(int(seed.value))]
            argv += ["--gauge-length-mm", typed(gauge), "--duration-s", f"{60 * minutes.value:.12g}"]
            for key, field in limits.items():
                if field.value is not None:
                    option = LIMITS[key][0]
                    argv.append(f"{option}={typed(field)}")
                    name += f"-{option.removeprefix('--').removesuffix('-max').replace('-', '')}{typed(field)}"
            argv += ["-o", str(studio.workspace.program(name))]
            begun()
            start_in(holder, studio, f"plan:{name}", f"Planning {name}", argv, partial(_planned, where))

        button("Plan", "timeline", start)
        holder = ui.column().classes("w-full")
        join_newest(holder, studio, "plan", partial(_planned, where))


def _limits(where: Address) -> dict[str, ui.number]:
    """The fields for the limits of the machine, by name; folded where none was asked for."""
    limited = any(where.query[key] for key in LIMITS)
    fold = ui.expansion("Limits of the machine", value=limited).classes("w-full")
    with fold, ui.row().classes("items-start"):
        limits = {
            key: number_field(label, asked(where, key, None), positive=not option.startswith("--x"), optional=True)
            for key, (option, _, label) in LIMITS.items()
        }
    keep_in(where, **limits)
    return limits


def _planned(where: Address, job: Job) -> None:
    if job.state is State.DONE:
        where.go(program=Path(job.argv[-1]).name)


def _say_which_hold(fields: Mapping[str, ui.number], preset: str) -> None:
    """Under each empty field, the limit that holds then."""
    from gcode.trajectories.presets import PRESETS as SPECS

    for key, (_, name, label) in LIMITS.items():
        unit = label.partition(" / ")[2]
        fields[key].props(f'hint="empty: {getattr(SPECS[preset].limits, name):g} {unit}"')


def _result(studio: Studio, program: str) -> None:
    folder = studio.workspace.program(program).resolve()
    if not folder.is_relative_to(studio.workspace.root) or not (folder / "trajectory.json").is_file():
        raise UserError(f"no plan called {program!r}; plan it again")
    made = read_plan(folder / "trajectory.json")
    statistics, limits = made.statistics.model_dump(), made.spec.limits.model_dump()
    subheading(program, "as executed by the controller, sampled at the plan's rate")
    facts(_figures(statistics))
    with ui.row():
        program_downloads(folder, program)
    later(partial(_picture, folder, limits))
    _run_form(studio, folder, program)


def program_downloads(folder: Path, name: str) -> None:
    """Buttons for what `gcode` wrote into a folder."""
    files = (("Download the Mach4 program", "program.tap"), ("Trajectory as CSV", "trajectory.csv"))
    for title, file in files:
        download_button(title, folder / file, f"{name}{Path(file).suffix}")


def _figures(statistics: dict[str, Any]) -> list[tuple[str, str]]:
    return [
        ("Duration", duration_in_words(statistics["duration_s"])),
        ("Travel", f"{statistics['x_min_mm']:z.2f} to {statistics['x_max_mm']:z.2f} mm"),
        ("Mean speed", f"{statistics['v_mean_mm_per_s']:.3f} mm/s"),
        ("Largest speed", f"{statistics['v_max_mm_per_s']:.2f} mm/s"),
        ("Largest acceleration", f"{statistics['a_max_mm_per_s2']:.1f} mm/s²"),
    ]


async def _picture(folder: Path, limits: dict[str, float]) -> None:
    planned = await aside(read_csv, folder / "trajectory.csv")
    speed, acceleration = limits.get("v_max_mm_per_s"), limits.get("a_max_mm_per_s2")
    figure = motion(planned.time_s, planned.position_mm, speed, acceleration)
    plot(figure, "The planned motion; dashed: the limits of the machine.")


def _run_form(studio: Studio, folder: Path, program: str) -> None:
    with ui.column().classes("card gap-3"):
        subheading("Run it on the simulated rig", "The same bytes as the real rig, in about a second.")
        with ui.row().classes("items-center"):
            sensor = ui.select(SENSORS, value="pes", label="Sensor").style("width:160px")
            seed = number_field("Seed of noise", 1, whole=True)
            name = ui.input("Campaign name", value=f"pes-{program}").style("min-width:300px")
        sensor.on_value_change(lambda event: name.set_value(f"{event.value}-{program}"))
        ended, tap = partial(open_campaign_of, studio), str(folder / "program.tap")

        def start() -> None:
            check(seed)
            target = studio.workspace.free_name(name.value)
            argv = ["testbench", "run", "--sensor", sensor.value, "--program", tap]
            argv += ["--seed", str(int(seed.value)), "--progress-json", "-o", str(target)]
            start_in(holder, studio, f"run:{name.value}", f"Running {name.value}", argv, ended)

        button("Run", "play_arrow", start)
        holder = ui.column().classes("w-full")
        join_newest(holder, studio, "run", ended, partial(offer_campaign_of, studio), lambda job: tap in job.argv)
