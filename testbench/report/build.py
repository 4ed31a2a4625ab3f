"""From files to a report: reads what the options name, calls the rooms, and puts the sections in order."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from gcode.support.console import knitbench_version
from gcode.support.errors import UserError
from testbench.recording import Recording, read_recording
from testbench.report import sections
from testbench.report.document import Report


@dataclass(frozen=True)
class Inputs:
    """What a report is made from; everything but one of them may be missing.

    Attributes
    ----------
    recordings : tuple of str
        CSVs or campaign folders. The first is what the model was fitted on.
    held_out : str, optional
        The recording that errors are judged on.
    gauge_length_mm : float, optional
        For bare CSVs.
    title : str, optional
    """

    recordings: tuple[str, ...] = ()
    held_out: str | None = None
    gauge_length_mm: float | None = None
    title: str = ""


def build_report(given: Inputs) -> Report:
    """Read the inputs and put the report together.

    Raises
    ------
    UserError
        If a file is missing or is not what the option says.
    """
    if not given.recordings:
        raise UserError("nothing to report on; name at least one --recording")
    recordings = [read_recording(path, given.gauge_length_mm) for path in given.recordings]
    parts = [
        sections.recording_section(recording, f"Recording {name_of(recording)}", f"recording-{number}")
        for number, recording in enumerate(recordings, 1)
    ]
    title = given.title or ", ".join(name_of(recording) for recording in recordings)
    return Report(title, "", [], parts, f"Made by knitbench {knitbench_version()}.")


def name_of(recording: Recording) -> str:
    """Short name of a recording: its campaign's folder, or its file without the suffix."""
    path = Path(recording.source)
    return path.parent.name if path.name == "recording.csv" else path.stem
