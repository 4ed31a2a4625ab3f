"""One line of each file of a recording: a sample, an event, a line that was rejected."""

from __future__ import annotations

import json

from testbench.recordings.channels import TIME
from testbench.rig.protocol.items import CARRIED, Bad, Event, Row, channels_of


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
