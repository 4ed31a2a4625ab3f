"""What a recorder holds in its hands: one batch, and a folder for itself; no slow disk makes it more.

These say without a clock what `test_nothing_lost` sees with one.
"""

from __future__ import annotations

import threading
from pathlib import Path

import pytest

from gcode.support.disk import Disk
from gcode.support.errors import UserError
from testbench.campaigns.record import Job, begin, record
from testbench.recordings.files import read_recording
from testbench.recordings.manifest import problems
from testbench.rig.acquisition.recorder import Limits
from testbench.rig.connection.parts import Chunk, End
from testbench.rig.protocol.items import Row, csv_line
from testbench.rig.protocol.stream import Intake
from tests.testbench.rig.rigs import program, rig

LINES = list(rig(duration_s=4.0).lines())[:60]


@pytest.fixture
def job(tmp_path) -> Job:
    job = Job("/dev/ttyUSB0", 115200, program(tmp_path), 25.0, Limits())
    begin(job, tmp_path / "c")
    return job


def rows_of(lines: list[bytes]) -> list[str]:
    intake = Intake()
    return [csv_line(item) for line in lines for item in intake.feed(line, 0.0) if isinstance(item, Row)]


def written(folder: Path) -> list[str]:
    path = folder / "recording.csv"
    return path.read_text().splitlines(keepends=True)[1:] if path.exists() else []


def watched_link(folder: Path, between=lambda number: None):
    """Batches of lines; before each the rows of all earlier ones must be in the file, as the system sees it."""
    for at in range(0, len(LINES), 4):
        assert written(folder) == rows_of(LINES[:at]), at
        between(at)
        rubbish = b"$K1,rubbish\n" if at in (8, 16) else b""
        yield Chunk(at * 0.02, b"".join(LINES[at : at + 4]) + rubbish)
    assert written(folder) == rows_of(LINES)
    yield End(2.0)


def test_each_batch_is_with_the_system_before_the_next_is_asked_for(job, tmp_path):
    assert record(job, tmp_path / "c", watched_link(tmp_path / "c")).state == "complete"
    assert problems(tmp_path / "c") == []


def test_a_disk_that_never_ends_a_sync_does_not_hold_rows_back(job, tmp_path, monkeypatch):
    works = threading.Event()

    class Hanging(Disk):
        def sync(self, handle: int) -> None:
            assert not recording or works.wait(30.0), "the recorder waits for the disk"
            super().sync(handle)

    def between(at: int) -> None:
        recording.append(at)
        if at > 50:
            works.set()  # else it would hang for ever at the end, as it should

    recording: list[int] = []
    monkeypatch.setattr("gcode.support.disk.DISK", Hanging())
    assert record(job, tmp_path / "c", watched_link(tmp_path / "c", between)).state == "complete"
    assert len(recording) > 10
    assert len(read_recording(tmp_path / "c")) == len(LINES)


def test_a_second_recorder_in_the_folder_is_refused_before_it_touches_anything(job, tmp_path):
    folder, refused = tmp_path / "c", []

    def between(at: int) -> None:
        before = {path.name: path.read_bytes() for path in folder.iterdir()}
        for resume in (True, False):
            with pytest.raises(UserError, match="another recorder is at work in this folder"):
                record(job, folder, iter(()), resume=resume)
            refused.append(at)
        assert {path.name: path.read_bytes() for path in folder.iterdir()} == before

    record(job, folder, watched_link(folder, between))
    assert len(refused) > 10
    assert len(read_recording(folder)) == len(LINES)


def test_what_another_recorder_finished_meanwhile_is_not_taken_up(job, tmp_path):
    record(job, tmp_path / "c", watched_link(tmp_path / "c"))
    with pytest.raises(UserError, match="this recording is complete"):
        record(job, tmp_path / "c", iter(()), resume=True)
    assert problems(tmp_path / "c") == []
