"""Where a report came from: when, from which bytes, by which commands."""

from __future__ import annotations

import time
from collections.abc import Iterable
from pathlib import Path

from gcode.support.files import sha256_of
from gcode.support.strict import read_text
from testbench.recordings.manifest import CSV
from testbench.report.document import Item, Section, Table

MOST_BYTES = 1 << 20


def moment(since_1970_s: float | None = None) -> str:
    """``22 November 2026, 17:05``, in this machine's time; now, where no time is given."""
    return time.strftime("%d %B %Y, %H:%M", time.localtime(since_1970_s)).lstrip("0")


def provenance(paths: Iterable[str], commands: str | None) -> Section:
    """The inputs with their checksums, and the commands where they were kept.

    Raises
    ------
    UserError
        If the file of commands cannot be read.
    """
    rows = []
    for path in dict.fromkeys(paths):
        file = Path(path) / CSV if Path(path).is_dir() else Path(path)
        rows.append((str(file), sha256_of(file)))
    items: list[Item] = [Table(("File", "SHA-256"), rows)] if rows else []
    if commands:
        items.append(Table(("When", "Command"), _commands(Path(commands))))
    return Section("How this was made", items or ["All of it was given in memory: no file is known."])


def _commands(path: Path) -> list[tuple[str, str]]:
    """Lines of ``date time  command``; a line without a date is a command."""
    rows = []
    for line in filter(str.strip, read_text(path, "list of commands", MOST_BYTES).splitlines()):
        when, gap, command = line.partition("  ")
        rows.append((when, command) if gap and when[:1].isdigit() else ("", line.strip()))
    return rows
