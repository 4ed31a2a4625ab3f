"""Compare: fit the baseline, lay the model over the measurement, a second one beside it, say where it fails."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from nicegui import ui

from gcode.support.errors import UserError
from testbench.comparing.cell import Cell
from testbench.comparing.words import spoken
from testbench.recordings.channels import RESISTANCE
from testbench.recordings.manifest import CSV
from testbench.report.document import Table
from testbench.report.figures import comparison_figures as figures
from testbench.report.figures import residual_figures
from testbench.report.figures.comparison_figures import Overlay
from testbench.report.parameter_table import parameter_table
from testbench.report.words import sentence, with_unit
from testbench.results.model_file import load_model_file
from testbench.studio.beside import Beside, beside_choices, beside_of, side_by_side
from testbench.studio.memory import stamp
from testbench.studio.models import LAST_THIRD, has_model, held_out_of, judged_on, model_path
from testbench.studio.pages.campaign.fit_form import PLAY, add_fit_form, refit_instead
from testbench.studio.parts.address import Address, address, span_of
from testbench.studio.parts.picture import Span, ZoomingPlot, plot
from testbench.studio.parts.widgets import (
    KOHM,
    aside,
    campaign_head,
    facts,
    guarded,
    later,
    quantity_toggle,
    subheading,
    table,
    trouble,
    way_on,
)
from testbench.studio.studio import Studio
from testbench.studio.workspace import Campaign

if TYPE_CHECKING:
    from testbench.api.models.comparing import ComparisonResult
    from testbench.comparing.compare import Comparison


@dataclass(frozen=True)
class View:
    """What the page shows."""

    both: Overlay
    compared: Comparison
    spans_s: list[tuple[float, float]]  # of the worst places: when they are seen best
    maps: Mapping[str, Mapping[str, Sequence[Cell]]]
    rms: Mapping[str, Mapping[str, float]]  # by model as drawn, then by channel
    parameters: Table | None
    notes: list[str]  # what a reader should know of the held-out recording


@guarded
async def page(
    studio: Studio, c: str = "", on: str = "", show: str = "", start: str = "", end: str = "", beside: str = ""
) -> None:
    """Model of campaign `c` over the recording that it is judged on, or over that of campaign `on`.

    `beside` is a second model: a step of its own ladder by number, or the name of another campaign.
    """
    campaign_head(studio, c, "/compare", show)
    if not has_model(studio, c):
        add_fit_form(studio, c)
        return
    asked = span_of(start, end)
    try:
        held = held_out_of(studio, c)
    except UserError as error:
        trouble(str(error))
        add_fit_form(studio, c, again=True)
        return
    on = on or judged_on(studio, c)
    where = Address("/compare", c=c, on=on, show=show, start=start, end=end, beside=beside)
    _choose(studio, c, on, where, held)
    try:
        view = await aside(view_of, studio, c, on, beside)
    except UserError:
        if await refit_instead(studio, c):
            return
        raise
    shown = view.both.in_resistance() if show == KOHM else view.both
    facts(_errors(view, shown))
    for note in view.notes:
        trouble(note)
    holder = ui.column().classes("w-full")
    caption = f"{figures.OVERLAY_CAPTION} Drag to zoom all rows."
    opened: Span = asked if asked[0] is not None or not view.spans_s else view.spans_s[0]
    seen = ZoomingPlot(partial(figures.overlay, shown), caption, shown.time_s, opened, where.note_span)
    with holder:
        _worst(view, seen)
    later(partial(_below, view, shown))
    later(partial(_anew, studio, c))


def _below(view: View, shown: Overlay) -> None:
    plot(figures.modelled_loops(shown), figures.modelled_loops_caption(shown))
    if view.parameters:
        subheading("The model's parameters", "As fitted; what speaks against a value stands beside it.")
        table(view.parameters.head, view.parameters.rows, view.parameters.caption)
    plot(residual_figures.heat_maps(shown), residual_figures.HEAT_MAPS_CAPTION)
    for channel in shown.measured:
        plot(residual_figures.profiles(view.maps[channel], channel), residual_figures.profiles_caption(channel))


def _anew(studio: Studio, c: str) -> None:
    with ui.expansion("Fit the baseline anew", icon="tune").classes("w-full"):
        add_fit_form(studio, c, again=True)


def _choose(studio: Studio, c: str, on: str, where: Address, held: str) -> None:
    own = studio.workspace.campaign(c)
    others = [other.name for other in studio.workspace.campaigns() if other.gauge_length_mm == own.gauge_length_mm]
    if on not in others:
        there = studio.workspace.campaign(on)
        raise UserError(
            f"A model is compared with recordings of its own gauge length; that of {c} has {_gauge_in_words(own)}, "
            f"and {on} has {_gauge_in_words(there)}. The tab Compare offers those that fit."
        )
    names = {name: f"{name} ({role})" if (role := _role(name, c, held)) else name for name in others}
    models = {"": "(none)", **beside_choices(studio, c)}
    beside = where.query["beside"] if where.query["beside"] in models else ""
    with ui.row().classes("items-center justify-between w-full"):
        with ui.row().classes("items-center gap-2"):
            choice = ui.select(names, value=on, label="Compared with the recording of")
            choice.style("width:min(320px, 84vw)")
            choice.on_value_change(lambda event: where.go(on=event.value, start="", end=""))
            second = ui.select(models, value=beside, label="A second model beside it")
            second.style("width:min(240px, 84vw)").on_value_change(lambda event: where.go(beside=event.value))
        with ui.row().classes("items-center gap-2"):
            if RESISTANCE in studio.workspace.campaign(on).columns:
                quantity_toggle(where)
            way_on("What is missing?", "search", address("/missing", c=c, show=where.query["show"]))


def _gauge_in_words(campaign: Campaign) -> str:
    return "none" if campaign.gauge_length_mm is None else f"{campaign.gauge_length_mm:g} mm"


def _role(name: str, c: str, held: str) -> str:
    if name == c:
        return "fitted on its first two thirds" if held == LAST_THIRD else "fitted on this"
    return "held out" if name == held else ""


def view_of(studio: Studio, c: str, on: str, beside: str = "") -> View:
    """The comparison, worked out anew when a model or the recording has changed.

    Raises
    ------
    UserError
        If there is no such second model.
    """
    recording = studio.workspace.campaign(on).folder / CSV
    second = beside_of(studio, c, beside) if beside else None
    files = stamp(model_path(studio, c), recording, studio.effects.file, second.path if second else None)
    return studio.memory.recall(("compare", c, on, beside, files), lambda: _compare(studio, c, on, second))


def _compare(studio: Studio, c: str, on: str, second: Beside | None) -> View:
    """As `testbench compare` does it, with pictures."""
    from testbench.api.models.comparing import compare
    from testbench.comparing.model_errors import rms_errors
    from testbench.report.overlays import as_read, maps_of, overlay_of, spans_of

    catalogue, path = studio.effects.catalogue(), model_path(studio, c)
    file = load_model_file(path, catalogue)
    found = compare(studio.workspace.recording(on), path, effects=catalogue)
    judged, measurement = found.judged, found.measurement
    label = spoken(str(file.history[-1]["step"])) if file.history else "model"
    drawn = ({second.label: second.model} if second else {}) | {label: file.model}
    both = overlay_of(measurement, drawn, judged.elsewhere, judged.from_s)
    rms = {
        one: rms_errors(judged.mounted(model), measurement, judged.elsewhere)
        | _kohm_error(both, one, measurement.counts, judged.elsewhere)
        for one, model in drawn.items()
    }
    notes = _notes(studio, c, found) if judged.elsewhere and judged.from_s is None else []
    shown, parameters = as_read(both, measurement), parameter_table(file.fit, file.model)
    if second:
        parameters = side_by_side((second.label, second.fit, second.model), (label, file.fit, file.model))
    maps = maps_of(found.comparison, measurement, both, judged.elsewhere)
    spans_s = spans_of(found.comparison, measurement, both)
    return View(shown, found.comparison, spans_s, maps, rms, parameters, notes)


def _notes(studio: Studio, c: str, found: ComparisonResult) -> list[str]:
    """What `testbench fit` and `compare` say of another recording, in the page's words."""
    from testbench.api.models.fitting import beyond_calibration
    from testbench.measurements.preparing import prepare

    beyond = beyond_calibration(prepare(studio.workspace.recording(c)), found.measurement)
    source = f"{found.measurement.recording.source}: "
    told = [note.removeprefix(source) for note in (beyond, *found.notes) if note]
    told = [note.replace("say `clamp_play_mm`", f"fit the baseline anew with “{PLAY}”") for note in told]
    return [note[0].upper() + note[1:] + "." for note in told]


def _kohm_error(both: Overlay, label: str, counts: np.ndarray, free_offset: bool) -> dict[str, float]:
    """RMS error of one model's resistance in kΩ; empty where none was measured."""
    view = both.in_resistance()
    if KOHM not in view.measured:
        return {}
    residual = view.residual(KOHM, label)[counts]
    return {KOHM: float(np.std(residual) if free_offset else np.sqrt(np.mean(residual**2)))}


def _errors(view: View, shown: Overlay) -> list[tuple[str, str]]:
    pairs = []
    for channel in shown.measured:
        fitted = "conductance" if channel == KOHM else channel
        for label, rms in reversed(list(view.rms.items())):
            whose = f" ({label})" if len(view.rms) > 1 else ""
            pairs.append((f"RMS error of the {channel}{whose}", with_unit(rms[channel], channel)))
        pairs.append((f"the noise floor of the {fitted}", f"{view.compared.over_noise[fitted]:.1f} times"))
    return pairs


def _worst(view: View, seen: ZoomingPlot) -> None:
    with ui.column().classes("card gap-0"):
        subheading("Where it fails, the worst first")
        compared = view.compared
        for number, (place, span_s) in enumerate(zip(compared.worst, view.spans_s, strict=True), 1):
            with ui.element("button").classes("finding").on("click", partial(seen.look, *span_s)):
                ui.label(str(number)).classes("rank")
                ui.label(place.words).classes("grow words")
                ui.label(f"{100 * place.share_of_error:.0f} % of the squared error").classes("tag")
        quiet = compared.noise_reached
        if quiet:
            ui.label(f"Nothing but noise is left in the {' and the '.join(quiet)}.").classes("quiet")
        if compared.unplaced and len(quiet) < len(compared.rms):
            ui.label(sentence(compared.unplaced)).classes("quiet")
