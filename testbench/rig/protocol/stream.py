"""From lines to rows: which samples to accept, when they were taken, what was lost. No ports, no files, no clock."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field

from testbench.rig.protocol.items import Bad, Event, Item, Row, channels_of
from testbench.rig.protocol.restart import Restart
from testbench.rig.protocol.voices import Voices
from testbench.rig.protocol.wire import MICROS_WRAP, SEQUENCE_WRAP, BadLine, LineBuffer, Sample, decode, rescue

GAP_US = 1_000_000  # a longer silence is a gap
REMEMBERED_LOSSES = 10_000  # numbers that may still come, late
HALF_WRAP_US = MICROS_WRAP // 2
# By how much the device's clock may be ahead of the host's since the last sample: a sample does not come before it is
# taken. After a resume the host's clock is that of file times, which another machine may have set.
AHEAD_US, AHEAD_SHARE, AHEAD_RESUMED_US = 5_000_000, 0.1, 600_000_000
# By how much the device's clock may be off what the count of lines and their mean interval say, and agree with it.
COUNTED_US, COUNTED_SHARE = 1_000_000, 0.001
RENUMBERED_LINES = 8  # so many old numbers in a row, and the device has begun to count anew
MOST_LINES_PER_US = 1


class LateLine(BadLine):
    """A line that was counted as lost and came after all, behind later ones."""

    reason = "out of order"

    def __init__(self) -> None:
        super().__init__(self.reason)


@dataclass
class Anchor:
    """One moment on the clock of the device, of the host and of the recording."""

    boot: int
    micros: int
    time_us: int
    host_s: float
    epoch: int = 0  # counts the times that the device's clock was lost


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
    restarts : int
        How often the device restarted.
    bad : Counter
        Rejected lines by reason.
    host_clock : bool
        Whether host times mean anything; not where a simulated rig delivers at once.
    voices : Voices
        Whether more than one device talks.
    """

    channels: tuple[str, ...] | None = None
    anchor: Anchor | None = None
    accepted: int = 0
    lost: int = 0
    restarts: int = 0
    bad: Counter[str] = field(default_factory=Counter)
    host_clock: bool = True
    voices: Voices = field(default_factory=Voices)
    _sequence: int | None = None
    _missing: dict[int, None] = field(default_factory=dict)
    _old_boots: set[int] = field(default_factory=set)
    _buffer: LineBuffer = field(default_factory=LineBuffer)
    _fresh: bool = True
    _away: bool = False
    _resumed: bool = False
    _interval_us: float | None = None
    _suspect: tuple[Sample, float] | None = None
    _restart: Restart = field(default_factory=Restart)
    _run: tuple[int, int] = (0, 0)  # the last number of a run of lines with old numbers, and its length

    def continue_from(self, anchor: Anchor, sequence: int, interval_us: float | None = None) -> None:
        """Go on after a sample that an earlier recorder accepted; what came between is a gap.

        `interval_us` is the device's mean time from line to line, where it is known.
        """
        self.anchor, self._sequence, self._away, self._resumed = anchor, sequence, True, True
        self._interval_us = interval_us

    def feed(self, data: bytes, host_s: float) -> Iterator[Item]:
        """Rows, rejected lines and events in `data`, which came at `host_s` (monotonic seconds)."""
        for line in self._buffer.feed(data):
            yield from self._line(line, host_s)

    def accept(self, first: Row, last: Row, count: int) -> Iterator[Event]:
        """Take note of `count` samples without any fault in a row, from `first` to `last`.

        A simulated rig that delivers at once makes them; see `testbench.rig.simulation.at_once`.
        """
        if self.anchor is None:
            self.channels = channels_of(first.sample)
            yield Event("start", 0, {**_device(first.sample), "channels": list(self.channels)})
        self._sequence = last.sample.sequence
        self.anchor = Anchor(last.sample.boot, last.sample.micros, last.time_us, 0.0)
        self.accepted += count

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
        except BadLine as problem:
            # Opening a port lands in the middle of a line: expected, kept apart from real faults.
            yield self._reject("partial first line" if first else str(problem), line)
            return
        try:
            yield from self._sample(sample, host_s)
        except BadLine as problem:
            yield self._reject(str(problem), line)
            if isinstance(problem, LateLine):
                return  # awaited: it says nothing of who talks
        if self.voices.hear(sample):
            yield Event("two devices", self.time_us, {"boots": [f"{boot:08x}" for boot in self.voices.boots]})

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
        else:
            time_us, events = self._placed(sample, host_s, self.anchor)
            yield from events
        self._sequence = sample.sequence
        epoch = self.anchor.epoch if self.anchor else 0
        self.anchor = Anchor(sample.boot, sample.micros, time_us, host_s, epoch)
        self._suspect, self._run, self._resumed, self._away = None, (0, 0), False, False
        self._restart.forget()
        self.accepted += 1
        yield Row(time_us, sample)

    def _placed(self, sample: Sample, host_s: float, anchor: Anchor) -> tuple[int, list[Event]]:
        """The time of a sample after others, and what is to be remembered with it.

        Raises
        ------
        BadLine
            If it is of a boot that is over, or as `_next` says; unless so many of them agree that the device has
            restarted under a boot number that was there before.
        """
        try:
            if sample.boot == anchor.boot:
                return self._next(sample, host_s, anchor)
            if sample.boot in self._old_boots:
                raise BadLine("from before reboot")
        except BadLine:
            if not (self.host_clock and self._restart.sees(sample, host_s)):
                raise
        event = self._reboot(sample, host_s, anchor)
        return event.time_us, [event]

    def _next(self, sample: Sample, host_s: float, anchor: Anchor) -> tuple[int, list[Event]]:
        """The time of a sample of the boot that is known, and what is to be remembered with it.

        Raises
        ------
        BadLine
            If it is late, doubled, or its clock or its number lies.
        """
        counted_us = self._counted_us(sample, anchor)
        elapsed_us = self._elapsed_us(sample, host_s, anchor) if counted_us is None else counted_us
        renumbered = self._check_sequence(sample.sequence, elapsed_us)
        jumped = elapsed_us is not None and counted_us is None and self._is_ahead(elapsed_us, host_s, anchor)
        if elapsed_us is None or jumped:
            time_us = self._after_a_jump(sample, host_s, anchor)
            details = {"from_us": anchor.time_us, "host_s": round(host_s - anchor.host_s, 3), **_device(sample)}
            anchor.epoch += 1
            return time_us, [Event("clock jump", time_us, {**details, "lost": self._count_losses(sample.sequence)})]
        time_us = anchor.time_us + elapsed_us
        if renumbered:
            self._missing.clear()
            return time_us, [Event("renumbered", time_us, {"from_us": anchor.time_us, **_device(sample)})]
        lost = self._count_losses(sample.sequence)
        silent = self._away or elapsed_us > GAP_US
        if not (silent or lost):
            return time_us, []
        details = {"from_us": anchor.time_us, "lost": lost, **_device(sample)}
        return time_us, [Event("gap" if silent else "loss", time_us, details)]

    def _reboot(self, sample: Sample, host_s: float, anchor: Anchor) -> Event:
        self._old_boots.add(anchor.boot)
        self._old_boots.discard(sample.boot)
        self._missing.clear()
        self.restarts += 1
        # The device lost its clock: only the host knows how long it was away.
        time_us = anchor.time_us + max(1, round((host_s - anchor.host_s) * 1e6))
        self.anchor = Anchor(sample.boot, sample.micros, time_us, host_s, anchor.epoch + 1)
        return Event("reboot", time_us, {"from_us": anchor.time_us, **_device(sample)})

    def _check_sequence(self, sequence: int, elapsed_us: int | None) -> bool:
        """Whether the device has begun to count anew; a late or doubled line is refused.

        A late line carries an old time, too. Old numbers whose time runs forward, line after line, are those of a
        device that lost its count: they must not be rejected for ever.
        """
        if self._sequence is None:
            return False
        step = (sequence - self._sequence) % SEQUENCE_WRAP
        most = GAP_US if elapsed_us is None else max(GAP_US, elapsed_us * MOST_LINES_PER_US)
        if 0 < step <= min(most, SEQUENCE_WRAP // 2):
            return False
        if sequence in self._missing and elapsed_us is None:
            del self._missing[sequence]
            self.lost -= 1
            raise LateLine
        before, length = self._run
        follows = elapsed_us is not None and sequence == (before + 1) % SEQUENCE_WRAP
        self._run = (sequence, length + 1 if follows else 0)
        if self._run[1] < RENUMBERED_LINES:
            raise BadLine("repeated" if step == 0 or step > SEQUENCE_WRAP // 2 else "number jumps")
        return True

    def _counted_us(self, sample: Sample, anchor: Anchor) -> int | None:
        """Device time since an earlier recorder's last sample, where its clock agrees with its count of lines.

        File times stand for the host's clock then, and that may have been set meanwhile: by years, where a computer
        without a battery found the network. None where the lines say nothing, as those of a device that waited.
        """
        if not self._resumed or self._interval_us is None or self._sequence is None:
            return None
        lines = (sample.sequence - self._sequence) % SEQUENCE_WRAP
        if lines > SEQUENCE_WRAP // 2:
            return None  # counted back, as by a device that restarted
        due_us = lines * self._interval_us
        elapsed = (sample.micros - anchor.micros) % MICROS_WRAP
        elapsed += round((due_us - elapsed) / MICROS_WRAP) * MICROS_WRAP
        agrees = elapsed > 0 and abs(elapsed - due_us) <= COUNTED_US + COUNTED_SHARE * due_us
        return elapsed if agrees else None

    def _elapsed_us(self, sample: Sample, host_s: float, anchor: Anchor) -> int | None:
        """Device time since the last sample; None if the clock stands still or ran backwards."""
        elapsed = (sample.micros - anchor.micros) % MICROS_WRAP
        host_us = max(0.0, (host_s - anchor.host_s) * 1e6)
        if (elapsed == 0 or elapsed > HALF_WRAP_US) and host_us < HALF_WRAP_US / 2:
            return None
        # After a long silence the host's clock says how often the device's wrapped meanwhile.
        wraps = max(0, round((host_us - elapsed) / MICROS_WRAP))
        return elapsed + wraps * MICROS_WRAP or None

    def _is_ahead(self, elapsed_us: int, host_s: float, anchor: Anchor) -> bool:
        """Whether more time has passed on the device than can have passed."""
        host_us = max(0.0, (host_s - anchor.host_s) * 1e6)
        allowed_us = AHEAD_US + AHEAD_SHARE * host_us + (AHEAD_RESUMED_US if self._resumed else 0)
        return self.host_clock and elapsed_us > host_us + allowed_us

    def _after_a_jump(self, sample: Sample, host_s: float, anchor: Anchor) -> int:
        """The time of a sample whose clock jumped, by the host's; only if the sample before it says the same.

        Raises
        ------
        BadLine
            If it is the first one: a single wrong stamp is no jump.
        """
        elapsed = (sample.micros - anchor.micros) % MICROS_WRAP
        suspect, self._suspect = self._suspect, (sample, host_s)
        if suspect is not None and elapsed and self.host_clock:
            before, before_s = suspect
            step, step_us = sample.since(before)
            allowed_us = (1 + AHEAD_SHARE) * max(0.0, (host_s - before_s) * 1e6) + AHEAD_US
            if 0 < step_us <= allowed_us and 0 < step < GAP_US:
                return anchor.time_us + max(1, round((host_s - anchor.host_s) * 1e6))
        if not elapsed:
            raise BadLine("time stands still")
        raise BadLine("time runs backwards" if elapsed > HALF_WRAP_US else "clock jump")

    def _count_losses(self, sequence: int) -> int:
        if self._sequence is None:
            return 0
        lost = (sequence - self._sequence) % SEQUENCE_WRAP - 1
        self.lost += lost
        for behind in range(min(lost, REMEMBERED_LOSSES), 0, -1):
            self._missing[(sequence - behind) % SEQUENCE_WRAP] = None
        while len(self._missing) > REMEMBERED_LOSSES:
            del self._missing[next(iter(self._missing))]
        return lost


def _device(sample: Sample) -> dict[str, object]:
    return {"boot": f"{sample.boot:08x}", "sequence": sample.sequence, "micros": sample.micros}
