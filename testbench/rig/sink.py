"""The files of a campaign while it is being recorded: appended, never rewritten, readable at any instant.

``recording.csv`` grows by whole lines; ``recording.bad`` keeps every rejected line with its reason;
``events.jsonl`` says what happened: start, gap, reboot, disconnect, resume, alarm. Each batch goes to the operating
system at once, so a killed recorder loses at most the batch in its hands; `Syncer` takes it to the disk every second.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import json
import os
import threading
from collections.abc import Iterable
from pathlib import Path

from gcode.support.errors import UserError
from testbench.recording import TIME
from testbench.rig.stream import Bad, Event, Item, Row, channels_of

CSV, BAD, EVENTS = "recording.csv", "recording.bad", "events.jsonl"
TAIL_BYTES = 4096
FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)


def seconds(time_us: int) -> str:
    """Microseconds as exact decimal seconds."""
    return f"{time_us // 1_000_000}.{time_us % 1_000_000:06d}"


def csv_line(row: Row) -> str:
    """One line of ``recording.csv``: every digit of the wire, nothing more."""
    sample = row.sample
    parts = [seconds(row.time_us), f"{sample.displacement_nm / 1e6:.6f}"]
    if sample.force_uN is not None:
        parts.append(f"{sample.force_uN / 1e6:.6f}")
    if sample.resistance_mohm is not None:
        parts.append(f"{sample.resistance_mohm / 1e3:.3f}")
    if sample.temperature_mC is not None:
        parts.append(f"{sample.temperature_mC / 1e3:.3f}")
    return ",".join(parts) + "\n"


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


class Appender:
    """Appends text to one file; on a full disk it keeps the text and tries again with the next write.

    Attributes
    ----------
    pending : bytes
        What the disk has not taken yet.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.pending = b""
        self._handle = os.open(path, os.O_RDWR | os.O_APPEND | os.O_CREAT, 0o644)

    def write(self, text: str) -> bool:
        """Append; whether everything is written."""
        self.pending += text.encode()
        while self.pending:
            try:
                written = self.take(self.pending)
            except OSError as error:
                if error.errno in FULL:
                    return False
                raise
            self.pending = self.pending[written:]
        return True

    def lock(self) -> None:
        """Refuse a second recorder on this file; the lock ends with this process, however it ends."""
        try:
            fcntl.flock(self._handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            os.close(self._handle)
            raise UserError(f"{self.path}: another recorder is writing this file; choose another with -o") from None

    def sync(self) -> None:
        """Have the disk keep what was written."""
        with contextlib.suppress(OSError):
            os.fsync(self._handle)

    def take(self, data: bytes) -> int:
        """Give `data` to the operating system; how many bytes it took."""
        return os.write(self._handle, data)

    @property
    def empty(self) -> bool:
        """Whether the file holds nothing."""
        return os.fstat(self._handle).st_size == 0

    def close(self) -> None:
        """Write what is pending, sync and close. What the disk does not take is gone, but leaves no half line."""
        if not self.write(""):
            size = os.fstat(self._handle).st_size
            tail = os.pread(self._handle, TAIL_BYTES, max(0, size - TAIL_BYTES))
            os.ftruncate(self._handle, size - (len(tail) - tail.rfind(b"\n") - 1))
        self.sync()
        os.close(self._handle)


class Syncer(threading.Thread):
    """Calls `Sink.sync` once a second in its own thread: a slow disk must not stop the recorder from reading."""

    def __init__(self, sink: Sink, period_s: float = 1.0) -> None:
        super().__init__(daemon=True)
        self._sink, self._period_s, self._ended = sink, period_s, threading.Event()

    def run(self) -> None:
        while not self._ended.wait(self._period_s):
            self._sink.sync()

    def end(self) -> None:
        """Stop and wait for the sync that may be under way."""
        self._ended.set()
        self.join()


class Sink:
    """The growing files of one campaign folder.

    Parameters
    ----------
    folder : Path
        Exists. Files that are there are continued.
    """

    def __init__(self, folder: Path) -> None:
        self._csv = Appender(folder / CSV)
        self._csv.lock()
        self._bad: Appender | None = None
        self._events = Appender(folder / EVENTS)
        self._bad_path = folder / BAD
        self._headed: bool | None = None

    def write(self, items: Iterable[Item]) -> bool:
        """Append a batch; False when the disk is full (nothing is forgotten: call again)."""
        rows, bad, events = [], [], []
        if self._headed is None:
            self._headed = not self._csv.empty
        for item in items:
            if isinstance(item, Row):
                if not self._headed:
                    rows.append(header_line(item))
                    self._headed = True
                rows.append(csv_line(item))
            elif isinstance(item, Bad):
                bad.append(bad_line(item))
            else:
                events.append(event_line(item))
        # Events first: a row without its gap record would be worse than a gap record without its row.
        whole = self._events.write("".join(events)) if events or self._events.pending else True
        whole &= self._csv.write("".join(rows))
        if bad and self._bad is None:
            self._bad = Appender(self._bad_path)
        if self._bad is not None:
            whole &= self._bad.write("".join(bad))
        return whole

    @property
    def pending_bytes(self) -> int:
        """Bytes that the disk has not taken."""
        return sum(len(part.pending) for part in self._parts())

    @property
    def unwritten_rows(self) -> int:
        """Rows that the disk has not taken."""
        return self._csv.pending.count(b"\n")

    def sync(self) -> None:
        """Have the disk keep everything written so far."""
        for part in self._parts():
            part.sync()

    def close(self) -> None:
        """Write what is pending (as far as the disk takes it), sync and close."""
        for part in self._parts():
            part.close()

    def _parts(self) -> list[Appender]:
        return [part for part in (self._csv, self._bad, self._events) if part is not None]
