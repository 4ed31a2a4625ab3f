"""A disk that is really full: a small one in a namespace of its own, on which the recording takes the last room.

`tests/faulty_disk.py` refuses calls one by one; here the system does it, at whatever byte the room ends. The disk is
a tmpfs, or an ext4 in a file where the machine lets the test have a loop device.
"""

from __future__ import annotations

import io
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import pytest

from testbench.campaigns.record import Job, begin, record
from testbench.recordings.files import read_recording
from testbench.recordings.manifest import problems
from testbench.rig.acquisition.recorder import Limits
from testbench.rig.acquisition.sink import ROOM_BYTES
from testbench.rig.acquisition.status_words import terminal
from testbench.rig.connection.parts import Chunk, End, Part
from tests.testbench.rig.acquisition.test_recorder import bench_lines
from tests.testbench.rig.rigs import PROGRAM_TEXT

TRIANGLES = 30
ROOM_FOR_ROWS = 40_000  # bytes; the recording needs twice as many
NAMESPACE = ("unshare", "--user", "--map-root-user", "--mount")
DISKS = {
    "tmpfs": (NAMESPACE, 'mount -t tmpfs -o size=2m small "$1"'),
    # Only root of the machine may have a loop device; the mount ends with the namespace.
    "ext4": (("unshare", "--mount"), 'truncate -s 3M "$1.img" && mkfs.ext4 -q -m 0 "$1.img" && mount "$1.img" "$1"'),
}
CALL = "import sys; from tests.testbench.rig.acquisition.test_full_disk import fill; fill(*sys.argv[1:])"


def job_in(folder: Path) -> Job:
    """A job of a minute whose program is on a disk with room; it waits a second for a full one."""
    path = folder / "triangles.tap"
    path.write_text(PROGRAM_TEXT.replace("M30", "G1 X5 F300\nG1 X0 F300\n" * TRIANGLES + "M30"))
    return Job("/dev/ttyUSB0", 115200, path, 25.0, Limits(), give_up_s=1.0)


def wire(lines: list[bytes], at_half: Callable[[], None] = lambda: None) -> Iterator[Part]:
    """The lines at their times, as a port delivers them."""
    for number, line in enumerate(lines):
        if number == len(lines) // 2:
            at_half()
        yield Chunk(number / 40, line)
    yield End(len(lines) / 40)


def recorded(place: Path, out: Path, name: str, when: str) -> dict[str, Any]:
    """One recording in `place`, whose disk is full after `ROOM_FOR_ROWS`, and has room again `when`."""
    job, folder, filler = job_in(out), place / name, place / "filler"
    lines, screen = bench_lines(job), io.StringIO()
    begin(job, folder)
    free = os.statvfs(place)
    filler.write_bytes(b"x" * (free.f_bavail * free.f_bsize - ROOM_BYTES - ROOM_FOR_ROWS))

    def pause(seconds: float) -> None:
        if when == "at the end":
            filler.unlink(missing_ok=True)

    def at_half() -> None:
        if when == "in mid-run":
            filler.unlink()

    patient = replace(job, give_up_s=1.0 if when == "never" else 600.0)
    status = record(patient, folder, wire(lines, at_half), terminal("rig", screen), pause=pause, clock=lambda: 0.0)
    filler.unlink(missing_ok=True)
    shutil.copytree(folder, out / name)
    if when == "never":
        record(job, folder, wire(lines[status.samples :]), resume=True, pause=pause, clock=lambda: 0.0)
        shutil.copytree(folder, out / "resumed")
    shutil.rmtree(folder)
    return {"status": asdict(status), "screen": screen.getvalue()}


def fill(place: str, out: str) -> None:
    """All of it on the disk of `place`; what was recorded is copied to `out`."""
    whens = {"full": "never", "middle": "in mid-run", "end": "at the end"}
    told = {name: recorded(Path(place), Path(out), name, when) for name, when in whens.items()}
    (Path(out) / "told.json").write_text(json.dumps(told))


def on_a_small_disk(kind: str, place: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """Run words where `place` is a small disk, which nobody else sees and which is gone with them."""
    namespace, mount = DISKS[kind]
    shell = [*namespace, "sh", "-c", f'{mount} && shift && exec "$@"', "sh", str(place), *words]
    return subprocess.run(shell, capture_output=True, text=True)


@pytest.fixture(scope="module", params=DISKS)
def out(request, tmp_path_factory) -> Path:
    """What was recorded on the small disk, and what was told of it."""
    folder, place = tmp_path_factory.mktemp("out"), tmp_path_factory.mktemp("place")
    if not shutil.which("unshare") or on_a_small_disk(request.param, place, "true").returncode:
        pytest.skip(f"this machine lets no test have a {request.param} of its own")
    child = on_a_small_disk(request.param, place, sys.executable, "-c", CALL, str(place), str(folder))
    assert child.returncode == 0, child.stderr
    return folder


def told(out: Path, name: str) -> tuple[dict[str, Any], str]:
    """The last status and the screen."""
    one = json.loads((out / "told.json").read_text())[name]
    return one["status"], one["screen"]


def whole(out: Path) -> bytes:
    """The recording that a disk with room has."""
    job = job_in(out)
    folder = out / "whole"
    if not folder.exists():
        begin(job, folder)
        record(job, folder, wire(bench_lines(job)))
    return (folder / "recording.csv").read_bytes()


def test_what_a_full_disk_never_took_is_counted_in_the_manifest_in_the_events_and_on_the_screen(out):
    status, screen = told(out, "full")
    recording = read_recording(out / "full")
    events = [json.loads(line) for line in (out / "full" / "events.jsonl").read_text().splitlines()]
    lost = status["unwritten"]
    print(f"\n{status['samples']} rows accepted, {len(recording)} in the file, {lost} counted as not written")
    assert status["state"] == recording.metadata["status"] == "disk full"
    assert len(recording) + lost == status["samples"] > len(recording) > 500
    assert recording.metadata["counts"]["unwritten"] == lost > 0
    assert recording.metadata["counts"]["samples"] == len(recording)
    assert [(event["event"], event.get("rows")) for event in events[-2:]] == [("unwritten", lost), ("end", None)]
    assert events[-1]["state"] == "disk full"
    assert f"{lost} NOT WRITTEN" in screen.splitlines()[-1]
    assert f"the disk is full (No space left on device): the last {lost} rows" in screen.splitlines()[-1]
    assert "bytes wait in memory; make room" in screen
    assert problems(out / "full") == []
    assert whole(out).startswith((out / "full" / "recording.csv").read_bytes())


def test_once_there_is_room_it_goes_on_and_what_was_not_written_is_lost(out):
    status, _ = told(out, "full")
    recording, rows = read_recording(out / "resumed"), whole(out).splitlines()
    written = status["samples"] - status["unwritten"]
    assert recording.metadata["status"] == "complete"
    assert recording.metadata["counts"]["lost"] == status["unwritten"]
    resumed = (out / "resumed" / "recording.csv").read_bytes().splitlines()
    assert resumed == rows[: 1 + written] + rows[1 + status["samples"] :]
    assert problems(out / "resumed") == []


@pytest.mark.parametrize("name", ["middle", "end"])
def test_where_room_is_made_nothing_is_lost(out, name):
    status, screen = told(out, name)
    assert (status["state"], status["unwritten"]) == ("complete", 0)
    assert "the disk is full" in screen
    assert (out / name / "recording.csv").read_bytes() == whole(out)
    assert problems(out / name) == []
