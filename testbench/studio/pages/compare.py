"""Compare: fit the baseline, lay the model over the measurement, say in words where it fails."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

from nicegui import ui

from testbench.report import comparison_figures as figures
from testbench.report import residual_figures
from testbench.report.comparison_figures import Overlay
from testbench.studio.memory import stamp
from testbench.studio.models import add_fit_form, model_path
from testbench.studio.picture import plot, zooming_plot
from testbench.studio.studio import Studio
from testbench.studio.widgets import address, aside, campaign_head, facts, guarded, later, subheading


@dataclass(frozen=True)
class View:
    """What the page shows."""

    both: Overlay
    comparison: Mapping[str, Any]


@guarded
async def page(studio: Studio, c: str = "", on: str = "") -> None:
    """Model of campaign `c` over its own recording, or over that of campaign `on`."""
    campaign_head(c, "/compare")
    if not model_path(studio, c).is_file():
        add_fit_form(studio, c)
        return
    _choose(studio, c, on)
    view = await aside(view_of, studio, c, on or c)
    facts(_errors(view.comparison["channels"]))
    _worst(view.comparison["worst"])
    caption = (
        "Measured and modelled; under each the residual, measured minus modelled; grey: twice the noise floor. "
        "Drag to zoom all rows."
    )
    zooming_plot(partial(figures.overlay, view.both), caption)
    later(partial(_below, view))


def _below(view: View) -> None:
    plot(figures.modelled_loops(view.both), "The same as hysteresis loops, three half minutes.")
    plot(residual_figures.heat_maps(view.both), "Orange where the model is too low, blue where it is too high.")
    for channel, entry in view.comparison["channels"].items():
        caption = f"Mean residual of the {channel} over each coordinate, with two standard errors."
        plot(residual_figures.profiles(entry["maps"], channel), caption)


def _choose(studio: Studio, c: str, on: str) -> None:
    own = studio.workspace.campaign(c)
    others = [other.name for other in studio.workspace.campaigns() if other.gauge_length_mm == own.gauge_length_mm]
    with ui.row().classes("items-center justify-between w-full"):
        choice = ui.select(others, value=on or c, label="Compared with the recording of").props("outlined dense")
        choice.style("min-width:280px")
        choice.on_value_change(lambda event: ui.navigate.to(address("/compare", c=c, on=event.value)))
        ui.button("What is missing?", icon="search", on_click=lambda: ui.navigate.to(address("/missing", c=c))).props(
            "unelevated"
        )


def view_of(studio: Studio, c: str, on: str) -> View:
    """The comparison, worked out anew when the model or the recording has changed."""
    recording = studio.workspace.campaign(on).folder / "recording.csv"
    files = stamp(model_path(studio, c), recording, studio.effects_file)
    return studio.memory.recall(("compare", c, on, files), lambda: _compare(studio, c, on))


def _compare(studio: Studio, c: str, on: str) -> View:
    """As `testbench compare` does it."""
    from testbench.discrepancy.compare import compare
    from testbench.discrepancy.measurement import prepare
    from testbench.discrepancy.model_file import check_same_set_up, load_model_file
    from testbench.report.overlays import overlay_of

    path = model_path(studio, c)
    file = load_model_file(path, studio.catalogue())
    recording = studio.workspace.recording(on)
    check_same_set_up(file, recording, path)
    measurement, elsewhere = prepare(recording), on != c
    label = str(file.history[-1]["step"]) if file.history else "model"
    both = overlay_of(measurement, {label: file.model}, elsewhere)
    return View(both, compare(file.model, measurement, free_offset=elsewhere).to_dict())


def _errors(channels: Mapping[str, Mapping[str, Any]]) -> list[tuple[str, str]]:
    pairs = []
    for channel, entry in channels.items():
        pairs.append((f"RMS error of the {channel}", f"{entry['rms']:.3g} {entry['unit']}"))
        pairs.append((f"times the noise floor of the {channel}", f"{entry['over_noise']:.1f} x"))
    return pairs


def _worst(places: list[Mapping[str, Any]]) -> None:
    with ui.column().classes("card gap-0"):
        subheading("Where it fails, the worst first")
        if not places:
            ui.label("No place stands out from the noise.").classes("quiet")
        for number, place in enumerate(places, 1):
            with ui.element("div").classes("finding"):
                ui.label(str(number)).classes("rank")
                ui.label(place["words"]).classes("grow")
                ui.label(f"{100 * place['share_of_error']:.0f} % of the squared error").classes("tag")
