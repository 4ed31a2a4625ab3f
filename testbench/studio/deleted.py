"""Campaigns that were moved out of sight with their notes and what was made from them, until they are restored."""

from __future__ import annotations

import contextlib
import time
from pathlib import Path

from gcode.support.errors import UserError
from gcode.support.files import make_folder, write_text
from gcode.support.strict import read_text
from testbench.studio.notes import FILE as NOTES
from testbench.studio.notes import Note, Notes
from testbench.studio.workspace import DELETED, DELETED_AT, Workspace, results_name

NAME, CAMPAIGN, RESULTS = "name.txt", "campaign", "results"  # of one deleted campaign, in a folder of its own
MOST_NAME_BYTES = 4096


class Deleted:
    """The deleted campaigns of a workspace, below its results; `notes` are those of the campaigns that are there."""

    def __init__(self, workspace: Workspace, notes: Notes) -> None:
        self.workspace, self.notes = workspace, notes

    def add(self, name: str) -> Path:
        """Move a campaign, its note and what was made from it out of sight; where they are now."""
        folder, note = self.workspace.campaign(name).folder, self.notes.of(name)
        place = make_folder(self.workspace.kept(DELETED, f"{time.strftime(DELETED_AT)}{results_name(name)}"))
        write_text(place / NAME, f"{name}\n")
        made = self.workspace.results(name)
        if made.is_dir():
            made.replace(place / RESULTS)
        folder.replace(place / CAMPAIGN)
        if note != Note():
            Notes(place).put(name, note)
            self.notes.put(name, Note())
        return place

    def all(self) -> list[tuple[str, Path]]:
        """Deleted campaigns by name, the last first, and where they are now."""
        places = sorted((self.workspace.kept() / DELETED).glob(f"*/{NAME}"), reverse=True)
        return [(_name_in(path.parent), path.parent) for path in places]

    def restore(self, place: Path) -> str:
        """Bring a deleted campaign back; its name.

        Where other results have been made since, the old ones stay in `place` and can be restored once those are
        gone.

        Raises
        ------
        UserError
            If its name has been taken since, or its results have and it has come back already.
        """
        name, waits = _name_in(place), (place / CAMPAIGN).is_dir()
        if waits:
            folder = self.workspace.untaken(name)
            make_folder(folder.parent)
            (place / CAMPAIGN).replace(folder)
            self.notes.put(name, Notes(place).of(name))
        if (place / RESULTS).is_dir():
            with contextlib.suppress(OSError):  # taken by other results; an empty folder is replaced
                (place / RESULTS).replace(self.workspace.results(name))
        if not (place / RESULTS).is_dir():
            for file in (NAME, NOTES):
                (place / file).unlink(missing_ok=True)
            place.rmdir()
        elif not waits:
            there = self.workspace.results(name)
            raise UserError(f"{name} has other results now: move {there} away to have the old ones back")
        return name


def _name_in(place: Path) -> str:
    return read_text(place / NAME, "name", MOST_NAME_BYTES).strip()
