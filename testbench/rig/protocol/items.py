"""What comes out of the lines of a rig: rows, rejected lines, and what happened."""

from __future__ import annotations

from typing import NamedTuple

from testbench.recordings.channels import DISPLACEMENT, FORCE, RESISTANCE, TEMPERATURE
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
