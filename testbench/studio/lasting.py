"""How long a recording lasts, told by the first and the last row of its file, so that many are asked in no time."""

from __future__ import annotations

import os
from pathlib import Path

from gcode.support.errors import UserError
from gcode.support.strict import open_plain
from testbench.recordings.channels import TIME

MOST_OF_A_ROW = 1 << 14  # bytes


def lasts_s(path: Path) -> float:
    """From the first sample of a ``recording.csv`` to the last, gaps included; 0 where none can be read."""
    try:
        with os.fdopen(open_plain(path, "recording"), "rb") as stream:
            names = stream.readline(MOST_OF_A_ROW).decode().strip().split(",")
            first = stream.readline(MOST_OF_A_ROW)
            stream.seek(max(stream.tell() - len(first), os.fstat(stream.fileno()).st_size - MOST_OF_A_ROW))
            whole = stream.read().rpartition(b"\n")[0]  # the last line of a growing file may be half of one
        last = whole.rpartition(b"\n")[2]
        begun_s, ended_s = (float(row.split(b",")[names.index(TIME)]) for row in (first, last))
    except (UserError, OSError, ValueError, IndexError):
        return 0.0
    return ended_s - begun_s
