"""The recorder: what a link delivers goes through the intake to the files, with progress and limits.

It knows no port and no clock: a link is any iterable of `Chunk`, `Accepted`, `Lost`, `Tick` and `End`, each with its
host time. Tests feed lists; `testbench record` feeds a serial port; `testbench run` feeds the simulated rig.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace

from gcode.support.errors import UserError
from gcode.support.kinds import number
from testbench.rig.acquisition.sink import Sink
from testbench.rig.acquisition.watchdog import Watchdog
from testbench.rig.connection.parts import Accepted, Chunk, End, Lost, Part
from testbench.rig.protocol.items import Event, Item, Lines, Row
from testbench.rig.protocol.stream import Intake

PROGRESS_S = 0.5  # from one report to the next
RATE_WINDOW_US = 5_000_000  # over which the sampling rate is a mean
DISK_STATES = ("disk full", "disk error")
# Takes a row, gives what a compensator makes of the resistance so far, and its unit.
Follow = Callable[[Row], tuple[float | None, str]]


@dataclass(frozen=True)
class Limits:
    """The force and the strain beyond which a recording stops.

    Attributes
    ----------
    max_force_N, max_strain : float
        Beyond these (absolute) values the recording stops with an alarm.
    """

    max_force_N: float = float("inf")
    max_strain: float = float("inf")

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not number(name, value) > 0:  # NaN is none: nothing is ever beyond it
                raise UserError(
                    f"{name} must be a positive number, got {value!r}; leave it out where there is no limit"
                )


@dataclass
class Status:
    """A moment of a recording, as progress shows it; the last one says how it ended.

    Attributes
    ----------
    time_s, duration_s : float
        Recording time so far; planned (infinite if open).
    samples, lost, rejected, unwritten : int
        `unwritten` rows were accepted, and the disk did not take them.
    sync_failures : int
        How often the disk said that it could not keep what it had taken.
    rate_hz : float
        Mean over the last seconds; at the end over all that this recorder heard.
    force_N, resistance_ohm : float or None
    displacement_mm, strain : float
        The last accepted sample.
    compensated : float or None
        What a compensator makes of the resistance, in `compensated_unit`; None without one.
    state : str
        ``recording``, then ``complete``, ``interrupted``, ``alarm``, ``disk full``, ``disk error`` or ``port lost``.
    message : str
        What a person should know now; empty if nothing.
    """

    duration_s: float
    time_s: float = 0.0
    samples: int = 0
    lost: int = 0
    rejected: int = 0
    unwritten: int = 0
    sync_failures: int = 0
    rate_hz: float = 0.0
    force_N: float | None = None
    resistance_ohm: float | None = None
    displacement_mm: float = 0.0
    strain: float = 0.0
    compensated: float | None = None
    compensated_unit: str = ""
    state: str = "recording"
    message: str = ""


Report = Callable[[Status], None]


@dataclass
class Recorder:
    """Takes what a link delivers and writes it to the files of a campaign (a `Sink`).

    Attributes
    ----------
    intake : Intake
        Set its `anchor` and `channels` to continue a recording.
    sink : Sink
    gauge_length_mm : float
    limits : Limits
    duration_s : float
        Expected, for the progress.
    is_over : callable
        Whether the recording is complete with this row; see `testbench.rig.acquisition.ending`.
    remark : callable
        What to say of such an end.
    report : callable
        Called with the `Status` about twice a second of host time, and at the end.
    follow : callable, optional
        Told about each accepted row as it comes; gives what `Status.compensated` shows.
    disk_patience_s : float
        How long a disk may stay full.
    pause : callable, optional
        Waits for so many seconds: at the end of a recording a full disk is waited for, too. None does not wait.
    """

    intake: Intake
    sink: Sink
    gauge_length_mm: float
    limits: Limits = field(default_factory=Limits)
    duration_s: float = float("inf")
    is_over: Callable[[Row], bool] = lambda row: False
    remark: Callable[[], str] = str
    report: Report = lambda status: None
    disk_patience_s: float = 60.0
    pause: Callable[[float], None] | None = None
    follow: Follow | None = None
    _last: Row | None = None
    _first: tuple[int, int] | None = None
    _window: tuple[int, int] | None = None
    _reported_s: float = float("-inf")
    _full_since_s: float | None = None
    _port_lost: bool = False

    def __post_init__(self) -> None:
        self.status, self._watchdog = Status(self.duration_s), Watchdog(before=self.intake.accepted)

    def run(self, link: Iterable[Part], stopped: Callable[[], bool] = lambda: False) -> Status:
        """Record until a limit, the end of the link, a full disk that stays full, or `stopped`."""
        for part in link:
            self._disk(self.sink.write(self._items(part)), part.host_s)
            self._look(part)
            if self.status.state == "recording" and stopped():
                self.status.state = "interrupted"
            if self.status.state != "recording":
                break
            if part.host_s - self._reported_s >= PROGRESS_S:
                self._progress(part.host_s)
        return self._ended()

    def _look(self, part: Part) -> None:
        """Let the watchdog look; its message is shown where there is none more serious."""
        if isinstance(part, End):
            return
        if isinstance(part, Lost):
            self._port_lost = True
        if self._port_lost:
            self._watchdog.away(part.host_s)
            return
        if found := self._watchdog.look(part.host_s, isinstance(part, Chunk | Accepted), self.intake):
            self.sink.write(found)
        if self.status.state == "recording" and self._full_since_s is None:
            self.status.message = self._watchdog.message

    def _items(self, part: Part) -> Iterator[Item]:
        if isinstance(part, Chunk):
            self._port_lost = False
            for item in self.intake.feed(part.data, part.host_s):
                if isinstance(item, Row) and (ending := self._ending(item)):
                    yield from ending
                    return
                yield item
        elif isinstance(part, Accepted):
            self._first = self._first or (part.first.time_us, 1)
            self._last = part.last
            yield from self.intake.accept(part.first, part.last, part.samples)
            yield Lines(part.text)
        elif isinstance(part, Lost):
            self.status.message = f"port lost ({part.reason}); trying to get it back"
            yield from self.intake.disconnected(part.reason)
        elif isinstance(part, End):
            self.status.state, self.status.message = part.state, part.message

    def _ending(self, row: Row) -> list[Item]:
        """What to write last if this row ends the recording; empty if it goes on."""
        self._first = self._first or (row.time_us, self.intake.accepted)
        self._last = row
        if self.follow is not None:
            self.status.compensated, self.status.compensated_unit = self.follow(row)
        if alarm := self._alarm(row):
            self.status.state, self.status.message = "alarm", alarm
            return [row, Event("alarm", row.time_us, {"message": alarm})]
        if self.is_over(row):
            self.status.state = "complete"
            self.status.message = "; ".join(filter(None, (self.status.message, self.remark())))
            return [row]
        return []

    def _alarm(self, row: Row) -> str:
        force_N = (row.sample.force_uN or 0) / 1e6
        strain = row.sample.displacement_nm / 1e6 / self.gauge_length_mm
        when = f"at {row.time_us / 1e6:.2f} s"
        most_N = self.limits.max_force_N
        if row.sample.force_uN is None and most_N < float("inf"):
            return (
                f"the device sends no force, so the limit of {most_N:g} N cannot be watched: stop the machine, and "
                "connect the load cell or leave the limit out"
            )
        if abs(force_N) > most_N:
            return f"force {force_N:.3f} N is beyond the limit of {most_N:g} N {when}: stop the machine"
        if abs(strain) > self.limits.max_strain:
            return f"strain {strain:.3f} is beyond the limit of {self.limits.max_strain:g} {when}: stop the machine"
        return ""

    def _disk(self, whole: bool, host_s: float) -> None:
        if self.sink.sync_failures > self.status.sync_failures:
            self.status.sync_failures = self.sink.sync_failures
            self.sink.write([Event("sync failed", self.intake.time_us, {"times": self.status.sync_failures})])
        if whole:
            self._full_since_s = None
            return
        self._full_since_s = host_s if self._full_since_s is None else self._full_since_s
        self.status.message = self._waiting()
        if host_s - self._full_since_s > self.disk_patience_s and self.status.state == "recording":
            self._disk_failed()

    def _waiting(self) -> str:
        what = "the disk is full" if self.sink.full else f"the disk takes no more ({self.sink.refusal})"
        return f"{what}: {self.sink.pending_bytes} bytes wait in memory; make room"

    def _disk_failed(self) -> None:
        self.status.state = "disk full" if self.sink.full else "disk error"

    def _progress(self, host_s: float) -> None:
        self._reported_s = host_s
        if disturbed := self.sink.disturbed:
            self.status.message = self._said(disturbed)
        self.report(self._updated())

    def _updated(self) -> Status:
        status, intake = self.status, self.intake
        status.samples, status.lost, status.rejected = intake.accepted, intake.lost, intake.bad.total()
        status.time_s = intake.time_us / 1e6
        status.rate_hz = self._rate_hz()
        if self._last is not None:
            sample = self._last.sample
            status.force_N = None if sample.force_uN is None else sample.force_uN / 1e6
            status.resistance_ohm = None if sample.resistance_mohm is None else sample.resistance_mohm / 1e3
            status.displacement_mm = sample.displacement_nm / 1e6
            status.strain = status.displacement_mm / self.gauge_length_mm
        return status

    def _rate_hz(self) -> float:
        now = (self.intake.time_us, self.intake.accepted)
        before = self._window or now
        if self.status.state != "recording":
            before = self._first or now
        elif self._window is None or now[0] - before[0] > RATE_WINDOW_US:
            self._window = now
        elapsed_us = now[0] - before[0]
        return (now[1] - before[1]) / elapsed_us * 1e6 if elapsed_us else self.status.rate_hz

    def _ended(self) -> Status:
        status = self._updated()
        last = []
        if not self._settled():
            last = [self._gave_up()]
        if disturbed := self.sink.disturbed:
            status.message = self._said(disturbed)
            status.state = status.state if status.state == "alarm" else "disk error"
        details: dict[str, object] = {"state": status.state}
        if status.message:
            details["message"] = status.message
        self.sink.release_room()
        self.sink.write([*last, Event("end", self.intake.time_us, details)])
        self.report(status)
        return status

    def _settled(self) -> bool:
        """Wait until the disk has taken everything, as long as its patience lasts; whether it has."""
        for _ in self.trials():
            if self.sink.write([]) or self.status.state in DISK_STATES:
                break
            self.report(replace(self._updated(), message=self._said(self._waiting())))
        return not self.sink.pending_bytes

    def trials(self) -> Iterator[None]:
        """Yield at once, and after each pause until a disk's patience is over: a moment to try again."""
        yield
        for _ in range(int(self.disk_patience_s / PROGRESS_S)):
            if self.pause is None:
                return
            self.pause(PROGRESS_S)
            yield

    def _gave_up(self) -> Event:
        """Count what the disk did not take, say so, and make room for the last events."""
        status, why = self.status, self.sink.refusal
        if status.state not in ("alarm", *DISK_STATES):
            self._disk_failed()
        status.unwritten = self.sink.unwritten_rows
        lines = self.sink.unwritten_bad
        status.message = self._said(
            f"{'the disk is full' if self.sink.full else 'the disk failed'} ({why}): the last {status.unwritten} "
            f"rows and {lines} rejected lines are not in the files"
        )
        self.sink.give_up()
        return Event("unwritten", self.intake.time_us, {"rows": status.unwritten, "rejected": lines, "reason": why})

    def _said(self, text: str) -> str:
        """`text` after what is there to be said already, if that is an alarm or the end of a port."""
        keep = self.status.state in ("alarm", "port lost") and self.status.message
        return f"{self.status.message}; {text}" if keep else text


def counts(intake: Intake) -> dict[str, object]:
    """What the manifest says of the samples."""
    rejected = dict(sorted(intake.bad.items()))
    return {"samples": intake.accepted, "lost": intake.lost, "rejected": rejected}
