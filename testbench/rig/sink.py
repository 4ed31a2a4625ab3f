"""The files of a campaign while it is being recorded: appended, never rewritten, readable at any instant.

``recording.csv`` grows by whole lines; ``recording.bad`` keeps every rejected line with its reason;
``events.jsonl`` says what happened: start, gap, reboot, disconnect, resume, alarm. Each batch goes to the operating
system at once, so a killed recorder loses at most the batch in its hands; `Syncer` takes it to the disk every second.
A disk that takes no more is waited for; room for the last events and the manifest is held from the start (``.room``).
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import json
import os
import secrets
import threading
from collections.abc import Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

from gcode.support import disk
from gcode.support.errors import UserError
from testbench.recordings.channels import TIME
from testbench.rig.stream import Bad, Event, Item, Lines, Row, channels_of

CSV, BAD, EVENTS = "recording.csv", "recording.bad", "events.jsonl"
STAMPS = ("start", "reboot", "clock jump", "renumbered", "resume")
ROOM = ".room"
ROOM_BYTES = 256 << 10
TAIL_BYTES = 4096
HURRY_S = 0.3
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
    """Appends text to one file; what the disk refuses it keeps, and tries again with the next write.

    Attributes
    ----------
    pending : bytes
        What the disk has not taken yet.
    refusal : OSError or None
        Why it did not.
    sync_failures : int
        How often the disk said that it could not keep what it had taken.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.pending = b""
        self.refusal: OSError | None = None
        self.sync_failures = 0
        self._handle: int | None = None
        self._named = False

    def open(self) -> int:
        """The open file, made if it is not there; its name is kept with the first sync."""
        if self._handle is None:
            self._handle = disk.open_growing(self.path)
            self._named = False
        return self._handle

    def write(self, text: str) -> bool:
        """Append; whether everything is written."""
        self.pending += text.encode()
        try:
            while self.pending:
                self.open()
                self.pending = self.pending[self.take(self.pending) :]
        except OSError as error:
            self.refusal = error
            return False
        self.refusal = None
        return True

    def hold(self, text: str) -> None:
        """Keep for the next write."""
        self.pending += text.encode()

    def lock(self) -> None:
        """Refuse a second recorder on this file; the lock ends with this process, however it ends."""
        try:
            fcntl.flock(self.open(), fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            self._shut()
            raise UserError(f"{self.path}: another recorder is writing this file; choose another with -o") from None

    def sync(self) -> None:
        """Have the disk keep what was written, and the file's name."""
        if self._handle is None:
            return
        try:
            disk.DISK.sync(self._handle)
        except OSError:
            self.sync_failures += 1
        if not self._named:
            disk.sync_quietly(self.path.parent)
            self._named = True

    def take(self, data: bytes) -> int:
        """Give `data` to the operating system; how many bytes it took."""
        return disk.DISK.write(self.open(), data)

    @property
    def empty(self) -> bool:
        """Whether the file holds nothing."""
        return os.fstat(self.open()).st_size == 0

    def drop(self) -> bool:
        """Forget what is pending and cut the line that it left half written; whether that could be done."""
        self.pending, self.refusal = b"", None
        if self._handle is None:
            return True
        try:
            size = os.fstat(self._handle).st_size
            tail = os.pread(self._handle, TAIL_BYTES, max(0, size - TAIL_BYTES))
            disk.DISK.truncate(self._handle, size - (len(tail) - tail.rfind(b"\n") - 1))
        except OSError as error:
            self.refusal = error
        return self.refusal is None

    def close(self) -> bool:
        """Write what is pending, sync and close. What the disk does not take is gone, but leaves no half line.

        Returns
        -------
        bool
            Whether the file ends with a whole line.
        """
        whole = self.write("") or self.drop()
        self.sync()
        self._shut()
        return whole

    def _shut(self) -> None:
        if self._handle is not None:
            with contextlib.suppress(OSError):
                disk.DISK.close(self._handle)
            self._handle = None


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
    room_bytes : int
        Room to hold on the disk for the last events and the manifest; 0 holds none.

    Raises
    ------
    UserError
        If another recorder writes here, a file is a link, or there is not even room for what is held.
    """

    def __init__(self, folder: Path, room_bytes: int = 0) -> None:
        self._folder = folder
        self._csv, self._bad, self._events = (Appender(folder / name) for name in (CSV, BAD, EVENTS))
        self._room = folder / ROOM
        self._hurry, self._hurried = ThreadPoolExecutor(1, "events to the disk"), Future[None]()
        self._hurried.set_result(None)
        self._csv.lock()
        try:
            self._events.open()
            self._hold_room(room_bytes)
            self._headed = not self._csv.empty
        except BaseException:
            self.close()
            raise

    def write(self, items: Iterable[Item]) -> bool:
        """Append a batch; False when the disk does not take it all (nothing is forgotten: call again)."""
        rows, bad, events, stamped = [], [], [], False
        for item in items:
            if isinstance(item, Row):
                if not self._headed:
                    rows.append(header_line(item))
                    self._headed = True
                rows.append(csv_line(item))
            elif isinstance(item, Lines):
                rows.append(item.text)
                self._headed = True
            elif isinstance(item, Bad):
                bad.append(bad_line(item))
            else:
                events.append(event_line(item))
                stamped = stamped or item.kind in STAMPS
        whole = self._bad.write("".join(bad))
        # Events first: a row without its gap record would be worse than a gap record without its row.
        if self._events.write("".join(events)):
            if stamped:
                self._sync_events()
            return self._csv.write("".join(rows)) and whole
        self._csv.hold("".join(rows))
        return False

    def _sync_events(self) -> None:
        """Have the disk keep the events before their rows are written; a slow disk is waited for `HURRY_S`, no more.

        The device's clock stands in them alone: a power cut that took them and left their rows would leave rows that
        only the host's clock explains. But rows that wait in memory for a disk are lost if the recorder is killed.
        """
        if self._hurried.done():
            self._hurried = self._hurry.submit(self._events.sync)
        with contextlib.suppress(TimeoutError):
            self._hurried.result(HURRY_S)

    @property
    def refusal(self) -> str:
        """Why the disk does not take what is written, in the system's words; empty if it does."""
        errors = [part.refusal for part in self._parts() if part.refusal]
        return errors[0].strerror or str(errors[0]) if errors else ""

    @property
    def full(self) -> bool:
        """Whether that is for want of room."""
        return any(part.refusal is not None and part.refusal.errno in FULL for part in self._parts())

    @property
    def pending_bytes(self) -> int:
        """Bytes that the disk has not taken."""
        return sum(len(part.pending) for part in self._parts())

    @property
    def unwritten_rows(self) -> int:
        """Rows that the disk has not taken; one that it took in part is one of them."""
        return self._csv.pending.count(b"\n") - self._csv.pending.startswith(TIME.encode())

    @property
    def unwritten_bad(self) -> int:
        """Rejected lines that the disk has not taken."""
        return self._bad.pending.count(b"\n")

    @property
    def sync_failures(self) -> int:
        """How often the disk said that it could not keep what it had taken."""
        return sum(part.sync_failures for part in self._parts())

    def give_up(self) -> None:
        """Forget the rows and rejected lines that the disk does not take, so that the last events have room."""
        self._csv.drop()
        self._bad.drop()
        self.release_room()

    def release_room(self) -> None:
        """Give back the room that was held."""
        with contextlib.suppress(OSError):
            disk.DISK.remove(self._room)

    def sync(self) -> None:
        """Have the disk keep everything written so far."""
        for part in self._parts():
            part.sync()

    def close(self) -> bool:
        """Write what is pending (as far as the disk takes it), sync and close; whether every file is whole."""
        self.release_room()
        self._hurry.shutdown()
        whole = [part.close() for part in self._parts()]
        return all(whole)

    def _hold_room(self, size: int) -> None:
        if not size:
            return
        with contextlib.suppress(FileNotFoundError):
            disk.DISK.remove(self._room)
        try:
            handle = disk.DISK.create(self._room)
            try:
                # Random: a file system that packs its files would hold no room for zeros.
                disk.write_all(handle, secrets.token_bytes(size))
                disk.DISK.sync(handle)
            finally:
                disk.DISK.close(handle)
        except OSError as error:
            if error.errno == errno.EFBIG:
                return  # a limit on single files, not on the disk: what was taken is held
            raise UserError(f"{self._folder}: cannot record here: {error.strerror}; make room, or use -o") from None

    def _parts(self) -> tuple[Appender, Appender, Appender]:
        return self._events, self._bad, self._csv
