"""What a report is made from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from testbench.knit.catalogue import Catalogue, load_catalogue
from testbench.recordings.recording import Recording
from testbench.results.model_file import ModelFile


@dataclass(frozen=True)
class Inputs:
    """Recordings, model and results; each may be missing, but not all.

    Attributes
    ----------
    recordings, held_out, diagnoses, compensator, commands, title, resistance
        As `testbench.make_report` takes them, and read.
    model_name : str
        What an error calls the model: its file.
    catalogue : Catalogue
        With the user's own effects.
    files : tuple of str
        Where all of these came from, for their checksums.
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
