"""From recordings, model and results to a report: makes each section, and puts them in order."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from gcode.support.console import knitbench_version
from gcode.support.errors import UserError
from testbench.knit.catalogue import Catalogue, load_catalogue
from testbench.recordings.recording import Recording
from testbench.report import sections
from testbench.report.document import Item, Report, Section
from testbench.report.provenance import moment, provenance
from testbench.report.story import Story
from testbench.results.model_file import ModelFile


@dataclass(frozen=True)
class Inputs:
    """What a report is made from; each may be missing, but not all.

    Attributes
    ----------
    recordings : tuple of Recording
        The first is what the model was fitted on.
    held_out : Recording, optional
        The recording that errors are judged on.
    model : ModelFile, optional
    model_name : str
        What an error calls the model: its file.
    catalogue : Catalogue
        With the user's own effects.
    diagnoses : tuple of mapping
        JSON of ``testbench diagnose``, the oldest first: those that led to the steps of the model, and the last one.
        Without a model, the last one's own before and after are shown.
    compensator : mapping, optional
        The JSON of ``compensation score``.
    files : tuple of str
        Where all of these came from, for their checksums.
    commands : str, optional
        A text file with the command lines that led here.
    title : str
        Empty: made of the names.
    resistance : bool
        Show the resistance in kΩ wherever the conductance would be.
    """

    recordings: tuple[Recording, ...] = ()
    held_out: Recording | None = None
    model: ModelFile | None = None
    model_name: str = "model"
    catalogue: Catalogue = field(default_factory=load_catalogue)
    diagnoses: tuple[Mapping[str, Any], ...] = ()
    compensator: Mapping[str, Any] | None = None
    files: tuple[str, ...] = ()
    commands: str | None = None
    title: str = ""
    resistance: bool = False


def build_report(given: Inputs) -> Report:
    """Put a report together.

    Raises
    ------
    UserError
        If there is nothing to report on, a recording is of another set-up than the model, or a file of `given.files`
        is gone.
    """
    if not (given.recordings or given.model or given.diagnoses or given.compensator):
        raise UserError("nothing to report on; name a --recording, --model, --diagnosis or --compensator")
    if given.held_out and not given.recordings:
        raise UserError("--held-out is judged beside the --recording that the model was fitted on; name that as well")
    opening: list[Item] = []
    parts: list[Section] = []
    verdict = ""
    if given.model or given.diagnoses:
        last = given.diagnoses[-1] if given.diagnoses else None
        story = Story.of(
            given.model,
            given.model_name,
            last,
            given.catalogue,
            given.recordings,
            given.held_out,
            given.resistance,
        )
        verdict, opening = story.verdict(last), story.opening()
        parts += story.parts(given.diagnoses)
    if given.compensator:
        parts.append(sections.compensator_section(given.compensator))
    parts += [
        sections.recording_section(
            recording, f"Recording {sections.short_name(recording.source)}", f"recording-{n}", given.resistance
        )
        for n, recording in enumerate(given.recordings, 1)
    ]
    parts.append(provenance(given.files, given.commands))
    return Report(_title(given), verdict, opening, parts, f"Made by knitbench {knitbench_version()}.", moment())


def _title(given: Inputs) -> str:
    names = ", ".join(sections.short_name(recording.source) for recording in given.recordings)
    return given.title or names or (Path(given.files[0]).stem if given.files else "Report")
