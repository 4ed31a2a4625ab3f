"""Experiment: effects that a recording cannot tell apart, and the next motion that will."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from nicegui import ui

from gcode.support.errors import UserError
from gcode.support.files import copy_file
from gcode.trajectories.trajectory import read_csv
from testbench.comparing.words import spoken
from testbench.report.figures import experiment_figures as figures
from testbench.report.words import experiment_in_words
from testbench.results.result_files import read_diagnosis, read_experiment
from testbench.studio import models
from testbench.studio.pages.plan import program_downloads
from testbench.studio.parts.address import Address, address
from testbench.studio.parts.fields import asked, check, keep_in, number_field, typed
from testbench.studio.parts.picture import plot
from testbench.studio.parts.starting import join_running, run_in_turn
from testbench.studio.parts.widgets import aside, button, campaign_head, guarded, subheading, trouble, way_on
from testbench.studio.studio import Studio


@guarded
async def page(
    studio: Studio, c: str = "", strain: str = "", minutes: str = "", speed: str = "", acceleration: str = ""
) -> None:
    """The experiment that separates the tied effects of campaign `c`, within the limits that were chosen."""
    campaign_head(studio, c, "/missing")
    known = models.diagnosis_path(studio, c)
    if not known.is_file():
        raise UserError(f"{c} has no diagnosis yet; ask what is missing first, on the tab Missing effect")
    diagnosis = read_diagnosis(known)
    limits = {"strain": strain, "minutes": minutes, "speed": speed, "acceleration": acceleration}
    if not models.is_fresh(studio, c, diagnosis):
        trouble(
            "The model has changed since this diagnosis.", "Ask again what is missing, on the tab Missing effect."
        )
    _ask(studio, c, diagnosis, Address("/experiment", c=c, **limits))
    if experiment_path(studio, c).is_file() and _is_of(studio, c, diagnosis):
        await _answer(studio, c, read_experiment(experiment_path(studio, c)))


def experiment_path(studio: Studio, c: str) -> Path:
    """Where the ranking of the proposed motions is kept."""
    return studio.workspace.results(c) / "experiment.json"


def asked_path(studio: Studio, c: str) -> Path:
    """The diagnosis as it was when the motions were asked for; it may be made anew meanwhile."""
    return studio.workspace.results(c) / "experiment-asked.json"


def _is_of(studio: Studio, c: str, diagnosis: Mapping[str, Any]) -> bool:
    """Whether the motions were designed for this very diagnosis; by its time where a command line has asked."""
    asked = asked_path(studio, c)
    if asked.is_file():
        return read_diagnosis(asked) == diagnosis
    return experiment_path(studio, c).stat().st_mtime >= models.diagnosis_path(studio, c).stat().st_mtime


def program_name(c: str) -> str:
    """The proposed program, below ``programs``: the plan page and the recorder find it there."""
    return f"{c.replace('/', '-')}-experiment"


def rivals_of(diagnosis: Mapping[str, Any]) -> list[str]:
    """The effects that are tied; where none are, the first two."""
    names = list(diagnosis.get("tied") or []) or list(dict.fromkeys(row["effect"] for row in diagnosis["ranking"]))
    return [spoken(name) for name in names[:2]]


def _ask(studio: Studio, c: str, diagnosis: Mapping[str, Any], where: Address) -> None:
    key = f"experiment:{c}"
    with ui.column().classes("card gap-3"):
        subheading(
            f"Which is it: {' or '.join(rivals_of(diagnosis))}?",
            "A dozen motions are tried on the models of both; the best is the one that leaves the wrong model the "
            "least room. This takes a minute or two.",
        )
        with ui.row().classes("items-center"):
            strain = number_field("Largest strain / %", asked(where, "strain", 30))
            minutes = number_field("Duration / min", asked(where, "minutes", 10))
            speed = number_field("Speed up to / mm/s", asked(where, "speed", 10))
            acceleration = number_field("Acceleration up to / mm/s²", asked(where, "acceleration", 20))
        keep_in(where, strain=strain, minutes=minutes, speed=speed, acceleration=acceleration)
        button("Find the motion that tells them apart", "science", lambda: start())
        holder = ui.column().classes("w-full")

    def start() -> None:
        check(strain, minutes, speed, acceleration)
        argv = ["testbench", "experiment", "--diagnosis", str(asked_path(studio, c))]
        argv += ["--fit", str(studio.workspace.campaign(c).folder), *studio.effects.arguments()]
        argv += models.held_out_arguments(studio, models.held_out_of(studio, c))
        argv += ["--strain-max", typed(strain), "--v-max", typed(speed), "--a-max", typed(acceleration)]
        argv += ["--duration-s", f"{60 * minutes.value:.12g}", "--json", str(experiment_path(studio, c))]
        argv += ["-o", str(studio.workspace.program(program_name(c)))]
        if not studio.jobs.under_way(key):
            experiment_path(studio, c).unlink(missing_ok=True)  # it may be of another diagnosis
            copy_file(models.diagnosis_path(studio, c), asked_path(studio, c))
        title = f"Looking for the motion that tells {' from '.join(rivals_of(diagnosis))}"
        run_in_turn(studio, key, [(title, argv)], holder, ui.navigate.reload)

    join_running(studio, key, holder, ui.navigate.reload)


async def _answer(studio: Studio, c: str, found: Mapping[str, Any]) -> None:
    folder = studio.workspace.program(program_name(c))
    ui.label(experiment_in_words(found)).classes("verdict")
    with ui.row():
        program_downloads(folder, program_name(c))
        way_on("Open in Plan and run", "timeline", address("/plan", program=program_name(c)), "outline")
    planned = await aside(read_csv, folder / "trajectory.csv")
    strain = 100 * planned.position_mm / float(found["gauge_length_mm"])
    plot(
        figures.of_file(found, planned.time_s, strain),
        "Above: how much each motion would tell; right of the dashed line it decides. Below: the best motion, and "
        "what the wrong model could not imitate while it runs.",
    )
