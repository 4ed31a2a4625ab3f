"""The model of a campaign: where it is kept, and fitting its baseline."""

from __future__ import annotations

from pathlib import Path

from nicegui import ui

from testbench.studio.jobs import Job, State
from testbench.studio.studio import Studio
from testbench.studio.widgets import attempt, job_card, subheading

LAST_THIRD = "the last third of this recording"


def model_path(studio: Studio, c: str) -> Path:
    """``model.json`` of a campaign; it carries its whole ladder."""
    return studio.workspace.results(c) / "model.json"


def held_out_choices(studio: Studio, c: str) -> list[str]:
    """Campaigns of the same gauge length, which errors may be judged on."""
    own = studio.workspace.campaign(c)
    others = [
        other.name
        for other in studio.workspace.campaigns()
        if other.name != c and other.gauge_length_mm == own.gauge_length_mm
    ]
    return [LAST_THIRD, *others]


def held_out_arguments(studio: Studio, held: str) -> list[str]:
    """``--held-out FOLDER``, or nothing for the last third."""
    return [] if held == LAST_THIRD else ["--held-out", str(studio.workspace.campaign(held).folder)]


def add_fit_form(studio: Studio, c: str, then: str) -> None:
    """Offer to fit the baseline; go to the address `then` when it is done."""
    studio.workspace.campaign(c)
    with ui.column().classes("card gap-3"):
        subheading(
            "First, a baseline",
            "Elasticity, hysteresis, contact and drift are fitted to this recording; errors are judged on samples "
            "that the fit does not see.",
        )
        choices = held_out_choices(studio, c)
        held = ui.select(choices, value=choices[0], label="Held out").props("outlined dense")
        held.style("min-width:300px")
        holder = ui.column().classes("w-full")

        def ended(job: Job) -> None:
            if job.state is State.DONE:
                ui.navigate.to(then)

        def show(job: Job) -> None:
            holder.clear()
            with holder:
                job_card(studio, job, ended)

        def start() -> None:
            folder = studio.workspace.campaign(c).folder
            argv = ["testbench", "fit", str(folder), *held_out_arguments(studio, held.value)]
            show(
                studio.jobs.start(
                    f"model:{c}", f"Fitting the baseline to {c}", [*argv, "-o", str(model_path(studio, c))]
                )
            )

        ui.button("Fit the baseline", icon="tune", on_click=lambda: attempt(start)).props("unelevated")
        running = studio.jobs.find(f"model:{c}")
        if running and running.running:
            show(running)
