"""Whole lines of a file that grows, as they come."""

from __future__ import annotations

import os
from pathlib import Path

from gcode.support.errors import UserError
from gcode.support.strict import open_plain

AT_ONCE_BYTES = 1 << 22  # at most this much in one look; the rest waits for the next


class Tail:
    """What has been appended to a file since the last look.

    Parameters
    ----------
    path : Path
        May not exist yet.
    last_bytes : int, optional
        How much of what is there already is read; default: all.
    """

    def __init__(self, path: Path, last_bytes: int | None = None) -> None:
        self.path = path
        size = path.stat().st_size if last_bytes is not None and path.exists() else 0
        self._offset = max(0, size - (last_bytes or 0))
        self._torn = self._offset > 0  # what comes first is the end of a line
        self._rest = b""

    def fresh(self) -> list[str]:
        """The lines; a line without its end waits for the next look."""
        try:
            with os.fdopen(open_plain(self.path, "file"), "rb") as stream:
                new = os.fstat(stream.fileno()).st_size - self._offset  # what has no size would never end
                stream.seek(self._offset)
                raw = stream.read(min(max(new, 0), AT_ONCE_BYTES))
        except UserError:  # it is not there yet
            return []
        self._offset += len(raw)
        whole, newline, self._rest = (self._rest + raw).rpartition(b"\n")
        if not newline:
            return []
        lines = whole.decode("utf-8", "replace").split("\n")[self._torn :]
        self._torn = False
        return [line.rstrip("\r") for line in lines]
