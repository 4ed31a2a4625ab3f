"""Tags and notes that people put on campaigns; the campaigns themselves stay as they were written."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass
from pathlib import Path

from gcode.support.errors import UserError
from gcode.support.files import make_folder, write_json
from gcode.support.strict import StrictModel, read_json, validated
from testbench.studio.memory import stamp

FILE = "notes.json"
MOST_BYTES = 64 << 20


@dataclass(frozen=True)
class Note:
    """What was said of one campaign."""

    tags: tuple[str, ...] = ()
    text: str = ""


class _Stored(StrictModel):
    tags: tuple[str, ...] = ()
    note: str = ""


class Notes:
    """All notes of a workspace, in one file below its results; read anew when another tab has changed it."""

    def __init__(self, folder: Path) -> None:
        self._path = folder / FILE
        self._mark: tuple = ()
        self._notes: dict[str, Note] = {}

    def all(self) -> dict[str, Note]:
        """Notes by campaign; those read last where the file is damaged now."""
        with contextlib.suppress(UserError):
            self._look()
        return self._notes

    def _look(self) -> None:
        if self._path.exists() and (mark := stamp(self._path)) != self._mark:
            told = read_json(self._path, "list of notes", MOST_BYTES)
            kept = validated(told, dict[str, _Stored], self._path, "list of notes")
            self._notes = {name: Note(one.tags, one.note) for name, one in kept.items()}
            self._mark = mark

    def of(self, name: str) -> Note:
        """The note on one campaign; empty where there is none."""
        return self.all().get(name, Note())

    def put(self, name: str, note: Note) -> None:
        """Keep a note; an empty one takes the old one away.

        Raises
        ------
        UserError
            If the file is damaged: those in it would be lost.
        """
        self._look()
        notes = {**self._notes, name: note}
        kept = {key: {"tags": list(one.tags), "note": one.text} for key, one in notes.items() if one != Note()}
        make_folder(self._path.parent)
        write_json(self._path, kept)


def tags_of(text: str) -> tuple[str, ...]:
    """``"wet, PES , wet"`` as tags, each once."""
    return tuple(dict.fromkeys(filter(None, (part.strip() for part in text.split(",")))))
