"""A recording that came from a foreign file: what was done to get it, and how it is written."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from testbench.recordings.files import write_recording_csv
from testbench.recordings.manifest import CSV, Campaign, write_manifest
from testbench.recordings.recording import Recording
from testbench.recordings.versions import software_versions


@dataclass
class Imported:
    """A recording, and what was done to get it.

    Attributes
    ----------
    recording : Recording
    label : str
        Number of the repeat, where the file has several; else empty.
    dropped : int
        Rows left out because of a value that cannot be used.
    moved, repeated : int
        Rows that were out of order; rows whose time came twice.
    time_offset_s : float
        Subtracted from the file's times, so that the first sample is at 0.
    taken : dict of str to str
        What was taken for what, with the conversion shown.
    doubts : list of str
        What looks wrong, with the remedy.
    notes : list of str
        What else was done or left out.
    details : dict
        For the manifest.
    """

    recording: Recording
    label: str = ""
    dropped: int = 0
    moved: int = 0
    repeated: int = 0
    time_offset_s: float = 0.0
    taken: dict[str, str] = field(default_factory=dict)
    doubts: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    details: dict[str, Any] = field(default_factory=dict)

    @property
    def words(self) -> list[str]:
        """What came of it, a sentence each: size and ranges, rows left out or moved, notes, and doubts."""
        recording = self.recording
        changed = (
            (self.dropped, "left out"),
            (self.moved, "put in order"),
            (self.repeated, "with a repeated time dropped"),
        )
        rows = [f"{number} row{'s' if number > 1 else ''} {what}" for number, what in changed if number]
        ranges = [f"{name} {values.min():.6g} to {values.max():.6g}" for name, values in recording.channels.items()]
        size = f"{len(recording)} samples in {recording.duration_s:.1f} s, {recording.mean_rate_hz:.3g} Hz"
        said = [f"{size}: {', '.join(ranges)}", *([", ".join(rows)] if rows else []), *self.notes]
        return [*said, *(f"LOOK: {doubt}" for doubt in self.doubts)]

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready form: repeat, samples, duration, rate, ranges of the channels, and all that was done."""
        recording = self.recording
        ranges = {name: [float(values.min()), float(values.max())] for name, values in recording.channels.items()}
        told = ("taken", "doubts", "notes", "dropped", "moved", "repeated", "details")
        return {
            "repeat": self.label,
            "samples": len(recording),
            "duration_s": recording.duration_s,
            "mean_rate_hz": recording.mean_rate_hz,
            "channels": ranges,
        } | {name: getattr(self, name) for name in told}


def place_of(out: Path, label: str) -> Path:
    """Where a repeat goes: ``knit-3`` for ``knit``, ``knit-3.csv`` for ``knit.csv``."""
    return out.with_name(f"{out.stem}-{label}{out.suffix}") if label else out


def write_import(imported: Imported, folder: Path) -> None:
    """Write a campaign into an empty folder."""
    write_recording_csv(folder / CSV, imported.recording)
    recipe = {"import": imported.details, "time_offset_s": imported.time_offset_s}
    counts = {"samples": len(imported.recording), "dropped": imported.dropped}
    counts |= {"moved": imported.moved, "repeated": imported.repeated}
    gauge = imported.recording.gauge_length_mm
    campaign = Campaign(gauge, "imported", "complete", recipe, counts, software_versions())
    write_manifest(folder, campaign, [CSV])
