"""Where an interrupted recording stood: read from its files, as a killed recorder left them."""

from __future__ import annotations

import re
from array import array
from bisect import bisect_left
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import compress
from pathlib import Path

from gcode.support import disk
from gcode.support.errors import UserError
from gcode.support.files import write_bytes
from gcode.support.strict import check_plain, json_of, read_bytes, validated
from testbench.recordings.channels import DISPLACEMENT, TIME, UNITS
from testbench.recordings.manifest import CSV
from testbench.recordings.stored import EVENTS, StoredEvent
from testbench.rig.acquisition.ending import EndOfMotion
from testbench.rig.acquisition.sink import BAD
from testbench.rig.protocol.items import Bad, bad_line
from testbench.rig.protocol.stream import Anchor, Intake, LateLine
from testbench.rig.protocol.wire import MICROS_WRAP, SEQUENCE_WRAP

MOST_LINE = 8192
MOST_BYTES = 4 << 30
DAMAGED = "damaged on disk"
UNKNOWN_BOOT = -1
_CELL = re.compile(rb"-?\d{1,12}\.\d{1,6}")  # of more, millionths are beyond 64 bits; the wire has no such number


@dataclass
class Left:
    """What a recorder left behind.

    Attributes
    ----------
    channels : tuple of str or None
        From the header; None if not even that was written.
    rows : int
    idle_s : float
        Wall-clock time since the recording was last written.
    events : list of StoredEvent
    bad : Counter
        Rejected lines by reason.
    times_us, displacements_nm : array of int
        Of every row: to find the first movement again, and how many rows came since an event.
    """

    channels: tuple[str, ...] | None = None
    idle_s: float = 0.0
    events: list[StoredEvent] = field(default_factory=list)
    bad: Counter[str] = field(default_factory=Counter)
    times_us: array[int] = field(default_factory=lambda: array("q"))
    displacements_nm: array[int] = field(default_factory=lambda: array("q"))

    @property
    def rows(self) -> int:
        """How many whole rows there are."""
        return len(self.times_us)

    @property
    def last_time_us(self) -> int | None:
        """Of the last whole row."""
        return self.times_us[-1] if self.times_us else None


def mend(folder: Path, wall_s: float) -> Left:
    """Cut unfinished tails off the files in `folder`, take out what a power cut damaged, and read where they end.

    Parameters
    ----------
    folder : Path
    wall_s : float
        Now, in the clock of file times.

    Raises
    ------
    UserError
        If a file is a link or a pipe, or is none that a recorder writes.
    """
    left = Left()
    for name in (CSV, EVENTS, BAD):
        if (folder / name).exists() or (folder / name).is_symlink():
            # Opened as the recorder will: a link or a second name is refused before anything is cut.
            disk.DISK.close(disk.open_growing(folder / name))
            check_plain(folder / name, "recording", MOST_BYTES, may_be_empty=True)
    events = [(_event(folder / EVENTS, line), line) for line, _ in _lines(folder / EVENTS)]
    if (folder / CSV).exists():
        left.idle_s = max(0.0, wall_s - (folder / CSV).stat().st_mtime)
        start = next((event.channels for event, _ in events if event and event.channels), None)
        if aside := _read_rows(folder / CSV, left, start):
            _set_aside(folder, left, aside)
    left.bad = _reasons(folder / BAD)
    left.events = _kept_events(folder / EVENTS, events, -1 if left.last_time_us is None else left.last_time_us)
    return left


def continued(left: Left, now_s: float) -> Intake:
    """An intake that goes on where the files end."""
    intake = Intake(channels=left.channels, accepted=left.rows, bad=left.bad)
    late = left.bad[LateLine.reason]
    intake.lost = max(0, sum(event.lost or 0 for event in left.events) - late)
    stamps = [event for event in left.events if event.micros is not None]
    if left.last_time_us is not None and stamps:
        stamp = stamps[-1]
        if stamp.boot is None or stamp.sequence is None:
            raise UserError(f"{EVENTS}: its last stamp of the device's clock is not whole; start a new recording")
        stamp_us = round(stamp.time_s * 1e6)
        micros = ((stamp.micros or 0) + left.last_time_us - stamp_us) % MICROS_WRAP
        # Every loss leaves an event, so the rows since the last one have no number missing.
        since = sum(time_us > stamp_us for time_us in left.times_us)
        anchor = Anchor(int(stamp.boot, 16), micros, left.last_time_us, now_s - left.idle_s)
        interval_us = (left.last_time_us - stamp_us) / since if since else None
        intake.continue_from(anchor, (stamp.sequence + since) % SEQUENCE_WRAP, interval_us)
    elif left.last_time_us is not None:
        # A power cut took the event with the device's clock: what comes is as after a reboot, timed by the host.
        intake.continue_from(Anchor(UNKNOWN_BOOT, 0, left.last_time_us, now_s - left.idle_s), 0)
    return intake


def watched(ending: EndOfMotion, left: Left) -> EndOfMotion:
    """The end of the motion, having seen what was recorded."""
    for time_us, displacement_nm in zip(left.times_us, left.displacements_nm, strict=True):
        ending.watch(time_us, displacement_nm)
    ending.unseen()
    return ending


def _lines(path: Path) -> Iterator[tuple[bytes, int]]:
    """The whole lines of a file without their line feeds, and where each ends; a damaged one may be cut in pieces."""
    if not path.exists():
        return
    end = 0
    with path.open("rb") as stream:
        while line := stream.readline(MOST_LINE):
            if not line.endswith(b"\n") and len(line) < MOST_LINE:
                return  # the tail that nobody finished
            end += len(line)
            yield line.rstrip(b"\n"), end


def _read_rows(path: Path, left: Left, start: list[str] | None) -> set[int]:
    """Read the rows into `left`; returns the numbers of the lines to set aside: no rows, or against the others' time.

    Zeros that a power cut left behind the last row are cut off. A header that it took is taken from `start`, the
    channels that the first event names.
    """
    strange: dict[int, bool] = {}  # whether there is anything in a line that is no row
    numbers, times_us, displacements_nm, ends = array("q"), array("q"), array("q"), array("q")
    for number, (line, end) in enumerate(_lines(path)):
        ends.append(end)
        if number == 0:
            left.channels = _channels(path, line, start)
        if cells := _cells(line, left.channels):
            numbers.append(number)
            times_us.append(cells[0])
            displacements_nm.append(cells[1])
        elif number or b"\0" in line:
            strange[number] = bool(line.strip(b"\0"))
    kept = _running_forward(times_us)
    strange.update((number, True) for number, keep in zip(numbers, kept, strict=True) if not keep)
    left.times_us = array("q", compress(times_us, kept))
    left.displacements_nm = array("q", compress(displacements_nm, kept))
    last = max(compress(numbers, kept), default=0)
    aside = {number for number, something in strange.items() if something or number < last}
    if not aside:
        _cut(path, ends[last] if ends and last not in strange else 0)
    return aside


def _running_forward(times_us: Sequence[int]) -> bytearray:
    """Which rows to believe: one for each time of the longest run of rising ones, zero for the others.

    One wrong digit makes a row late or early among thousands that agree with each other: that row goes, not they.
    """
    ends_us, ends, before = array("q"), array("q"), array("q")  # the last time and row of the best run of each length
    for row, time_us in enumerate(times_us):
        if not ends or time_us > ends_us[-1]:
            before.append(ends[-1] if ends else -1)
            ends_us.append(time_us)
            ends.append(row)
        else:
            length = bisect_left(ends_us, time_us)
            before.append(ends[length - 1] if length else -1)
            ends_us[length], ends[length] = time_us, row
    kept = bytearray(len(times_us))
    row = ends[-1] if ends else -1
    while row >= 0:
        kept[row] = 1
        row = before[row]
    return kept


def _channels(path: Path, header: bytes, start: list[str] | None) -> tuple[str, ...] | None:
    names = [TIME, *(start or [])] if b"\0" in header else header.decode("latin-1").split(",")
    if names == [TIME]:
        return None  # torn, and no event says what it was
    known = names[:1] == [TIME] and DISPLACEMENT in names and len(set(names)) == len(names)
    if not known or set(names) - set(UNITS):
        raise UserError(f"{path}: its header is none that a recorder writes; start a new recording in another folder")
    return tuple(names[1:])


def _cells(line: bytes, channels: tuple[str, ...] | None) -> tuple[int, int] | None:
    """Time and displacement of a row in whole millionths; None if it is not a whole row."""
    cells = line.split(b",")
    if channels is None or len(cells) != len(channels) + 1 or not all(_CELL.fullmatch(cell) for cell in cells):
        return None
    return _fixed(cells[0]), _fixed(cells[channels.index(DISPLACEMENT) + 1])


def _set_aside(folder: Path, left: Left, aside: set[int]) -> None:
    """Move lines that are no rows out of the recording, into the file of rejected lines."""
    bad, good = [], [",".join((TIME, *left.channels)).encode() + b"\n"] if left.channels else []
    for number, (line, _) in enumerate(_lines(folder / CSV)):
        if not line.strip(b"\0"):
            continue
        if number in aside:
            bad.append(bad_line(Bad(DAMAGED, line)).encode())
        elif number and left.channels:
            good.append(line + b"\n")
    with disk.growing(folder / BAD) as handle:
        disk.write_all(handle, b"".join(bad))
        disk.DISK.sync(handle)
    write_bytes(folder / CSV, b"".join(good), recorded=True)


def _cut(path: Path, size: int) -> None:
    if path.stat().st_size == size:
        return
    with disk.growing(path) as handle:
        disk.DISK.truncate(handle, size)
        disk.DISK.sync(handle)


def _reasons(path: Path) -> Counter[str]:
    """How many lines were rejected for each reason; an unfinished tail is cut."""
    reasons: Counter[str] = Counter()
    end = 0
    for line, after in _lines(path):
        reason = line.partition(b"\t")[0].decode("latin-1")
        reasons[reason if reason.isprintable() and len(reason) <= 40 else DAMAGED] += 1
        end = after
    if path.exists():
        _cut(path, end)
    return reasons


def _kept_events(path: Path, found: list[tuple[StoredEvent | None, bytes]], last_time_us: int) -> list[StoredEvent]:
    """Events up to the last row; those of a row that was not written yet will come again with that row."""
    if not path.exists():
        return []
    kept = [(event, line) for event, line in found if event and round(event.time_s * 1e6) <= last_time_us]
    text = b"".join(line + b"\n" for _, line in kept)
    if text != read_bytes(path, "list of events", MOST_BYTES):
        write_bytes(path, text, recorded=True)
    return [event for event, _ in kept]


def _event(path: Path, line: bytes) -> StoredEvent | None:
    """One event; None for what a power cut left in its place."""
    if b"\0" in line:
        return None
    text = line.decode("utf-8", "replace")
    try:
        return validated(json_of(text, "event", path), StoredEvent, path, "event")
    except UserError:
        raise UserError(f"{path}: holds a line that is no event: {text[:60]!r}; start a new recording") from None


def _fixed(text: bytes) -> int:
    """Six decimals as a whole number of millionths, exactly."""
    whole, _, fraction = text.partition(b".")
    return int(whole + fraction.ljust(6, b"0"))
