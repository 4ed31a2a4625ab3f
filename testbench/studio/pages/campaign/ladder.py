"""The error ladder: how the error fell step by step; a slider through the history, undo, report."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any
from urllib.parse import quote

from nicegui import ui

from gcode.support.errors import UserError
from testbench.comparing.words import listed, spoken
from testbench.knit.catalogue import model_from_dict
from testbench.report.figures import diagnosis_figures
from testbench.report.figures import ladder_figures as figures
from testbench.report.figures.comparison_figures import busiest_window
from testbench.report.parameter_table import parameter_table
from testbench.report.provenance import moment
from testbench.report.sections import fall_in_words
from testbench.report.words import ladder_notes, verdict_in_words, with_unit
from testbench.results.model_file import ModelFile, load_model_file
from testbench.results.result_files import read_diagnosis
from testbench.studio import models
from testbench.studio.pages.campaign.compensate import score_path
from testbench.studio.pages.campaign.fit_form import add_fit_form, refit_instead
from testbench.studio.parts.address import Address, address
from testbench.studio.parts.fields import asked
from testbench.studio.parts.picture import plot
from testbench.studio.parts.starting import join_running, run_in_turn
from testbench.studio.parts.widgets import (
    KOHM,
    aside,
    button,
    campaign_head,
    download_button,
    facts,
    guarded,
    quantity_toggle,
    subheading,
    table,
    way_on,
)
from testbench.studio.studio import RESULTS_URL, Studio
from testbench.studio.workspace import RESULTS

REPORT = "report.html"


@guarded
async def page(studio: Studio, c: str = "", step: str = "", show: str = "") -> None:
    """The ladder of campaign `c`, looked at on `step`."""
    campaign_head(studio, c, "/ladder", show)
    if not models.has_model(studio, c):
        add_fit_form(studio, c)
        return
    where = Address("/ladder", c=c, step=step, show=show)
    looked_at = asked(where, "step", None)
    try:
        ladder = await aside(_Ladder, studio, c, where)
    except UserError:
        if await refit_instead(studio, c):
            return
        raise
    await ladder.build(-1 if looked_at is None else int(looked_at))


class _Ladder:
    """One model file on the page."""

    def __init__(self, studio: Studio, c: str, where: Address) -> None:
        from testbench.comparing.judged import held_samples
        from testbench.report.overlays import steps_in_resistance, steps_of, zero_in_words

        self.studio, self.c, self.where = studio, c, where
        self.kohm = where.query["show"] == KOHM
        catalogue = studio.effects.catalogue()
        self.file: ModelFile = load_model_file(models.model_path(studio, c), catalogue)
        other = models.held_out_recording(studio, c)
        self.judged = held_samples(self.file, studio.workspace.recording(c), other)
        self.steps, self.zero = steps_of(self.file.history), zero_in_words(self.file)
        # How far above the noise is told of what was fitted, which is ln G where the resistance is shown.
        self.over_noise = [step.over_noise for step in self.steps]
        if self.kohm:
            self.steps = steps_in_resistance(self.file, catalogue, self.judged)

    async def build(self, step: int) -> None:
        """Figures, slider, buttons."""
        last = len(self.steps) - 1
        step = last if not 0 <= step <= last else step
        if "conductance" in self.judged.measured:
            quantity_toggle(self.where)
        self.facts = ui.column().classes("w-full")
        self.ladder = plot(figures.ladder(self.steps, step), figures.LADDER_CAPTION)
        for note in (*ladder_notes(step.label for step in self.steps), self.zero):
            if note:
                ui.label(note).classes("quiet text-sm")
        self._slider(step, last)
        self._tell(step)
        self._buttons(last)
        self.glance = plot(await aside(self._glance, step), figures.GLANCE_CAPTION)
        for led_to, path in models.kept_diagnoses(self.studio, self.c).items():
            self._why(led_to, read_diagnosis(path))
        parameters = parameter_table(self.file.fit, self.file.model)
        if parameters:
            subheading("The model's parameters", "After the last step; what speaks against a value stands beside it.")
            table(parameters.head, parameters.rows, parameters.caption)

    def _slider(self, step: int, last: int) -> None:
        with ui.column().classes("card gap-1"):
            alone = "One step so far. Ask what is missing to find the next."
            subheading("Through the history", "Move along the steps; the pictures follow." if last else alone)
            slider = ui.slider(min=0, max=max(last, 1), step=1, value=step)
            slider.props("label snap markers aria-label='Step of the ladder'").set_enabled(last > 0)
        slider.on_value_change(lambda event: self._go(int(event.value)))

    def _why(self, step: int, diagnosis: Mapping[str, Any]) -> None:
        """The diagnosis that led to a step, as it was then."""
        found = listed([spoken(one["law"]) for one in diagnosis["found"]])
        title = f"The diagnosis before step {step}{f': it found {found}' if found else ''}"
        with ui.expansion(title, icon="search").classes("card").style("padding:0"):
            ui.label(verdict_in_words(diagnosis)).style("font-weight:600")
            if diagnosis["ranking"]:
                caption = "What a refit with each effect took off the held-out error, as it was found then."
                plot(diagnosis_figures.candidates(diagnosis), caption)

    def _tell(self, step: int) -> None:
        chosen = self.steps[step]
        pairs = [("this step" if step else "the first model", spoken(chosen.label))]
        pairs += [(f"held-out {channel}", with_unit(error, channel)) for channel, error in chosen.errors.items()]
        pairs += [
            (f"the noise floor of the {channel}", f"{times:.1f} times")
            for channel, times in self.over_noise[step].items()
        ]
        if step:
            pairs.append(("against the first model", fall_in_words(self.steps[0], chosen)))
        self.facts.clear()
        with self.facts:
            facts(pairs)

    async def _go(self, step: int) -> None:
        step = min(step, len(self.steps) - 1)
        self._tell(step)
        self.ladder.show(figures.ladder(self.steps, step))
        self.where.note(step=str(step))
        glance = await aside(self._glance, step)
        if self.where.query["step"] == str(step):  # no other step has been chosen meanwhile
            self.glance.show(glance)

    def _glance(self, step: int) -> dict:
        """The first model and that of `step` over the held-out samples."""
        from testbench.report.overlays import overlay_of

        catalogue = self.studio.effects.catalogue()
        shown = {
            self.steps[number].label: model_from_dict(self.file.history[number]["model"], catalogue, "history")
            for number in sorted({0, step})
        }
        both = overlay_of(self.judged, shown, free_offset=True).within(self.judged.counts)
        both = both.in_resistance() if self.kohm else both
        return figures.at_a_glance(both, self.steps[: step + 1], busiest_window(both))

    def _buttons(self, last: int) -> None:
        holder = ui.column().classes("w-full")
        self._written(holder)
        join_running(self.studio, f"report:{self.c}", holder, partial(self._written, holder))
        join_running(self.studio, f"model:{self.c}", holder, ui.navigate.reload)
        with ui.row():
            undo = button("Undo the last step", "undo", lambda: self._undo(holder), "outline")
            undo.set_enabled(last > 0)
            way_on("What is missing now?", "search", address("/missing", c=self.c))
            button("Report", "description", lambda: self._report(holder), "outline")
            download_button("Model as JSON", models.model_path(self.studio, self.c))

    def _written(self, holder: ui.column) -> None:
        """The report that was written last, where there is one."""
        path = self.studio.workspace.results(self.c) / REPORT
        if not path.is_file():
            return
        with holder, ui.row().classes("items-center gap-3"):
            ui.icon("description").classes("quiet")
            ui.link("Open the report", report_url(self.studio, path), new_tab=True).classes("way")
            ui.label(f"of {moment(path.stat().st_mtime)}").classes("quiet text-sm")
            name = f"{self.c.replace('/', '-')}-report.html"
            download_button("Download", path, name, "flat dense")

    def _undo(self, holder: ui.column) -> None:
        model = str(models.model_path(self.studio, self.c))
        argv = ["testbench", "add", "--undo", "--model", model, *self.studio.effects.arguments(), "-o", model]
        command = ("Taking the last step back", argv)
        models.change_model(self.studio, self.c, [command], holder, ui.navigate.reload)

    def _report(self, holder: ui.column) -> None:
        output = self.studio.workspace.results(self.c) / REPORT
        argv = ["testbench", "report", "--recording", str(self.studio.workspace.campaign(self.c).folder)]
        argv += models.same_arguments(self.studio, self.c)
        for path in models.kept_diagnoses(self.studio, self.c).values():
            argv += ["--diagnosis", str(path)]
        if models.is_fresh(self.studio, self.c):
            argv += ["--diagnosis", str(models.diagnosis_path(self.studio, self.c))]
        argv += ["--resistance"] * self.kohm
        argv += _if_there("--compensator", score_path(self.studio, self.c, "force"))
        argv += _if_there("--commands", self.studio.commands_path(self.c))
        command = (f"Writing the report of {self.c}", [*argv, "-o", str(output)])
        run_in_turn(self.studio, f"report:{self.c}", [command], holder, partial(self._written, holder))


def report_url(studio: Studio, path: Path) -> str:
    """Where the studio's own server hands out a file of the results."""
    below = path.relative_to(studio.workspace.root / RESULTS).as_posix()
    return f"{RESULTS_URL}/{quote(below)}?made={path.stat().st_mtime_ns}"


def _if_there(option: str, path: Path) -> list[str]:
    return [option, str(path)] if path.is_file() else []
