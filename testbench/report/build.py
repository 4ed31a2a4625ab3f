"""From files to a report: reads what the options name, calls the rooms, and puts the sections in order."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gcode.support.console import knitbench_version
from gcode.support.errors import UserError
from gcode.support.files import read_json
from testbench.recordings.files import read_recording
from testbench.report import sections
from testbench.report.document import Item, Report, Section
from testbench.report.provenance import provenance, today
from testbench.report.story import Story

SCORE_FORMAT = "knitbench-score"
IN_A_DIAGNOSIS = ("verdict", "probabilities", "found", "ranking", "error_before", "error_after", "noise_floor")


@dataclass(frozen=True)
class Inputs:
    """What a report is made from; each may be missing, but not all.

    Attributes
    ----------
    recordings : tuple of str
        CSVs or campaign folders. The first is what the model was fitted on.
    held_out : str, optional
        The recording that errors are judged on.
    gauge_length_mm : float, optional
        For bare CSVs.
    model, effects : str, optional
        A model.json, and the user's own effects in it.
    diagnoses : tuple of str
        JSON of ``testbench diagnose``, the oldest first: those that led to the steps of the model, and the last one.
        Without a model, the last one's own before and after are shown.
    compensator : str, optional
        The JSON of ``compensation score``.
    title : str, optional
    commands : str, optional
        A text file with the command lines that led here.
    resistance : bool
        Show the resistance in kΩ wherever the conductance would be.
    """

    recordings: tuple[str, ...] = ()
    held_out: str | None = None
    gauge_length_mm: float | None = None
    model: str | None = None
    effects: str | None = None
    diagnoses: tuple[str, ...] = ()
    compensator: str | None = None
    title: str = ""
    commands: str | None = None
    resistance: bool = False


def build_report(given: Inputs) -> Report:
    """Read the inputs and put the report together.

    Raises
    ------
    UserError
        If a file is missing or is not what the option says.
    """
    if not (given.recordings or given.model or given.diagnoses or given.compensator):
        raise UserError("nothing to report on; name a --recording, --model, --diagnosis or --compensator")
    recordings = [read_recording(path, given.gauge_length_mm) for path in given.recordings]
    held_out = read_recording(given.held_out, given.gauge_length_mm) if given.held_out else None
    diagnoses = [read_diagnosis(path) for path in given.diagnoses]
    opening: list[Item] = []
    parts: list[Section] = []
    verdict = ""
    if given.model or diagnoses:
        last = diagnoses[-1] if diagnoses else None
        story = Story.of(given.model, last, given.effects, recordings, held_out, given.resistance)
        verdict, opening = story.verdict(last), story.opening()
        parts += story.parts(diagnoses)
    if given.compensator:
        parts.append(sections.compensator_section(read_score(given.compensator)))
    parts += [
        sections.recording_section(
            recording, f"Recording {sections.short_name(recording.source)}", f"recording-{n}", given.resistance
        )
        for n, recording in enumerate(recordings, 1)
    ]
    parts.append(provenance(_files_of(given), given.commands))
    names = ", ".join(sections.short_name(recording.source) for recording in recordings)
    title = given.title or names or Path(given.model or (*given.diagnoses, given.compensator or "")[0]).stem
    return Report(title, verdict, opening, parts, f"Made by knitbench {knitbench_version()}.", today())


def _files_of(given: Inputs) -> list[str]:
    named = (*given.recordings, given.held_out, given.model, given.effects, *given.diagnoses, given.compensator)
    return [path for path in named if path]


def read_score(path: str) -> Mapping[str, Any]:
    """What `compensation score -o` wrote.

    Raises
    ------
    UserError
        If it is missing or is something else.
    """
    data = read_json(path, "score")
    if not isinstance(data, dict) or data.get("format") != SCORE_FORMAT:
        raise UserError(
            f"{path}: not a score (its format must be {SCORE_FORMAT!r}); `compensation score -o` writes one"
        )
    return data


def read_diagnosis(path: str) -> Mapping[str, Any]:
    """What `testbench diagnose --json` wrote.

    Raises
    ------
    UserError
        If it is missing or is something else.
    """
    data = read_json(path, "diagnosis")
    if not isinstance(data, dict) or any(key not in data for key in IN_A_DIAGNOSIS):
        raise UserError(f"{path}: not a diagnosis of this version; `testbench diagnose --json FILE` writes one")
    return data
