"""From lines to rows: which samples to accept, when they were taken, what was lost. No ports, no files, no clock."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

from testbench.recording import DISPLACEMENT, FORCE, RESISTANCE, TEMPERATURE
from testbench.rig.wire import MICROS_WRAP, BadLine, LineBuffer, Sample, decode, rescue

GAP_US = 1_000_000
REMEMBERED_LOSSES = 10_000
# Within a minute on the host no device lives through half a wrap (36 min), unless its clock ran backwards.
BACKWARDS_US, BACKWARDS_HOST_S = MICROS_WRAP // 2, 60.0


class Row(NamedTuple):
    """An accepted sample and its time since the recording's first sample."""

    time_us: int
    sample: Sample


class Bad(NamedTuple):
    """A rejected line and why."""

    reason: str
    line: bytes


class Event(NamedTuple):
    """To be remembered: ``start``, ``loss``, ``gap``, ``reboot``, ``disconnect``, ``resume``, ``alarm``, ``end``.

    A ``gap`` is a silence of more than 1 s, or of any length after a disconnect; a ``loss`` is a shorter one.
    """

    kind: str
    time_us: int
    details: dict[str, object]


Item = Row | Bad | Event


def channels_of(sample: Sample) -> tuple[str, ...]:
    """Names of the recording's channels that `sample` carries, in the order of the file."""
    present = (
        (DISPLACEMENT, True),
        (FORCE, sample.force_uN is not None),
        (RESISTANCE, sample.resistance_mohm is not None),
        (TEMPERATURE, sample.temperature_mC is not None),
    )
    return tuple(name for name, there in present if there)


@dataclass
class Anchor:
    """Where the device's clock stands against the recording's."""

    boot: int
    micros: int
    time_us: int
    host_s: float


@dataclass
class Intake:
    """Turns bytes into rows, rejected lines and events, and counts them.

    Attributes
    ----------
    channels : tuple of str or None
        Pinned by the first accepted sample (or by the file that is resumed).
    anchor : Anchor or None
        The last accepted sample; see `continue_from`.
    accepted, lost : int
        Lines accepted; lines that the sequence numbers prove were sent and never came.
    bad : Counter
        Rejected lines by reason.
    """

    channels: tuple[str, ...] | None = None
    anchor: Anchor | None = None
    accepted: int = 0
    lost: int = 0
    bad: Counter[str] = field(default_factory=Counter)
    _sequence: int | None = None
    _missing: dict[int, None] = field(default_factory=dict)
    _old_boots: set[int] = field(default_factory=set)
    _buffer: LineBuffer = field(default_factory=LineBuffer)
    _fresh: bool = True
    _away: bool = False

    def continue_from(self, anchor: Anchor, sequence: int) -> None:
        """Go on after a sample that an earlier recorder accepted; what came between is a gap."""
        self.anchor, self._sequence, self._away = anchor, sequence, True

    def feed(self, data: bytes, host_s: float) -> Iterator[Item]:
        """Rows, rejected lines and events in `data`, which came at `host_s` (monotonic seconds)."""
        for line in self._buffer.feed(data):
            yield from self._line(line, host_s)

    def disconnected(self, reason: str) -> Iterator[Item]:
        """The port was lost: the half line in the buffer will never be finished."""
        rest = self._buffer.drop()
        if rest:
            yield self._reject("cut off", rest)
        self._fresh = self._away = True
        yield Event("disconnect", self.time_us, {"reason": reason})

    @property
    def time_us(self) -> int:
        """Time of the last accepted sample; 0 before the first."""
        return self.anchor.time_us if self.anchor else 0

    def _line(self, line: bytes, host_s: float) -> Iterator[Item]:
        first, self._fresh = self._fresh, False
        if not line:
            return
        debris, line = rescue(line)
        if debris:
            yield self._reject("no line end", debris)
        try:
            sample = decode(line)
            yield from self._sample(sample, host_s)
        except BadLine as problem:
            # Opening a port lands in the middle of a line: expected, kept apart from real faults.
            yield self._reject("partial first line" if first else str(problem), line)

    def _reject(self, reason: str, line: bytes) -> Bad:
        self.bad[reason] += 1
        return Bad(reason, line)

    def _sample(self, sample: Sample, host_s: float) -> Iterator[Item]:
        channels = channels_of(sample)
        if self.channels is not None and channels != self.channels:
            raise BadLine("other channels")
        if self.anchor is None:
            self.channels = channels
            time_us = 0
            yield Event("start", 0, {**_device(sample), "channels": list(channels)})
        elif sample.boot != self.anchor.boot:
            yield self._reboot(sample, host_s, self.anchor)
            time_us = self.time_us
        else:
            self._check_sequence(sample.sequence)
            time_us = self.anchor.time_us + self._elapsed_us(sample, host_s, self.anchor)
            lost = self._count_losses(sample.sequence)
            silent, self._away = self._away or time_us - self.anchor.time_us > GAP_US, False
            if silent or lost:
                details = {"from_us": self.anchor.time_us, "lost": lost, **_device(sample)}
                yield Event("gap" if silent else "loss", time_us, details)
        self._sequence = sample.sequence
        self.anchor = Anchor(sample.boot, sample.micros, time_us, host_s)
        self.accepted += 1
        yield Row(time_us, sample)

    def _reboot(self, sample: Sample, host_s: float, anchor: Anchor) -> Event:
        if sample.boot in self._old_boots:
            raise BadLine("from before reboot")
        self._old_boots.add(anchor.boot)
        self._missing.clear()
        # The device lost its clock: only the host knows how long it was away.
        time_us = anchor.time_us + max(1, round((host_s - anchor.host_s) * 1e6))
        self.anchor = Anchor(sample.boot, sample.micros, time_us, host_s)
        return Event("reboot", time_us, {"from_us": anchor.time_us, **_device(sample)})

    def _check_sequence(self, sequence: int) -> None:
        if self._sequence is None or sequence > self._sequence:
            return
        if sequence in self._missing:
            del self._missing[sequence]
            self.lost -= 1
            raise BadLine("out of order")
        raise BadLine("repeated")

    def _elapsed_us(self, sample: Sample, host_s: float, anchor: Anchor) -> int:
        elapsed = (sample.micros - anchor.micros) % MICROS_WRAP
        host_us = (host_s - anchor.host_s) * 1e6
        if elapsed == 0 and host_us < BACKWARDS_US:
            raise BadLine("time stands still")
        if elapsed > BACKWARDS_US and host_us < BACKWARDS_HOST_S * 1e6:
            raise BadLine("time runs backwards")
        # After a long silence the host's clock says how often the device's wrapped meanwhile.
        wraps = max(0, round((host_us - elapsed) / MICROS_WRAP))
        return elapsed + wraps * MICROS_WRAP

    def _count_losses(self, sequence: int) -> int:
        if self._sequence is None:
            return 0
        lost = sequence - self._sequence - 1
        self.lost += lost
        for number in range(max(self._sequence + 1, sequence - REMEMBERED_LOSSES), sequence):
            self._missing[number] = None
        while len(self._missing) > REMEMBERED_LOSSES:
            del self._missing[next(iter(self._missing))]
        return lost


def _device(sample: Sample) -> dict[str, object]:
    return {"boot": f"{sample.boot:08x}", "sequence": sample.sequence, "micros": sample.micros}
