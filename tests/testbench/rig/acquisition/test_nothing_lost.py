"""Nothing lost: recorders killed, ports unplugged, lines damaged, disks slow and full. Real processes throughout."""

from __future__ import annotations

import json
import random
import resource
import signal
import threading
import time
from itertools import pairwise
from pathlib import Path

import pytest
from numpy.random import default_rng

from testbench import cli
from testbench.campaigns.record import Job, begin, record
from testbench.knit.catalogue import baseline
from testbench.recordings.files import read_recording
from testbench.recordings.manifest import problems
from testbench.rig.acquisition.recorder import Limits
from testbench.rig.acquisition.sink import Sink
from testbench.rig.connection.serial_port import SerialLink
from testbench.rig.protocol.items import Row, csv_line
from testbench.rig.protocol.stream import Intake
from testbench.rig.protocol.wire import MICROS_WRAP
from testbench.rig.simulation.faults import faulty
from testbench.rig.simulation.pty_port import PtyPort
from tests.testbench.rig.devices import PATIENCE_S, Device, Forked, Witness, recorder, until
from tests.testbench.rig.rigs import program, rig

SETTLING_S = 0.25  # pyserial empties the input buffer when it opens a port
AT_MOST_LOST_S = 1.0
HANDS = 3  # device, reader and writer each wait for the machine on a line's way into the file


def rows_of(folder: Path) -> list[str]:
    path = folder / "recording.csv"
    text = path.read_text() if path.exists() else ""
    return text[: text.rfind("\n") + 1].splitlines(keepends=True)[1:]


def number_of(row: str) -> int:
    """The sequence number of a `Device`'s row: it is in the force."""
    return round(float(row.split(",")[2]) * 1e6) - 1_000_000


def check_rows(rows: list[str], device: Device) -> list[int]:
    """Every row is exactly one sent sample, at the device's time since the first row."""
    numbers = [number_of(row) for row in rows]
    assert all(later > earlier for earlier, later in pairwise(numbers))
    first = device.sent[numbers[0]].sample.micros if numbers else 0
    for row, number in zip(rows, numbers, strict=True):
        sample = device.sent[number].sample
        assert row == csv_line(Row((sample.micros - first) % MICROS_WRAP, sample))
    return numbers


def killed_again_and_again(folder: Path, device: Device, wish: Path, kills: int, seed: int) -> None:
    """Kill recorders, most in mid-run, some in their start; each goes on where the one before it died.

    A recorder is in mid-run once it has written what came while it started. From there on a kill costs what was in
    its hands: `AT_MOST_LOST_S`, and what the machine kept a plain writer of lines from its work in the same time.
    """
    chance, in_mid_run, worst_s, waited_s = random.Random(seed), 0, 0.0, 0.0
    with Witness(folder.parent / "witness") as witness:
        for _ in range(kills):
            before = rows_of(folder)
            resume = ["--resume"] if (folder / "datapackage.json").exists() else []
            child = recorder(folder, device.port.name, wish, *resume)
            in_start = chance.random() < 0.2
            if not in_start:
                until(lambda before=before: len(rows_of(folder)) > len(before), child)
                now = len(device.sent)
                until(lambda now=now: number_of(rows_of(folder)[-1]) >= now, child)
            running_s, now = time.monotonic(), len(device.sent) + round(200 * chance.random())
            until(lambda now=now: len(device.sent) >= now)
            killed_s = time.monotonic()
            child.kill()
            child.communicate()
            until(lambda: not device.port.has_reader())
            rows = rows_of(folder)
            assert rows[: len(before)] == before, "what an earlier recorder wrote is not there any more"
            numbers = check_rows(rows, device)[len(before) :]
            if len(rows) >= 2:
                assert len(read_recording(folder)) == len(rows)
            if in_start:
                continue
            in_mid_run += 1
            heard = [one for one in device.sent if one.heard and one.host_s < killed_s]
            heard = [one for one in heard if one.sample.sequence >= numbers[0]]
            # Nothing in the middle is missing; what is missing at the end is no older than was promised.
            assert [one.sample.sequence for one in heard][: len(numbers)] == numbers[: len(heard)]
            lost_s = killed_s - heard[len(numbers)].host_s if len(heard) > len(numbers) else 0.0
            stalled_s = witness.longest_stall_s(running_s - AT_MOST_LOST_S, killed_s)
            worst_s, waited_s = max(worst_s, lost_s), max(waited_s, stalled_s)
            assert lost_s < AT_MOST_LOST_S + HANDS * stalled_s, (lost_s, stalled_s)
    told = f"at most {worst_s * 1e3:.0f} ms were not in the file; a plain writer waited up to {waited_s * 1e3:.0f} ms"
    print(f"\n{kills} kills, {in_mid_run} in mid-run: {told}")
    assert in_mid_run >= kills / 2


def finished_well(folder: Path, device: Device, wish: Path) -> None:
    before = len(rows_of(folder))
    resume = ["--resume"] if (folder / "datapackage.json").exists() else []
    child = recorder(folder, device.port.name, wish, *resume)
    until(lambda: len(rows_of(folder)) > before + 50, child)
    child.send_signal(signal.SIGINT)
    out, err = child.communicate(timeout=PATIENCE_S)
    assert child.returncode == 0, err
    assert "interrupted" in out
    numbers = check_rows(rows_of(folder), device)
    assert problems(folder) == []
    # However often the recorder died, the missing samples are counted, each once.
    lost = read_recording(folder).metadata["counts"]["lost"]
    assert lost == numbers[-1] - numbers[0] + 1 - len(numbers)
    assert len(read_recording(folder)) == len(rows_of(folder))


def test_a_recorder_killed_at_random_instants_loses_at_most_a_second(tmp_path):
    with Device(tmp_path / "port") as device:
        wish = program(tmp_path)
        killed_again_and_again(tmp_path / "c", device, wish, kills=2, seed=1)
        finished_well(tmp_path / "c", device, wish)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [2, 3])
def test_a_recorder_killed_15_times_loses_at_most_a_second_each(tmp_path, seed):
    with Device(tmp_path / "port") as device:
        wish = program(tmp_path)
        killed_again_and_again(tmp_path / "c", device, wish, kills=15, seed=seed)
        finished_well(tmp_path / "c", device, wish)


def unplugged(tmp_path: Path, times: int) -> None:
    folder, wish = tmp_path / "c", program(tmp_path)
    with Device(tmp_path / "port") as device:
        child = recorder(folder, device.port.name, wish)
        until(lambda: len(rows_of(folder)) > 20, child)
        for _ in range(times):
            device.unplug(lines=10)
            until(lambda: not device.away, child)
            # Counted from the device's side: the file may be behind, and the wire must be whole before the next cut.
            plugged_in = len(device.sent)
            until(lambda plugged_in=plugged_in: number_of(rows_of(folder)[-1]) > plugged_in + 20, child)
        child.send_signal(signal.SIGTERM)
        child.communicate(timeout=PATIENCE_S)
    events = [json.loads(line) for line in (folder / "events.jsonl").read_text().splitlines()]
    assert [event["event"] for event in events].count("disconnect") == times
    gaps = [event["lost"] for event in events if event["event"] == "gap"]
    assert len(gaps) == times
    assert min(gaps) >= 10
    numbers = check_rows(rows_of(folder), device)
    counts = read_recording(folder).metadata["counts"]
    assert counts["samples"] == len(numbers)
    assert counts["lost"] == numbers[-1] - numbers[0] + 1 - len(numbers)


def test_unplugging_leaves_gap_records(tmp_path):
    unplugged(tmp_path, 2)


@pytest.mark.slow
def test_fifty_unplugs_leave_fifty_gap_records(tmp_path):
    unplugged(tmp_path, 50)


def test_a_bad_cable_lets_no_wrong_sample_through(tmp_path):
    """5 % of lines garbled, truncated, doubled or late, over a pty into the real recorder."""
    lines, wish = list(rig(duration_s=60.0).lines()), program(tmp_path)
    truth = {line_number(line): line for line in lines}
    port = PtyPort(tmp_path / "port")
    child = recorder(tmp_path / "c", port.name, wish)
    until(port.has_reader, child)
    time.sleep(SETTLING_S)
    for chunk in faulty(lines, 0.05, default_rng(5)):
        port.write(chunk)
    out, err = child.communicate(timeout=PATIENCE_S)
    port.close()
    assert "complete" in out, err
    recording = read_recording(tmp_path / "c")
    counts = recording.metadata["counts"]
    assert counts["samples"] == len(recording)
    assert sum(counts["rejected"].values()) == (tmp_path / "c" / "recording.bad").read_text().count("\n") > 0
    want = {row.split(",", 1)[1] for row in whole_rows(truth.values())}
    assert all(row.split(",", 1)[1] in want for row in rows_of(tmp_path / "c"))


def line_number(line: bytes) -> int:
    return int(line.split(b",")[2])


def whole_rows(lines) -> list[str]:
    intake = Intake()
    return [csv_line(item) for line in lines for item in intake.feed(line, 0.0) if isinstance(item, Row)]


def test_a_second_recorder_on_the_port_is_refused(tmp_path):
    wish = program(tmp_path)
    with Device(tmp_path / "port") as device:
        child = recorder(tmp_path / "c", device.port.name, wish)
        until(lambda: len(rows_of(tmp_path / "c")) > 10, child)
        other = recorder(tmp_path / "d", device.port.name, wish)
        _, err = other.communicate(timeout=PATIENCE_S)
        assert other.returncode == 2
        assert "another program holds this port" in err
        assert not (tmp_path / "d").exists()
        child.send_signal(signal.SIGINT)
        assert "interrupted" in child.communicate(timeout=PATIENCE_S)[0]


def test_a_slow_disk_does_not_make_the_wire_wait(tmp_path, monkeypatch):
    """The disk hangs while 2,000 lines come, seven times what a port buffers; not one is lost."""
    lines = list(rig(duration_s=60.0).lines())[:2000]
    disk_works = threading.Event()

    class SlowSink(Sink):
        def write(self, items):
            disk_works.wait()
            return super().write(items)

    monkeypatch.setattr("testbench.campaigns.record.Sink", SlowSink)
    port = PtyPort()
    link = SerialLink(port.device)
    job = Job(port.device, 115200, program(tmp_path), 25.0, Limits())
    begin(job, tmp_path / "c")
    done: list = []
    worker = threading.Thread(target=lambda: done.append(record(job, tmp_path / "c", link)))
    worker.start()
    for line in lines:
        port.write(line)
    disk_works.set()
    worker.join(timeout=PATIENCE_S)
    link.close()
    port.close()
    want = whole_rows(lines)
    assert rows_of(tmp_path / "c") == want[: len(rows_of(tmp_path / "c"))]
    assert done[0].state == "complete"
    assert done[0].lost == 0


def small_files() -> None:
    resource.setrlimit(resource.RLIMIT_FSIZE, (8_000, 8_000))


def test_a_full_disk_ends_the_recording_with_a_sentence_and_a_readable_file(tmp_path):
    wish = program(tmp_path)
    with Device(tmp_path / "port") as device:
        child = recorder(tmp_path / "c", device.port.name, wish, "--give-up-s", "0.5", before=small_files)
        _, err = child.communicate(timeout=PATIENCE_S)
        assert child.returncode == 1
        assert "disk full" in err
        assert "Traceback" not in err
        check_rows(rows_of(tmp_path / "c"), device)
        assert len(read_recording(tmp_path / "c")) == len(rows_of(tmp_path / "c")) > 100


def test_the_rig_command_and_the_record_command_speak_to_each_other(tmp_path):
    (tmp_path / "model.json").write_text(json.dumps(baseline().to_dict()))
    wish, link = program(tmp_path), tmp_path / "port"
    words = ["--model", str(tmp_path / "model.json"), "--program", str(wish), "--speed", "20", "--faults", "0.05"]
    bench = Forked("rig", *words, "--link", str(link))
    until(link.exists, bench)
    child = recorder(tmp_path / "c", str(link), wish, "--progress-json")
    out, err = child.communicate(timeout=PATIENCE_S)
    assert child.returncode == 0, err
    progress = [json.loads(line) for line in out.splitlines()]
    assert progress[-1]["state"] == "complete"
    assert {"rate_hz", "lost", "rejected", "force_N", "strain", "time_s", "duration_s"} <= set(progress[0])
    bench.communicate(timeout=PATIENCE_S)
    assert bench.returncode == 0
    assert cli.main(["verify", str(tmp_path / "c")]) == 0
    assert not link.exists()
