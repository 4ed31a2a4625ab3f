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
