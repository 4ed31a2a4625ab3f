"""The wire protocol K1: one line a sample, bytes in and samples out. See docs/wire.md.

    $K1,5f3a9c01,1042,3500123,1203456,405600123,2345678*dd01a044

``$``, then comma-separated fields, then ``*`` and the CRC-32 of everything between ``$`` and ``*``. All numbers are
integers, so that a microcontroller needs no floating-point printing and a reading survives to its last digit.
"""

from __future__ import annotations

import re
import zlib
from collections.abc import Iterator
from typing import NamedTuple

MAX_LINE_BYTES = 256
MICROS_WRAP = 1 << 32
SEQUENCE_WRAP = 1 << 32

# Digits that a number has at most, in the units of the line.
FORCE_DIGITS, RESISTANCE_DIGITS, DISPLACEMENT_DIGITS, TEMPERATURE_DIGITS = 10, 15, 10, 7
_LINE = re.compile(
    rb"\$(K1,([0-9a-f]{8}),(\d{1,10}),(\d{1,10}),"
    rb"(-?\d{1,%d})?,(\d{1,%d})?,(-?\d{1,%d})(?:,(-?\d{1,%d}))?)\*([0-9a-f]{8})"
    % (FORCE_DIGITS, RESISTANCE_DIGITS, DISPLACEMENT_DIGITS, TEMPERATURE_DIGITS)
)


class Sample(NamedTuple):
    """One reading of the device.

    Attributes
    ----------
    boot : int
        Random number drawn at every boot (32 bit): tells a reboot from a wrap of `micros`.
    sequence : int
        Counts lines from 0 since boot, modulo 2^32.
    micros : int
        Device microseconds, modulo 2^32 (wraps after 71.6 min).
    force_uN, resistance_mohm, displacement_nm, temperature_mC : int or None
        Readings in micronewton, milliohm, nanometre and millidegree Celsius; None where there is no such channel.
    """

    boot: int
    sequence: int
    micros: int
    force_uN: int | None
    resistance_mohm: int | None
    displacement_nm: int
    temperature_mC: int | None = None

    def since(self, before: Sample) -> tuple[int, int]:
        """Lines and device microseconds from another sample of the same boot to this one; each modulo 2^32."""
        return (self.sequence - before.sequence) % SEQUENCE_WRAP, (self.micros - before.micros) % MICROS_WRAP

    def follows(self, before: Sample, most_lines: int) -> int:
        """How many lines after `before` this one comes, at most so many, if it may be the same device's; else 0."""
        step, step_us = self.since(before)
        runs = self.boot == before.boot and 0 < step <= most_lines and 0 < step_us < MICROS_WRAP // 2
        return step if runs else 0


class BadLine(ValueError):
    """A line that is no sample; the text is the reason, in two or three words, the same for the same fault."""


def encode(sample: Sample) -> bytes:
    """The line of a sample, with its line feed."""
    force = "" if sample.force_uN is None else sample.force_uN
    resistance = "" if sample.resistance_mohm is None else sample.resistance_mohm
    body = f"K1,{sample.boot:08x},{sample.sequence},{sample.micros},{force},{resistance},{sample.displacement_nm}"
    if sample.temperature_mC is not None:
        body += f",{sample.temperature_mC}"
    return f"${body}*{zlib.crc32(body.encode()):08x}\n".encode()


def decode(line: bytes) -> Sample:
    """The sample of a line, given without its line feed.

    Raises
    ------
    BadLine
        If the line is not complete and intact. A wrong CRC is never repaired.
    """
    match = _LINE.fullmatch(line)
    if match is None:
        raise BadLine(_malformation(line))
    body, boot, sequence, micros, force, resistance, displacement, temperature, crc = match.groups()
    if zlib.crc32(body) != int(crc, 16):
        raise BadLine("wrong CRC")
    if int(micros) >= MICROS_WRAP:
        raise BadLine("micros out of range")
    if int(sequence) >= SEQUENCE_WRAP:
        raise BadLine("sequence out of range")
    return Sample(
        int(boot, 16),
        int(sequence),
        int(micros),
        None if force is None else int(force),
        None if resistance is None else int(resistance),
        int(displacement),
        None if temperature is None else int(temperature),
    )


def _malformation(line: bytes) -> str:
    if not line.startswith(b"$"):
        return "no start"
    if line.startswith(b"$K") and not line.startswith(b"$K1,"):
        return "other version"
    if line[-9:-8] != b"*":
        return "no CRC"
    return "malformed"


def rescue(line: bytes) -> tuple[bytes, bytes]:
    """Split a line at its last ``$``: (debris, what may be a whole line).

    A line that lost its end runs into the next one, which is intact and must not be lost with it.
    """
    start = line.rfind(b"$")
    return (line[:start], line[start:]) if start > 0 else (b"", line)


class LineBuffer:
    """Cuts a stream of bytes into lines and holds the unfinished rest. Over-long debris becomes a line of its own."""

    def __init__(self) -> None:
        self._rest = b""

    def feed(self, data: bytes) -> Iterator[bytes]:
        """Lines completed by `data`, without line feed, and carriage return before or behind it."""
        *lines, self._rest = (self._rest + data).split(b"\n")
        for line in lines:
            yield line.strip(b"\r")
        while len(self._rest) > MAX_LINE_BYTES:
            start = self._rest.rfind(b"$")  # of what may become a whole line, and must not be cut in two
            cut = min(start, MAX_LINE_BYTES) if start > 0 else MAX_LINE_BYTES
            yield self._rest[:cut]
            self._rest = self._rest[cut:]

    def drop(self) -> bytes:
        """Forget and return the unfinished rest (the port was closed)."""
        rest, self._rest = self._rest, b""
        return rest
