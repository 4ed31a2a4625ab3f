"""Where an interrupted recording stood: read from its files, as a killed recorder left them."""

from __future__ import annotations

import json
import os
import re
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gcode.support.errors import UserError
from testbench.recording import DISPLACEMENT
from testbench.rig.ending import EndOfMotion
from testbench.rig.sink import BAD, CSV, EVENTS
from testbench.rig.stream import Anchor, Intake
from testbench.rig.wire import MICROS_WRAP

_ROW = re.compile(rb"\d+\.\d{6}(,-?\d+\.\d+)+")


@dataclass
class Left:
    """What a recorder left behind.

    Attributes
    ----------
    channels : tuple of str or None
        From the header; None if not even that was written.
    rows : int
    last_time_us : int or None
        Of the last whole row.
    idle_s : float
        Wall-clock time since the recording was last written.
    events : list of dict
    bad : Counter
        Rejected lines by reason.
    displacements_nm : list of (time_us, displacement_nm)
        Of every row: to find the first movement again, and how many rows came since an event.
    """

    channels: tuple[str, ...] | None
    rows: int
    last_time_us: int | None
    idle_s: float
    events: list[dict[str, Any]]
    bad: Counter[str]
    displacements_nm: list[tuple[int, int]]


def mend(folder: Path, wall_s: float) -> Left:
    """Cut unfinished tails off the files in `folder` and read where they end.

    Parameters
    ----------
    folder : Path
    wall_s : float
        Now, in the clock of file times.
    """
    idle_s = max(0.0, wall_s - (folder / CSV).stat().st_mtime) if (folder / CSV).exists() else 0.0
    lines = _whole_lines(folder / CSV)
    rows = lines[1:]
    while rows and not _ROW.fullmatch(rows[-1]):
        rows.pop()  # a power cut may leave blocks of zeros
    _cut(folder / CSV, lines[:1] + rows)
    bad = _cut(folder / BAD, _whole_lines(folder / BAD))
    names = tuple(lines[0].decode().split(",")[1:]) if lines else None
    column = names.index(DISPLACEMENT) + 1 if names else 0
    cells = [row.split(b",") for row in rows]
    last_time_us = _fixed(cells[-1][0]) if cells else None
    return Left(
        names,
        len(rows),
        last_time_us,
        idle_s,
        _mended_events(folder / EVENTS, -1 if last_time_us is None else last_time_us),
        Counter(line.partition(b"\t")[0].decode("latin-1") for line in bad),
        [(_fixed(row[0]), _fixed(row[column])) for row in cells],
    )


def continued(left: Left, now_s: float) -> Intake:
    """An intake that goes on where the files end."""
    intake = Intake(channels=left.channels, accepted=left.rows, bad=left.bad)
    late = left.bad["out of order"]
    intake.lost = max(0, sum(int(event.get("lost") or 0) for event in left.events) - late)
    stamps = [event for event in left.events if "micros" in event]
    if left.last_time_us is not None and stamps:
        stamp = stamps[-1]
        stamp_us = _time_us(stamp)
        micros = (stamp["micros"] + left.last_time_us - stamp_us) % MICROS_WRAP
        # Every loss leaves an event, so the rows since the last one have no number missing.
        since = sum(time_us > stamp_us for time_us, _ in left.displacements_nm)
        anchor = Anchor(int(stamp["boot"], 16), micros, left.last_time_us, now_s - left.idle_s)
        intake.continue_from(anchor, stamp["sequence"] + since)
    elif left.last_time_us is not None:
        raise UserError(f"{EVENTS} does not say which device clock {CSV} was recorded by; start a new recording")
    return intake


def watched(ending: EndOfMotion, left: Left) -> EndOfMotion:
    """The end of the motion, having seen what was recorded."""
    for time_us, displacement_nm in left.displacements_nm:
        ending.watch(time_us, displacement_nm)
        if not ending.waiting:
            break
    return ending


def _whole_lines(path: Path) -> list[bytes]:
    if not path.exists():
        return []
    return path.read_bytes().split(b"\n")[:-1]


def _cut(path: Path, lines: list[bytes]) -> list[bytes]:
    if path.exists():
        size = sum(len(line) + 1 for line in lines)
        if path.stat().st_size != size:
            os.truncate(path, size)
    return lines


def _mended_events(path: Path, last_time_us: int) -> list[dict[str, Any]]:
    """Events up to the last row; those of a row that was not written yet will come again with that row."""
    lines = _whole_lines(path)
    events = [_event(path, line) for line in lines]
    while events and _time_us(events[-1]) > last_time_us:
        events.pop()
    _cut(path, lines[: len(events)])
    return events


def _time_us(event: dict[str, Any]) -> int:
    return round(event["time_s"] * 1e6)


def _event(path: Path, line: bytes) -> dict[str, Any]:
    try:
        return json.loads(line)
    except ValueError:
        raise UserError(f"{path}: holds a line that is no event: {line[:60]!r}; start a new recording") from None


def _fixed(text: bytes) -> int:
    """Six decimals as a whole number of millionths, exactly."""
    sign = -1 if text.startswith(b"-") else 1
    whole, _, fraction = text.lstrip(b"-").partition(b".")
    return sign * (int(whole) * 1_000_000 + int(fraction.ljust(6, b"0")[:6]))
