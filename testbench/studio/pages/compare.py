"""Compare: fit the baseline, lay the model over the measurement, say in words where it fails."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from nicegui import ui

from testbench.report import comparison_figures as figures
from testbench.report import residual_figures
from testbench.report.comparison_figures import Overlay
from testbench.report.document import Table
from testbench.report.ladder_figures import UNITS
from testbench.report.numbers import plain
from testbench.report.places import Spot, noise_reached
from testbench.studio.memory import stamp
from testbench.studio.models import LAST_THIRD, add_fit_form, held_out_of, model_path
from testbench.studio.picture import Span, ZoomingPlot, plot, zooming_plot
from testbench.studio.studio import Studio
from testbench.studio.widgets import (
    RESISTANCE,
    Address,
    address,
    aside,
    campaign_head,
    facts,
    guarded,
    later,
    quantity_toggle,
    span_of,
    subheading,
    table,
)


@dataclass(frozen=True)
class View:
    """What the page shows."""

    both: Overlay
    comparison: Mapping[str, Any]
    spots: list[Spot]
    maps: Mapping[str, Any]
    rms: Mapping[str, float]
    parameters: Table | None


@guarded
async def page(studio: Studio, c: str = "", on: str = "", show: str = "", start: str = "", end: str = "") -> None:
    """Model of campaign `c` over the recording that it is judged on, or over that of campaign `on`."""
    campaign_head(c, "/compare", show)
    if not model_path(studio, c).is_file():
        add_fit_form(studio, c)
        return
    asked, held = span_of(start, end), held_out_of(studio, c)
    on = on or (c if held == LAST_THIRD else held)
    where = Address("/compare", c=c, on=on, show=show, start=start, end=end)
    _choose(studio, c, on, where, held)
    view = await aside(view_of, studio, c, on)
    shown = view.both.in_resistance() if show == RESISTANCE else view.both
    facts(_errors(view, shown))
    holder = ui.column().classes("w-full")
    caption = (
        "Measured and modelled; under each the residual, measured minus modelled; grey: twice the noise floor. "
        "Drag to zoom all rows."
    )
    opened: Span = asked if asked[0] is not None or not view.spots else view.spots[0].span_s
    seen = zooming_plot(partial(figures.overlay, shown), caption, opened, where.note_span)
    with holder:
        _worst(view, seen)
    later(partial(_below, view, shown))


def _below(view: View, shown: Overlay) -> None:
    plot(figures.modelled_loops(shown), "The same as hysteresis loops, three half minutes.")
    if view.parameters:
        subheading("The model's parameters", "As fitted; what speaks against a value stands beside it.")
        table(view.parameters.head, view.parameters.rows, view.parameters.caption)
    plot(residual_figures.heat_maps(shown), "Orange where the model is too low, blue where it is too high.")
    for channel in shown.measured:
        caption = f"Mean residual of the {channel} over each coordinate, with two standard errors."
        plot(residual_figures.profiles(view.maps[channel], channel), caption)


def _choose(studio: Studio, c: str, on: str, where: Address, held: str) -> None:
    own = studio.workspace.campaign(c)
    others = [other.name for other in studio.workspace.campaigns() if other.gauge_length_mm == own.gauge_length_mm]
    names = {name: f"{name} ({_role(name, c, held)})" if _role(name, c, held) else name for name in others}
    with ui.row().classes("items-center justify-between w-full"):
        choice = ui.select(names, value=on, label="Compared with the recording of").props("outlined dense")
        choice.style("width:min(320px, 84vw)")
        choice.on_value_change(lambda event: where.go(on=event.value, start="", end=""))
        with ui.row().classes("items-center gap-2"):
            quantity_toggle(where)
            ask = ui.button("What is missing?", icon="search").props("unelevated")
            ask.on_click(lambda: ui.navigate.to(address("/missing", c=c, show=where.query["show"])))


def _role(name: str, c: str, held: str) -> str:
    if name == c:
        return "fitted on its first two thirds" if held == LAST_THIRD else "fitted on this"
    return "held out" if name == held else ""


def view_of(studio: Studio, c: str, on: str) -> View:
    """The comparison, worked out anew when the model or the recording has changed."""
    recording = studio.workspace.campaign(on).folder / "recording.csv"
    files = stamp(model_path(studio, c), recording, studio.effects_file)
    return studio.memory.recall(("compare", c, on, files), lambda: _compare(studio, c, on))


def _compare(studio: Studio, c: str, on: str) -> View:
    """As `testbench compare` does it; a recording whose last third is held out is judged on that third."""
    from testbench.fitting.measurement import prepare, split
    from testbench.fitting.model_file import check_same_set_up, load_model_file
    from testbench.report.overlays import failings_of, overlay_of
    from testbench.report.parameters import parameter_table

    path = model_path(studio, c)
    file = load_model_file(path, studio.catalogue())
    recording = studio.workspace.recording(on)
    check_same_set_up(file, recording, path)
    on_its_third = on == c and held_out_of(studio, c) == LAST_THIRD
    measurement = split(recording, None)[1] if on_its_third else prepare(recording)
    elsewhere = on != c or on_its_third
    label = str(file.history[-1]["step"]) if file.history else "model"
    from_s = float(measurement.grid_s[np.argmax(measurement.counts)]) if on_its_third else None
    both = overlay_of(measurement, {label: file.model}, elsewhere, from_s)
    found = failings_of(file.model, measurement, both, elsewhere)
    kohm = both.in_resistance()
    rms = {channel: _rms(view.residual(channel)[measurement.counts], elsewhere)
           for view in (both, kohm) for channel in view.measured}  # fmt: skip
    return View(both, found.comparison, found.spots, found.maps, rms, parameter_table(file.fit, file.model))


def _rms(residual: np.ndarray, free_offset: bool) -> float:
    return float(np.std(residual) if free_offset else np.sqrt(np.mean(residual**2)))


def _errors(view: View, shown: Overlay) -> list[tuple[str, str]]:
    channels = view.comparison["channels"]
    pairs = []
    for channel in shown.measured:
        source = channels["conductance" if channel == RESISTANCE else channel]
        rms = view.rms[channel] if channel == RESISTANCE else source["rms"]
        pairs.append((f"RMS error of the {channel}", f"{plain(rms)} {UNITS[channel]}"))
        pairs.append((f"times the noise floor of the {channel}", f"{source['over_noise']:.1f} x"))
    return pairs


def _worst(view: View, seen: ZoomingPlot) -> None:
    with ui.column().classes("card gap-0"):
        subheading("Where it fails, the worst first")
        for number, spot in enumerate(view.spots, 1):
            with ui.element("button").classes("finding").on("click", partial(seen.look, *spot.span_s)):
                ui.label(str(number)).classes("rank")
                ui.label(spot.words).classes("grow words")
                ui.label(f"{100 * spot.share_of_error:.0f} % of the squared error").classes("tag")
        quiet = noise_reached(view.comparison["channels"])
        if quiet:
            ui.label(f"Nothing but noise is left in the {' and the '.join(quiet)}.").classes("quiet")
        elif not view.spots:
            ui.label("No place stands out from the noise.").classes("quiet")
