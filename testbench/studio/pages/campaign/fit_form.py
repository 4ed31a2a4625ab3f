"""The form that fits the baseline to a campaign, where it has no model or is to have another one."""

from __future__ import annotations

import contextlib

from nicegui import ui

from gcode.support.errors import UserError
from gcode.support.files import copy_file
from testbench.studio import models
from testbench.studio.parts.fields import check, number_field, typed
from testbench.studio.parts.starting import join_running
from testbench.studio.parts.widgets import aside, button, subheading, trouble, way_on
from testbench.studio.studio import Studio

PLAY, REST = "Play of the clamps / mm", "Rest before it / s"


async def refit_instead(studio: Studio, c: str) -> bool:
    """Whether the model of a campaign cannot be used; why is said then, and a baseline anew is offered."""
    why = await aside(models.why_unusable, studio, c)
    if why:
        trouble(why, "Bring back what is gone, or fit the baseline anew.")
        way_on("Own effects", "functions", "/effects", "outline")
        add_fit_form(studio, c, again=True)
    return bool(why)


def add_fit_form(studio: Studio, c: str, again: bool = False) -> None:
    """Offer to fit the baseline; build the page anew when it is done.

    `again`: in place of a model that is there, which is kept beside it as ``model-before.json``.
    """
    with ui.column().classes("card gap-3"):
        under = (
            "Elasticity, hysteresis, contact and drift are fitted to this recording; errors are judged on samples "
            "that the fit does not see."
        )
        more = f" It takes the place of the model and its ladder, which are kept as {models.BEFORE}."
        subheading("The baseline anew" if again else "First, a baseline", under + (more if again else ""))
        choices = models.held_out_choices(studio, c)
        value = choices[0]
        with contextlib.suppress(UserError):
            value = models.held_out_of(studio, c) if again else value
        with ui.row().classes("items-start"):
            held = ui.select(choices, value=value, label="Held out")
            held.style("min-width:min(300px, 84vw)")
            play = number_field(PLAY, None, positive=False, optional=True).props('hint="empty: not clamped anew"')
            play.tooltip("where the sensor was clamped anew: by how much the zero of its displacement may have moved")
            rest = number_field(REST, None, optional=True).props('hint="empty: it is of a fresh specimen"')
            rest.tooltip("where the held-out recording is of the same specimen: how long that rested before it")
            for field in (play, rest):
                field.style("width:260px")  # their labels are long
                field.bind_visibility_from(held, "value", backward=lambda value: value != models.LAST_THIRD)

        def start() -> None:
            check(play, rest)
            models.refuse_while_asked(studio, c)
            if models.has_model(studio, c):  # also where this tab does not know of it yet
                copy_file(models.model_path(studio, c), models.model_path(studio, c).with_name(models.BEFORE))
            argv = ["testbench", "fit", str(studio.workspace.campaign(c).folder)]
            argv += models.held_out_arguments(studio, str(held.value)) + studio.effects.arguments()
            for option, field in (("--clamp-play-mm", play), ("--rest-s", rest)):
                argv += [option, typed(field)] if field.value and field.visible else []
            argv += ["-o", str(models.model_path(studio, c))]
            models.change_model(studio, c, [(f"Fitting the baseline to {c}", argv)], holder, ui.navigate.reload)

        words = "Fit the baseline anew" if again else "Fit the baseline"
        button(words, "tune", start, "outline" if again else "unelevated")
        holder = ui.column().classes("w-full")
        join_running(studio, f"model:{c}", holder, ui.navigate.reload)
