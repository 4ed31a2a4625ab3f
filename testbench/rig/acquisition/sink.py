"""The files of a campaign while it is being recorded: appended, never rewritten, readable at any instant.

``recording.csv`` grows by whole lines; ``recording.bad`` keeps every rejected line with its reason;
``events.jsonl`` says what happened: start, gap, reboot, disconnect, resume, alarm. Each batch goes to the operating
system at once, so a killed recorder loses at most the batch in its hands; `synced` takes it to the disk every second.
A disk that takes no more is waited for; room for the last events and the manifest is held from the start (``.room``).
"""

from __future__ import annotations

import contextlib
import errno
import secrets
import threading
from collections.abc import Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

from gcode.support import disk
from gcode.support.errors import UserError
from testbench.recordings.channels import TIME
from testbench.recordings.manifest import CSV
from testbench.recordings.stored import EVENTS
from testbench.rig.acquisition.appender import Appender
from testbench.rig.protocol.items import Bad, Item, Lines, Row, bad_line, csv_line, event_line, header_line

BAD = "recording.bad"
COMPENSATED = "compensated.csv"  # what a compensator made of it while it was recorded
STAMPS = ("start", "reboot", "clock jump", "renumbered", "resume")  # events that alone tell the device's clock
ROOM, ROOM_BYTES = ".room", 256 << 10
HURRY_S = 0.3  # how long rows wait for the disk to keep such an event
FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)


@contextlib.contextmanager
def synced(sink: Sink) -> Iterator[None]:
    """Within the block, a thread calls `Sink.sync` every second, so that no slow disk keeps a recorder waiting."""
    ended = threading.Event()

    def sync() -> None:
        while not ended.wait(1.0):
            sink.sync()

    thread = threading.Thread(target=sync, daemon=True)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()  # a sync may be under way


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
        self._parts = (self._events, self._bad, self._csv)
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
        self._csv.pending += "".join(rows).encode()
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
        errors = [part.refusal for part in self._parts if part.refusal]
        return errors[0].strerror or str(errors[0]) if errors else ""

    @property
    def full(self) -> bool:
        """Whether that is for want of room."""
        return any(part.refusal is not None and part.refusal.errno in FULL for part in self._parts)

    @property
    def pending_bytes(self) -> int:
        """Bytes that the disk has not taken."""
        return sum(len(part.pending) for part in self._parts)

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
        return sum(part.sync_failures for part in self._parts)

    @property
    def disturbed(self) -> str:
        """What another program did to the files meanwhile, in words; empty if nothing."""
        names = ", ".join(part.path.name for part in self._parts if part.disturbed)
        return names and f"{names}: removed, replaced or cut by another program, and what was in it is lost"

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
        for part in self._parts:
            part.sync()

    def close(self) -> bool:
        """Write what is pending (as far as the disk takes it), sync, close; whether each file is whole and ours."""
        self.release_room()
        self._hurry.shutdown()
        ours = not self.disturbed  # a manifest must not seal what somebody else put there
        whole = [part.close() for part in self._parts]
        return all(whole) and ours

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
            raise UserError(
                f"{self._folder}: cannot record here: {error.strerror}; make room, or choose another folder"
            ) from None
