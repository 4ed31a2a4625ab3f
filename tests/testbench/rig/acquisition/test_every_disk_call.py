"""Every single call that reaches the disk fails once, for ever, or with the power: what is promised holds each time.

A recording, a campaign, a model and a data set's list are written on a `FaultyDisk` whose first call fails, then its
second, and so on until the work runs through untouched.
"""

from __future__ import annotations

import contextlib
import errno
import json
import os
from itertools import count
from pathlib import Path

import pytest

from gcode.support import disk
from gcode.support.errors import UserError
from testbench.campaigns.campaign import simulate_campaign
from testbench.campaigns.datasets.index import index_problems, write_entries
from testbench.campaigns.record import Job, begin, job_of, record
from testbench.knit.catalogue import baseline
from testbench.recordings.files import read_recording, write_recording_csv
from testbench.recordings.manifest import NAME, problems, read_manifest
from testbench.results.model_file import ModelFile, load_model_file
from testbench.rig.acquisition.recorder import Limits
from testbench.rig.connection.parts import Chunk, End
from testbench.rig.protocol.items import Row, csv_line
from testbench.rig.protocol.stream import Intake
from tests.faulty_disk import AFTER_A_CUT, FaultyDisk, PowerCut
from tests.testbench.rig.rigs import plan, program, rig, triangle

BATCHES = [3, 5, 1, 8, 4, 6]
LINES = list(rig(duration_s=2.0).lines())[: sum(BATCHES)]
MORE = list(rig(duration_s=4.0).lines())[40:60]


@pytest.fixture(autouse=True)
def _by_hand(monkeypatch):
    """Syncs come between batches, not from a thread; a small room and a program that is played once."""
    monkeypatch.setattr("testbench.campaigns.campaign.synced", Hand)
    monkeypatch.setattr("testbench.campaigns.record.ROOM_BYTES", 64)
    motion = triangle(30.0), 25.0
    monkeypatch.setattr("testbench.campaigns.record.played", lambda *_: motion)


class Hand(contextlib.nullcontext):
    """In place of the `synced`: nothing runs beside the recorder, the link syncs."""

    def __init__(self, sink) -> None:
        super().__init__()
        Hand.sink, Hand.synced_rows = sink, 0


def link(lines: list[bytes], batches: list[int], garbage: bytes = b"$K1,garbage\n"):
    """The lines in batches, some rubbish between them, a sync after every second batch."""
    at = 0
    for number, size in enumerate(batches):
        yield Chunk(number * 0.3, b"".join(lines[at : at + size]) + (garbage if number == 1 else b""))
        at += size
        if number % 2:
            failures = Hand.sink.sync_failures
            Hand.sink.sync()
            if Hand.sink.sync_failures == failures and not Hand.sink.pending_bytes:
                Hand.synced_rows = at
    yield End(len(batches) * 0.3)


def rows_sent(lines: list[bytes]) -> list[str]:
    intake = Intake()
    return [csv_line(item) for line in lines for item in intake.feed(line, 0.0) if isinstance(item, Row)]


def rows_in(folder: Path) -> list[str]:
    path = folder / "recording.csv"
    text = path.read_bytes() if path.exists() else b""
    return text[: text.rfind(b"\n") + 1].decode().splitlines(keepends=True)[1:]


def new_job(tmp_path: Path) -> Job:
    return Job("/dev/ttyUSB0", 115200, program(tmp_path), 25.0, Limits(), give_up_s=1.0)


def run(job: Job, folder: Path):
    begin(job, folder)
    return record(job, folder, link(LINES, BATCHES), pause=lambda s: None)


def resumed(folder: Path):
    """Take the recording up again; every check that a finished one must pass."""
    before = rows_in(folder)
    status = record(job_of(folder), folder, link(MORE, [len(MORE)], b""), pause=lambda s: None, resume=True)
    assert status.state == "complete"
    assert problems(folder) == []
    recording = read_recording(folder)
    counts = recording.metadata["counts"]
    assert counts["samples"] == len(recording) == len(rows_in(folder)) >= len(MORE)
    return before, counts


def numbers_of(rows: list[str]) -> list[int]:
    """Which of the sent rows these are; each must be one of them, in order."""
    places = {row.split(",", 1)[1]: number for number, row in enumerate(rows_sent(LINES))}
    found = [places[row.split(",", 1)[1]] for row in rows]
    assert found == sorted(set(found))
    return found


def each_call(tmp_path: Path, monkeypatch, work, kind: str, lasting: bool = False):
    """Run `work` with its first, second, ... call failing; yield what came of it, until no call fails."""
    for at in count():
        root = tmp_path / f"{at}"
        root.mkdir()
        faulty = FaultyDisk(root, at, kind, lasting)
        monkeypatch.setattr("gcode.support.disk.DISK", faulty)
        try:
            outcome = work(root)
        except (UserError, OSError, PowerCut) as error:
            outcome = error
        reached = faulty.calls > at
        faulty.mend()
        for handle in list(faulty.open):
            os.close(handle)
        faulty.open.clear()
        if not reached:
            assert not isinstance(outcome, BaseException)
            return
        yield at, faulty, root, outcome


@pytest.mark.parametrize("lasting", [False, True], ids=["once", "for ever"])
@pytest.mark.parametrize("kind", ["full", "broken"])
def test_a_recording_on_a_disk_that_refuses_any_one_call(tmp_path, monkeypatch, kind, lasting):
    job, want, tried = new_job(tmp_path), rows_sent(LINES), 0
    for at, faulty, root, outcome in each_call(
        tmp_path, monkeypatch, lambda root: run(job, root / "c"), kind, lasting
    ):
        tried += 1
        faulty.dead = False
        folder = root / "c"
        rows = rows_in(folder)
        assert rows == want[: len(rows)], at
        if isinstance(outcome, BaseException):
            assert isinstance(outcome, UserError | OSError)
            assert not rows or not (folder / NAME).exists() or read_manifest(folder)[0].in_progress
            if isinstance(outcome, UserError) and folder.exists():
                resumed(folder)
            continue
        # The loss is exact, on the screen and in the manifest.
        assert outcome.unwritten == outcome.samples - len(rows), at
        assert outcome.samples == len(want) or outcome.state in ("disk full", "disk error")
        campaign, _ = read_manifest(folder)
        if campaign.in_progress:
            assert "manifest could not be written" in outcome.message
            assert outcome.state in ("disk full", "disk error")
            resumed(folder)
            continue
        assert (outcome.state == "complete") == (not outcome.unwritten), (at, outcome)
        assert problems(folder) == []
        assert campaign.status == outcome.state
        assert campaign.counts["samples"] == len(rows)
        assert campaign.counts.get("unwritten", 0) == outcome.unwritten
        if outcome.unwritten:
            assert str(outcome.unwritten) in outcome.message
        if len(rows) > 1:
            assert len(read_recording(folder)) == len(rows)
    print(f"\nrecording, {kind}, {'for ever' if lasting else 'once'}: {tried} calls failed in turn")
    assert tried > 25


def test_a_refusal_that_passes_loses_nothing(tmp_path, monkeypatch):
    """Once the recording is under way, a single refused call costs no row and no event."""
    job, want = new_job(tmp_path), rows_sent(LINES)
    ended = [
        (outcome.state, rows_in(root / "c") == want)
        for _, _, root, outcome in each_call(tmp_path, monkeypatch, lambda root: run(job, root / "c"), "full")
        if not isinstance(outcome, BaseException)
    ]
    assert len(ended) > 15
    assert all(whole for _, whole in ended)


@pytest.mark.parametrize("fate", AFTER_A_CUT)
def test_a_recording_whose_power_goes_at_any_call(tmp_path, monkeypatch, fate):
    """What was synced is there; the rest is whole rows that were sent; it goes on, and every lost row is counted."""
    job, tried = new_job(tmp_path), 0
    begun = {}

    def work(root: Path):
        Hand.synced_rows = 0
        begin(job, root / "c")
        begun[root] = True
        return record(job, root / "c", link(LINES, BATCHES), pause=lambda s: None)

    for at, faulty, root, outcome in each_call(tmp_path, monkeypatch, work, "power"):
        assert isinstance(outcome, PowerCut)
        tried += 1
        faulty.dead = False
        after = faulty.after_the_cut(tmp_path / f"{fate}{at}", fate, seed=at)
        monkeypatch.setattr("gcode.support.disk.DISK", FaultyDisk(after))
        folder = after / "c"
        if not (folder / NAME).exists():
            assert root not in begun, "a recording that had begun is gone"
            continue
        if not read_manifest(folder)[0].in_progress:
            assert problems(folder) == []
            assert len(read_recording(folder)) == len(LINES)
            continue
        before, counts = resumed(folder)
        kept = rows_in(folder)[: -len(MORE)]
        numbers = numbers_of(kept)
        assert len(kept) >= Hand.synced_rows, (at, fate)
        if numbers and "reboot" not in (folder / "events.jsonl").read_text():
            # Exactly, unless the platter lost rows in the middle: those are counted as lost then.
            missing = len(range(numbers[0], 40)) - len(numbers)
            assert missing <= counts["lost"] <= missing + (numbers[0] if fate == "torn" else 0)
        if fate != "torn":
            assert kept == before
    print(f"\nrecording, power cut, unsynced bytes {fate}: {tried} calls in turn")
    assert tried > 25


@pytest.mark.parametrize(
    ("kind", "lasting"), [("full", False), ("full", True), ("broken", False), ("broken", True), ("power", False)]
)
def test_a_simulated_campaign_is_whole_or_not_there(tmp_path, monkeypatch, kind, lasting):
    wish, motion, tried = plan(tmp_path), triangle(1.0), 0

    def work(root: Path):
        return simulate_campaign(wish, root / "c", motion)

    for at, faulty, root, outcome in each_call(tmp_path, monkeypatch, work, kind, lasting):
        tried += 1
        places = [root]
        if kind == "power":
            places = [faulty.after_the_cut(tmp_path / f"{fate}{at}", fate, at) for fate in AFTER_A_CUT]
        for place in places:
            if (place / "c").exists():
                assert problems(place / "c") == [], at
                assert len(read_recording(place / "c")) > 20
            else:
                assert isinstance(outcome, BaseException)
        if isinstance(outcome, OSError):
            assert outcome.errno in (errno.ENOSPC, errno.EIO)
    print(f"\ncampaign, {kind}, {'for ever' if lasting else 'once'}: {tried} calls in turn")
    assert tried > 12


WRITERS = {
    "model": (
        lambda path, n: ModelFile(baseline(), 25.0 + n).save(path),
        lambda path: load_model_file(path).gauge_length_mm - 25.0,
    ),
    "list of campaigns": (
        lambda path, n: write_entries(path.parent, [{**ENTRY, "seed": n}]),
        lambda path: seed_listed(path.parent),
    ),
    "recording": (
        lambda path, n: write_recording_csv(path, read_recording(shifted(path, n), 25.0)),
        lambda path: read_recording(path, 25.0)["force_N"][0],
    ),
}
ENTRY = {"campaign": "a", "sensor": "s", "program": "p", "samples": 2, "manifest_sha256": "0" * 64}


def shifted(path: Path, n: int) -> Path:
    source = path.with_name("source.txt")
    source.write_text(f"time_s,displacement_mm,force_N\n0,0,{n}\n1,1,{n}\n")
    return source


def seed_listed(folder: Path) -> int:
    index_problems(folder)
    return json.loads((folder / "dataset.json").read_text())["campaigns"][0]["seed"]


@pytest.mark.parametrize("kind", ["full", "broken", "power"])
@pytest.mark.parametrize("what", WRITERS)
def test_a_file_that_is_replaced_is_the_old_or_the_new_one(tmp_path, monkeypatch, what, kind):
    write, read = WRITERS[what]
    tried = 0

    def work(root: Path):
        now = disk.DISK
        at, now.at = now.at, 1 << 60
        write(root / "dataset.json", 1)
        now.at, now.calls = at, 0
        write(root / "dataset.json", 2)

    for at, faulty, root, outcome in each_call(tmp_path, monkeypatch, work, kind):
        tried += 1
        places = [root]
        if kind == "power":
            places = [faulty.after_the_cut(tmp_path / f"{fate}{at}", fate, at) for fate in AFTER_A_CUT]
        for place in places:
            (place / "source.txt").unlink(missing_ok=True)
            assert read(place / "dataset.json") == (2 if outcome is None else pytest.approx(1.5, abs=0.5))
            assert [path.name for path in place.iterdir() if kind != "power"] in (["dataset.json"], [])
        if kind != "power":
            assert isinstance(outcome, UserError | None)
    print(f"\n{what}, {kind}: {tried} calls in turn")
    assert tried >= 4
