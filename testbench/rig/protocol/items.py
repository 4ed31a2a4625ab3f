"""What comes out of the lines of a rig: rows, rejected lines, what happened; and each as a line of a file."""

from __future__ import annotations

import json
from typing import NamedTuple

from testbench.recordings.channels import DISPLACEMENT, FORCE, RESISTANCE, TEMPERATURE, TIME
from testbench.rig.protocol.wire import Sample


class Row(NamedTuple):
    """An accepted sample and its time since the recording's first sample."""

    time_us: int
    sample: Sample


class Bad(NamedTuple):
    """A rejected line and why."""

    reason: str
    line: bytes


class Event(NamedTuple):
    """Something that happened during a recording, kept in ``events.jsonl``.

    Kinds: ``start``, ``loss``, ``gap``, ``reboot``, ``clock jump``, ``renumbered``, ``disconnect``, ``resume``,
    ``two devices``, ``silent``, ``mostly rejected``, ``clock disagrees``, ``sync failed``, ``unwritten``, ``alarm``,
    ``end``.

    A ``gap`` is a silence of more than 1 s, or of any length after a disconnect; a ``loss`` is a shorter one.
    """

    kind: str
    time_us: int
    details: dict[str, object]


class Lines(NamedTuple):
    """Accepted samples as they stand in ``recording.csv``; the first of a recording with its header."""

    text: str


Item = Row | Lines | Bad | Event


class Carried(NamedTuple):
    """How a channel travels: whole numbers in `field` of a `Sample`, of which `scale` make one of its unit."""

    channel: str
    field: str
    scale: float
    decimals: str


CARRIED = (  # in the order of the file
    Carried(DISPLACEMENT, "displacement_nm", 1e6, "%.6f"),
    Carried(FORCE, "force_uN", 1e6, "%.6f"),
    Carried(RESISTANCE, "resistance_mohm", 1e3, "%.3f"),
    Carried(TEMPERATURE, "temperature_mC", 1e3, "%.3f"),
)


def channels_of(sample: Sample) -> tuple[str, ...]:
    """Names of the recording's channels that `sample` carries, in the order of the file."""
    return tuple(one.channel for one in CARRIED if getattr(sample, one.field) is not None)


def seconds(time_us: int) -> str:
    """Microseconds as exact decimal seconds."""
    return f"{time_us // 1_000_000}.{time_us % 1_000_000:06d}"


def csv_line(row: Row) -> str:
    """One line of ``recording.csv``: every digit of the wire, nothing more."""
    read = [(getattr(row.sample, one.field), one) for one in CARRIED]
    cells = [one.decimals % (value / one.scale) for value, one in read if value is not None]
    return ",".join([seconds(row.time_us), *cells]) + "\n"


def header_line(row: Row) -> str:
    """Header of ``recording.csv``, pinned by the first accepted sample."""
    return ",".join((TIME, *channels_of(row.sample))) + "\n"


def event_line(event: Event) -> str:
    """One event as a line of JSON."""
    entry = {"event": event.kind, "time_s": event.time_us / 1e6, **event.details}
    if "from_us" in entry:
        entry["from_s"] = int(str(entry.pop("from_us"))) / 1e6
    return json.dumps(entry) + "\n"


def bad_line(bad: Bad) -> str:
    """One rejected line: reason, tab, the bytes with everything unprintable escaped."""
    text = bad.line.decode("latin-1").encode("unicode_escape").decode("ascii")
    return f"{bad.reason}\t{text}\n"
