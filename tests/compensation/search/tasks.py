"""Searches on short recordings."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from compensation.search.search import Task
from testbench.recordings.files import write_recording_csv
from testbench.recordings.recording import Recording


def task_of(recordings: Sequence[Recording], seconds: float, folder: Path) -> Task:
    """A search on the beginning of three recordings, written into `folder`."""
    paths = [folder / f"{name}.csv" for name in "TAB"]
    for path, recording in zip(paths, recordings, strict=True):
        write_recording_csv(path, recording.between(0, seconds))
    return Task(tuple(map(str, paths)), 25.0, "force", "fast")
