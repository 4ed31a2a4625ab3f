"""Side by side: two campaigns, what was recorded of each and what their models say."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from nicegui import ui

from testbench.comparing.words import spoken
from testbench.diagnosis.verdict import verdict_clauses
from testbench.recordings.recording import Recording
from testbench.report.figures import recording_figures as figures
from testbench.report.words import with_unit
from testbench.results.model_file import about_model
from testbench.results.result_files import read_diagnosis, read_score
from testbench.studio import models
from testbench.studio.beside import side_by_side
from testbench.studio.pages.campaign.compensate import score_path
from testbench.studio.parts.address import Address, address
from testbench.studio.parts.picture import plot
from testbench.studio.parts.widgets import KOHM, aside, guarded, heading, invitation, quantity_toggle, table, way_on
from testbench.studio.studio import Studio


@dataclass(frozen=True)
class Side:
    """One of the two."""

    name: str
    recording: Recording
    facts: Mapping[str, str]
    fit: Mapping[str, Any]


@guarded
async def page(studio: Studio, a: str = "", b: str = "", show: str = "") -> None:
    """Campaigns `a` and `b`."""
    heading("Side by side", "Two recordings and their models.")
    if not a or not b:
        with invitation("Nothing is compared yet", "Choose two campaigns in the list, and compare them."):
            way_on("Campaigns", "grid_view", "/")
        return
    where = Address("/side", a=a, b=b, show=show)
    quantity_toggle(where)
    kohm = show == KOHM
    sides = [await aside(_side, studio, name, kohm) for name in (a, b)]
    names = list(dict.fromkeys(key for side in sides for key in side.facts))
    with ui.row().classes("w-full gap-4"):
        for side in sides:
            ui.link(side.name, address("/recording", c=side.name)).classes("way")
    told = [(name, *(side.facts.get(name, "") for side in sides)) for name in names]
    table(("", a, b), [row for row in told if any(row[1:])])
    parameters = side_by_side(*((side.name, side.fit, None) for side in sides))
    if parameters.rows:
        table(parameters.head, parameters.rows, parameters.caption)
    for side in sides:
        loops = figures.hysteresis_loops(side.recording, kohm)
        if loops:
            plot(loops, f"{side.name}: {figures.loops_in_words(side.recording)}.")


def _side(studio: Studio, name: str, kohm: bool) -> Side:
    campaign, recording = studio.workspace.campaign(name), studio.workspace.recording(name)
    told = dict(figures.summary(recording, kohm))
    told |= {"Origin": campaign.origin, "Specimen": campaign.specimen, "Tags": ", ".join(studio.notes.of(name).tags)}
    path = models.model_path(studio, name)
    if not path.is_file():
        return Side(name, recording, told | {"Model": "not fitted"} | _score(studio, name), {})
    file = about_model(path)
    told |= _model_facts(file) | _verdict(studio, name) | _score(studio, name)
    return Side(name, recording, told, file.get("fit", {}))


def _model_facts(file: Mapping[str, Any]) -> dict[str, str]:
    steps = file.get("history") or []
    if not steps:
        return {"Model": "fitted"}
    told = {"Model": " ".join(spoken(step["step"]) for step in steps)}
    for channel, error in steps[-1]["errors"]["held_out"].items():
        floor = steps[-1]["noise_floor"].get(channel, 0.0)
        times = f" ({error / floor:.1f} times the noise)" if floor > 0 else ""
        told[f"Held-out error of the {channel}"] = with_unit(error, channel) + times
    return told


def _verdict(studio: Studio, name: str) -> dict[str, str]:
    path = models.diagnosis_path(studio, name)
    if not path.is_file():
        return {}
    return {"Last diagnosis": verdict_clauses(read_diagnosis(path))[0]}


def _score(studio: Studio, name: str) -> dict[str, str]:
    path = score_path(studio, name, "force")
    if not path.is_file():
        return {}
    summary = read_score(path)["summary"]
    return {"r² of the force, compensated": f"{summary['r2_after']:.3f} (raw {summary['r2_before']:.3f})"}
