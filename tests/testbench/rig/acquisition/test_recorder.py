"""The recorder as a fold over lists: limits, endings, disks that fill up, files that grow."""

from __future__ import annotations

import errno
import json
import os
from dataclasses import replace

import numpy as np
import pytest

from gcode.support.errors import UserError
from testbench.campaigns.record import Job, begin, job_of, record
from testbench.knit.catalogue import baseline
from testbench.recordings.files import read_recording
from testbench.recordings.manifest import read_manifest
from testbench.rig.acquisition.appender import Appender
from testbench.rig.acquisition.ending import EndOfMotion
from testbench.rig.acquisition.recorder import Limits, Recorder
from testbench.rig.acquisition.resume import mend
from testbench.rig.acquisition.sink import Sink
from testbench.rig.connection.parts import Chunk, End, Lost, Tick, in_memory
from testbench.rig.protocol.stream import Intake
from testbench.rig.protocol.wire import decode, encode
from testbench.rig.simulation.played import played
from testbench.rig.simulation.simulated import SIMULATED_HZ, Motion, SimulatedRig
from tests.testbench.rig.rigs import program, rig


@pytest.fixture
def job(tmp_path):
    return Job("/dev/ttyUSB0", 115200, program(tmp_path), 25.0, Limits())


def bench_lines(job: Job, hold_s: float = 3.0) -> list[bytes]:
    motion = played(job.program)[0].held(hold_s)
    return list(SimulatedRig(baseline(), motion, 25.0, 1).lines())


def recorded(job, folder, link, **more):
    begin(job, folder)
    return record(job, folder, link, **more)


def events(folder):
    return [json.loads(line) for line in (folder / "events.jsonl").read_text().splitlines()]


def test_a_recording_ends_a_second_after_the_programs_motion(job, tmp_path):
    status = recorded(job, tmp_path / "c", in_memory(bench_lines(job, hold_s=60)))
    assert status.state == "complete"
    # Found by the first movement of 0.2 mm, which a jittered sample sees up to 0.1 s late.
    assert status.time_s == pytest.approx(played(job.program)[0].duration_s + 1.0, abs=0.15)
    assert read_recording(tmp_path / "c").metadata["status"] == "complete"


def slowed(job: Job, times: float) -> tuple[Motion, list[bytes]]:
    """What the bench reads where the machine takes so many times longer than planned, and a minute of rest."""
    planned = played(job.program)[0]
    time_s = np.arange(round(planned.duration_s * times * SIMULATED_HZ)) / SIMULATED_HZ
    motion = Motion(time_s, np.interp(time_s / times, planned.time_s, planned.displacement_mm))
    return motion, list(SimulatedRig(baseline(), motion.held(60.0), 25.0, 1).lines())


def test_a_machine_that_is_slower_than_planned_is_recorded_to_its_end(job, tmp_path):
    motion, lines = slowed(job, 1.3)
    status = recorded(job, tmp_path / "c", in_memory(lines))
    assert status.state == "complete"
    assert motion.duration_s < status.time_s < motion.duration_s + 2.0


def test_a_stage_that_never_stands_still_is_not_waited_for_for_ever(job, tmp_path):
    planned_s = played(job.program)[0].duration_s
    time_s = np.arange(round(5 * planned_s * SIMULATED_HZ)) / SIMULATED_HZ
    swaying = Motion(time_s, np.sin(time_s))
    lines = SimulatedRig(baseline(), swaying, 25.0, 1).lines()
    status = recorded(job, tmp_path / "c", in_memory(lines))
    assert status.state == "complete"
    assert status.time_s == pytest.approx(2 * planned_s, abs=3.0)


def test_an_end_before_the_planned_way_was_seen_is_said(job, tmp_path):
    """The stage is moved by hand and stands until the planned time is over: that was called complete in silence."""
    planned_s = played(job.program)[0].duration_s
    time_s = np.arange(round(3 * planned_s * SIMULATED_HZ)) / SIMULATED_HZ
    lines = SimulatedRig(baseline(), Motion(time_s, np.minimum(time_s, 1.0)), 25.0, 1).lines()
    status = recorded(job, tmp_path / "c", in_memory(lines))
    assert (status.state, events(tmp_path / "c")[-1]["message"]) == ("complete", status.message)
    assert status.message == "the stage was seen to come 1.0 mm of the planned 20.0 mm: was all of it recorded?"
    whole = recorded(job, tmp_path / "whole", in_memory(bench_lines(job, hold_s=60)))
    assert whole.message == ""


def test_the_clock_of_the_end_waits_for_the_machine(job):
    motion = played(job.program)[0]
    ending = EndOfMotion.of(motion)
    for second in range(30):
        ending.watch(second * 1_000_000, 0)
    assert ending.waiting
    ending.watch(30_000_000, 300_000)
    assert not ending.waiting
    assert ending._end_us / 1e6 == pytest.approx(30 + motion.duration_s - ending.first_move_s + 1)


def test_force_beyond_the_limit_stops_with_an_alarm_that_is_marked(job, tmp_path):
    strict = Job(job.port, job.baud, job.program, 25.0, Limits(max_force_N=0.6))
    status = recorded(strict, tmp_path / "c", in_memory(bench_lines(job), size=1))
    assert status.state == "alarm"
    assert "is beyond the limit of 0.6 N" in status.message
    recording = read_recording(tmp_path / "c")
    assert recording.metadata["status"] == "alarm"
    assert recording["force_N"][-1] > 0.6 >= recording["force_N"][:-1].max()
    assert events(tmp_path / "c")[-2]["event"] == "alarm"


def test_a_force_limit_without_a_force_to_watch_is_an_alarm_at_once(job, tmp_path):
    strict = Job(job.port, job.baud, job.program, 25.0, Limits(max_force_N=20))
    mute = [encode(decode(line.rstrip())._replace(force_uN=None)) for line in bench_lines(job)]
    status = recorded(strict, tmp_path / "c", in_memory(mute))
    assert (status.state, status.samples) == ("alarm", 1)
    assert "the device sends no force, so the limit of 20 N cannot be watched" in status.message
    assert recorded(job, tmp_path / "without", in_memory(mute)).state == "complete"


def test_strain_beyond_the_limit_stops_too(job, tmp_path):
    strict = Job(job.port, job.baud, job.program, 25.0, Limits(max_strain=0.1))
    assert "strain" in recorded(strict, tmp_path / "c", in_memory(bench_lines(job))).message
    assert read_recording(tmp_path / "c").strain[-1] == pytest.approx(0.1, abs=0.02)


def test_ctrl_c_ends_it_well(job, tmp_path):
    lines, calls = bench_lines(job), iter(range(1000))
    status = recorded(job, tmp_path / "c", in_memory(lines, size=10), stopped=lambda: next(calls) == 4)
    assert status.state == "interrupted"
    assert len(read_recording(tmp_path / "c")) == 50
    assert events(tmp_path / "c")[-1]["event"] == "end"


def test_an_unplugged_port_leaves_a_gap_record(job, tmp_path):
    lines = bench_lines(job)
    parts = [
        Chunk(0, b"".join(lines[:50]) + lines[50][:9]),
        Lost(1, "unplugged"),
        Tick(2),
        Chunk(3, b"".join(lines[130:])),
    ]
    status = recorded(job, tmp_path / "c", [*parts, End(9)])
    kinds = [event["event"] for event in events(tmp_path / "c")]
    assert kinds == ["start", "disconnect", "gap", "end"]
    assert status.lost == 80
    assert "cut off" in (tmp_path / "c" / "recording.bad").read_text()


def test_progress_tells_rate_losses_force_and_strain(job, tmp_path):
    seen = []
    parts = [Chunk(0.6 * n, line) for n, line in enumerate(bench_lines(job))]
    recorded(job, tmp_path / "c", [*parts, End(1e4)], report=lambda status: seen.append(vars(status).copy()))
    middle = seen[len(seen) // 2]
    assert 30 < middle["rate_hz"] < 45
    assert middle["strain"] > 0
    assert middle["duration_s"] == pytest.approx(4.0, abs=0.5)
    end = seen[-1]
    assert end["state"] == "complete"
    assert end["rate_hz"] == pytest.approx((end["samples"] - 1) / end["time_s"], rel=1e-12)  # of all of it


def test_a_reader_of_a_growing_file_never_sees_half_a_line(job, tmp_path):
    begin(job, tmp_path / "c")
    whole = b"".join(bench_lines(job))
    lengths = []

    def watched():
        for start in range(0, len(whole), 997):
            yield Chunk(0.0, whole[start : start + 997])
            lengths.append(len(read_recording(tmp_path / "c")))
            with (tmp_path / "c" / "recording.csv").open("ab") as stream:
                size = stream.tell()
                stream.write(b"9999.1,2")
            assert len(read_recording(tmp_path / "c")) == lengths[-1]
            os.truncate(tmp_path / "c" / "recording.csv", size)

    record(job, tmp_path / "c", watched())
    assert lengths == sorted(lengths)
    assert lengths[-1] > 100


def test_a_second_recorder_on_the_same_files_is_refused(tmp_path):
    first = Sink(tmp_path)
    with pytest.raises(UserError, match="another recorder"):
        Sink(tmp_path)
    first.close()
    Sink(tmp_path).close()


def put_another(path):
    path.rename(path.with_name("old.csv"))
    path.write_text("time_s,displacement_mm\n0,0\n1,1\n")


MEDDLING = {"removed": os.unlink, "cut": lambda path: os.truncate(path, 100), "replaced": put_another}


@pytest.mark.parametrize("name", ["recording.csv", "events.jsonl"])
@pytest.mark.parametrize("meddled", MEDDLING)
def test_a_file_that_another_program_took_away_is_said_and_not_sealed(job, tmp_path, meddled, name):
    lines, messages = bench_lines(job), []
    link = full_and_free_again(lines, lambda: MEDDLING[meddled](tmp_path / "c" / name))
    status = recorded(job, tmp_path / "c", link, report=lambda status: messages.append(status.message))
    said = f"{name}: removed, replaced or cut by another program, and what was in it is lost"
    assert sum(said in message for message in messages) > 2  # at once, not only at the end
    assert (status.state, said in status.message) == ("disk error", True)
    assert "the campaign stays unfinished" in status.message
    assert read_manifest(tmp_path / "c")[0].status == "recording"


class Stingy(Appender):
    """A disk that takes `room` bytes until it is emptied."""

    room = 10**9

    def take(self, data: bytes) -> int:
        if not Stingy.room:
            raise OSError(errno.ENOSPC, "No space left on device")
        taken = super().take(data[: Stingy.room])
        Stingy.room -= taken
        return taken


@pytest.fixture
def stingy(monkeypatch):
    monkeypatch.setattr("testbench.rig.acquisition.sink.Appender", Stingy)
    Stingy.room = 3000
    return Stingy


def full_and_free_again(lines, free):
    for number, line in enumerate(lines):
        if number == len(lines) // 2:
            free()
        yield Chunk(number / 40, line)
    yield End(len(lines) / 40)


def test_a_disk_that_is_full_for_a_while_loses_nothing(stingy, job, tmp_path):
    def free():
        stingy.room = 10**9

    lines = bench_lines(job)
    messages = []
    recorded(
        job, tmp_path / "c", full_and_free_again(lines, free), report=lambda status: messages.append(status.message)
    )
    stingy.room = 10**9
    recorded(job, tmp_path / "d", in_memory(lines))
    assert (tmp_path / "c" / "recording.csv").read_bytes() == (tmp_path / "d" / "recording.csv").read_bytes()
    assert any("the disk is full" in message for message in messages)


def test_a_disk_that_stays_full_ends_with_a_readable_file(stingy, job, tmp_path):
    hasty = replace(job, give_up_s=1.0)
    status = recorded(hasty, tmp_path / "c", full_and_free_again(bench_lines(job), lambda: None))
    assert status.state == "disk full"
    recording = read_recording(tmp_path / "c")
    assert len(recording) == recording.metadata["counts"]["samples"] > 50
    assert mend(tmp_path / "c", 0.0).rows == len(recording)


def test_killed_anywhere_it_goes_on_where_it_was(job, tmp_path):
    """Cut the files at any byte, as a kill would, and resume: every row is one that was sent, with its time."""
    lines = bench_lines(job)
    recorded(job, tmp_path / "whole", in_memory(lines))
    want = (tmp_path / "whole" / "recording.csv").read_text().splitlines()
    for cut in (0, 5, 40, 46, 47, 100, 1500, 1501, 1530):
        folder = tmp_path / f"cut{cut}"
        begin(job, folder)
        (folder / "events.jsonl").write_bytes((tmp_path / "whole" / "events.jsonl").read_bytes().splitlines(True)[0])
        (folder / "recording.csv").write_bytes((tmp_path / "whole" / "recording.csv").read_bytes()[:cut])
        kept = max(0, (folder / "recording.csv").read_bytes().count(b"\n") - 1)
        status = record(job_of(folder), folder, in_memory(lines[kept:]), resume=True)
        assert status.state == "complete"
        assert (folder / "recording.csv").read_text().splitlines() == want, cut
        assert "resume" in [event["event"] for event in events(folder)]


def test_what_was_missed_while_the_recorder_was_dead_is_counted(job, tmp_path):
    lines = bench_lines(job)
    recorded(job, tmp_path / "c", [Chunk(0, b"".join(lines[:20] + lines[25:50]))], stopped=lambda: True)
    status = record(job_of(tmp_path / "c"), tmp_path / "c", in_memory(lines[90:]), resume=True)
    assert status.lost == 5 + 40
    assert [event["lost"] for event in events(tmp_path / "c") if event["event"] == "gap"] == [40]


def test_a_power_cut_that_left_zeros_is_mended(job, tmp_path):
    recorded(job, tmp_path / "c", in_memory(bench_lines(job)))
    path = tmp_path / "c" / "recording.csv"
    good = path.read_bytes()
    path.write_bytes(good + b"\0" * 100 + b"\n")
    assert mend(tmp_path / "c", 0.0).rows == good.count(b"\n") - 1
    assert path.read_bytes() == good


@pytest.mark.parametrize(
    ("number", "first"),
    [(20, b"9"), (20, b"-"), (20, b"999999999999999"), (20, b"9999999999999999999"), (2, b"5"), (118, b"0")],
)
def test_one_wrong_digit_of_a_time_costs_one_row(job, tmp_path, number, first):
    """A row that says a late time is wrong, and not the hundred that follow it."""
    lines, folder = bench_lines(job), tmp_path / "c"
    recorded(job, folder, [Chunk(0, b"".join(lines[:120]))], stopped=lambda: True)
    path = folder / "recording.csv"
    good = path.read_bytes().splitlines(keepends=True)
    wrong = first + good[number][1:]
    path.write_bytes(b"".join([*good[:number], wrong, *good[number + 1 :]]))
    status = record(job_of(folder), folder, in_memory(lines[120:]), resume=True)
    assert path.read_bytes().splitlines(keepends=True)[:120] == good[:number] + good[number + 1 :]
    assert (status.state, status.lost) == ("complete", 1)
    assert (folder / "recording.bad").read_bytes() == b"damaged on disk\t" + wrong


def test_what_is_no_row_at_the_end_is_kept_aside(job, tmp_path):
    recorded(job, tmp_path / "c", in_memory(bench_lines(job)))
    path = tmp_path / "c" / "recording.csv"
    good = path.read_bytes()
    path.write_bytes(good + b"\0" * 100 + b"\n7.5,1.0\n\0\0")
    mend(tmp_path / "c", 0.0)
    assert path.read_bytes() == good
    assert (tmp_path / "c" / "recording.bad").read_text() == "damaged on disk\t7.5,1.0\n"


def test_a_complete_recording_is_not_continued(job, tmp_path):
    recorded(job, tmp_path / "c", in_memory(bench_lines(job)))
    with pytest.raises(UserError, match="is complete"):
        job_of(tmp_path / "c")


def test_recorder_without_a_sample_says_so(tmp_path):
    sink = Sink(tmp_path)
    status = Recorder(Intake(), sink, 25.0).run([Tick(0.0), End(1.0, "port lost", "gone")])
    sink.close()
    assert (status.state, status.samples) == ("port lost", 0)


def test_the_same_lines_make_the_same_rows_through_any_link(tmp_path):
    lines = list(rig(duration_s=5.0).lines())
    for name, size in (("a", 1), ("b", 512)):
        (tmp_path / name).mkdir()
        sink = Sink(tmp_path / name)
        Recorder(Intake(), sink, 25.0).run(in_memory(lines, size))
        sink.close()
    assert (tmp_path / "a" / "recording.csv").read_bytes() == (tmp_path / "b" / "recording.csv").read_bytes()


def test_a_disk_that_fills_up_at_the_very_end_is_waited_for(stingy, job, tmp_path):
    stingy.room = 5_000
    waits = []

    def pause(seconds):
        waits.append(seconds)
        if len(waits) == 3:
            stingy.room = 10**9

    lines = bench_lines(job)
    status = recorded(job, tmp_path / "c", in_memory(lines), pause=pause)
    assert (status.state, status.unwritten) == ("complete", 0)
    assert len(waits) == 3
    assert len(read_recording(tmp_path / "c")) == status.samples


def test_rows_that_a_full_disk_never_took_are_counted_everywhere(stingy, job, tmp_path, monkeypatch):
    stingy.room = 5_000
    release = Sink.release_room

    def released(sink):
        release(sink)
        stingy.room = 4096

    monkeypatch.setattr(Sink, "release_room", released)
    seen = []
    hasty = replace(job, give_up_s=1.0)
    status = recorded(hasty, tmp_path / "c", in_memory(bench_lines(job)), pause=seen.append)
    recording = read_recording(tmp_path / "c")
    assert status.state == recording.metadata["status"] == "disk full"
    assert status.unwritten == status.samples - len(recording) > 0
    assert recording.metadata["counts"]["unwritten"] == status.unwritten
    assert f"the last {status.unwritten} rows" in status.message
    assert [event["rows"] for event in events(tmp_path / "c") if event["event"] == "unwritten"] == [status.unwritten]
    assert not (tmp_path / "c" / ".room").exists()
