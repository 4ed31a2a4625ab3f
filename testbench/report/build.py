"""From recordings, model and results to a report: makes each section, and puts them in order."""

from __future__ import annotations

from pathlib import Path

from gcode.support.console import knitbench_version
from gcode.support.errors import UserError
from testbench.report import sections
from testbench.report.document import Item, Report, Section
from testbench.report.provenance import moment, provenance
from testbench.report.story import Inputs, Story


def build_report(given: Inputs) -> Report:
    """Put a report together.

    Raises
    ------
    UserError
        If there is nothing to report on, a recording is of another set-up than the model, or a file of `given.files`
        is gone.
    """
    if not (given.recordings or given.model or given.diagnoses or given.compensator):
        raise UserError("nothing to report on; name a recording, a model, a diagnosis or a compensator")
    if given.held_out and not (given.recordings and (given.model or given.diagnoses)):
        raise UserError(
            "`held_out` is what a model is judged on, beside the recording that it was fitted on; name that "
            "recording and the model or a diagnosis, too"
        )
    opening: list[Item] = []
    parts: list[Section] = []
    verdict = ""
    if given.model or given.diagnoses:
        story = Story.of(given)
        verdict, opening = story.verdict(), story.opening()
        parts += story.parts()
    if given.compensator:
        parts.append(sections.compensator_section(given.compensator))
    parts += [
        sections.recording_section(
            recording, f"Recording {sections.short_name(recording.source)}", f"recording-{n}", given.resistance
        )
        for n, recording in enumerate(given.recordings, 1)
    ]
    parts.append(provenance(given.files, given.commands))
    names = ", ".join(sections.short_name(recording.source) for recording in given.recordings)
    title = given.title or names or (Path(given.files[0]).stem if given.files else "Report")
    return Report(title, verdict, opening, parts, f"Made by knitbench {knitbench_version()}.", moment())
