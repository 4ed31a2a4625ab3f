"""A compensator beside a recording: the recorder shows what the stream gives, and a full disk stops nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

import testbench as tb
from compensation.cli import main
from compensation.model import files
from compensation.model.live import LiveCompensator
from compensation.model.runtime import Status
from compensation.model.streaming import CompensatorStream
from compensation.training.options import Options
from gcode.support.errors import UserError
from testbench.campaigns.record import Job, begin, live_compensator, record
from testbench.commands import record as command
from testbench.recordings.manifest import problems
from testbench.rig.acquisition.recorder import Limits, Recorder
from testbench.rig.acquisition.sink import COMPENSATED, Sink
from testbench.rig.acquisition.status_words import as_text
from testbench.rig.connection.parts import Chunk, End
from testbench.rig.protocol.stream import Intake
from testbench.rig.protocol.wire import Sample, encode
from tests.compensation.conftest import train
from tests.testbench.rig.rigs import program


@pytest.fixture(scope="module")
def compensator(recordings):
    return train(recordings[:1], "force", Options(restarts=1, seed=1, engine="fast"))  # seed 0 is dead: a constant


def samples(recording, count: int = 100) -> list[tuple[int, int]]:
    """Time (us) and resistance (mohm), 50 ms apart."""
    ohm = np.interp(np.arange(count) * 0.05, recording.time_s, recording["resistance_ohm"])
    return [(50_000 * index, round(1e3 * value)) for index, value in enumerate(ohm)]


def test_the_recorder_shows_and_keeps_what_the_stream_gives(compensator, recordings, tmp_path):
    files.save(tmp_path / "c.json", compensator)
    following = live_compensator(tmp_path / "c.json", tmp_path)
    read = samples(recordings[1])
    lines = [encode(Sample(7, n, us, 100_000, mohm, 0)) for n, (us, mohm) in enumerate(read)]
    said = []
    sink = Sink(tmp_path)
    Recorder(Intake(), sink, 25.0, report=lambda status: said.append(as_text(status)), follow=following.follow).run(
        [*(Chunk(0.05 * n, line) for n, line in enumerate(lines)), End(9.0)]
    )
    sink.close()
    following.close()
    stream = CompensatorStream(compensator)
    expected = [stream.update(1e3 / mohm, 0.05) for _, mohm in read]
    table = pd.read_csv(tmp_path / COMPENSATED)
    assert list(table) == ["time_s", "force_N", "low_N", "high_N", "status"]
    assert table[["low_N", "high_N"]].isna().all(axis=None)
    np.testing.assert_allclose(table["force_N"], expected, atol=1e-6)
    assert f"compensated {expected[-1]:.3f} N" in said[-1]


def test_it_keeps_the_interval_as_predict_does(compensator, recordings, tmp_path):
    """Same columns, same ends, whichever of the two wrote the table."""
    files.save(tmp_path / "c.json", replace(compensator, margins=(-0.25, 0.5)))
    live, read = LiveCompensator(tmp_path / "c.json", tmp_path), samples(recordings[1], 700)
    for time_us, mohm in read:
        live.take(time_us, mohm)
    live.close()
    table = pd.DataFrame(read, columns=["time_s", "resistance_ohm"]) * [1e-6, 1e-3]
    table.to_csv(tmp_path / "r.csv", index=False)
    words = ["predict", str(tmp_path / "r.csv"), "--compensator", str(tmp_path / "c.json"), "-o"]
    assert main([*words, str(tmp_path / "p.csv")]) == 0
    shown, predicted = pd.read_csv(tmp_path / COMPENSATED), pd.read_csv(tmp_path / "p.csv")
    pd.testing.assert_frame_equal(shown, predicted, atol=2e-6)
    np.testing.assert_allclose(shown["high_N"] - shown["force_N"], 0.5, atol=2e-6)


def test_what_it_kept_is_sealed_with_the_campaign(compensator, recordings, tmp_path):
    """`compensated.csv` has its hash in the manifest: any bit of it that changes is found."""
    files.save(tmp_path / "c.json", compensator)
    folder, job = tmp_path / "campaign", Job("/dev/ttyUSB0", 115200, program(tmp_path), 25.0, Limits())
    begin(job, folder)
    following = live_compensator(tmp_path / "c.json", folder)
    lines = [encode(Sample(7, n, us, 100_000, mohm, 0)) for n, (us, mohm) in enumerate(samples(recordings[1]))]
    record(job, folder, [*(Chunk(0.05 * n, line) for n, line in enumerate(lines)), End(9.0)], follow=following.follow)
    following.close()
    assert problems(folder) == []
    kept = (folder / COMPENSATED).read_bytes()
    assert len(kept.splitlines()) == 101
    for place in range(0, len(kept), len(kept) // 20):
        changed = bytearray(kept)
        changed[place] ^= 1
        (folder / COMPENSATED).write_bytes(bytes(changed))
        assert any(COMPENSATED in problem for problem in problems(folder)), place
    (folder / COMPENSATED).unlink()
    assert any(COMPENSATED in problem for problem in problems(folder))


def test_a_resumed_recording_goes_on_with_the_same_target(compensator, recordings, tmp_path):
    """One table of two targets would be neither's; it is said before anything is recorded."""
    files.save(tmp_path / "force.json", compensator)
    other = train(recordings[:1], "displacement", Options(restarts=1, seed=1, engine="fast"))
    files.save(tmp_path / "mm.json", other)
    folder = tmp_path / "campaign"
    begin(Job("/dev/no-such-port", 115200, program(tmp_path), 25.0, Limits()), folder)
    live = live_compensator(tmp_path / "force.json", folder)
    for time_us, mohm in samples(recordings[1], 3):
        live.take(time_us, mohm)
    live.close()
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    with pytest.raises(UserError, match=r"begins with 'time_s,force_N,.*mm.json would go on with 'time_s,displace"):
        tb.resume_recording(folder, "/dev/no-such-port", compensator=tmp_path / "mm.json")
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before
    again = live_compensator(tmp_path / "force.json", folder)
    again.take(1_000_000, 5_000_000)
    again.close()
    assert (folder / COMPENSATED).read_text().count("time_s") == 1
    # A line that a kill left half is cut, the first one, too.
    (folder / COMPENSATED).write_text("time_s,for")
    live_compensator(tmp_path / "force.json", folder).close()


def test_no_reading_and_a_lost_disk_stop_nothing(compensator, recordings, tmp_path):
    files.save(tmp_path / "c.json", compensator)
    live = LiveCompensator(tmp_path / "c.json", tmp_path / "not-there")
    values = [live.take(us, mohm) for us, mohm in samples(recordings[1], 20)]
    assert np.isfinite(values).all()
    assert live.take(2_000_000, None) == values[-1]
    assert live.take(1, 5) == values[-1]
    live.close()
    assert not (tmp_path / "not-there").exists()


def test_what_is_no_compensator_is_said_before_the_recording(tmp_path):
    (tmp_path / "no.json").write_text("{}")
    with pytest.raises(UserError, match="not a compensator"):
        live_compensator(tmp_path / "no.json", tmp_path)


def test_the_command_takes_it():
    import argparse

    parser = argparse.ArgumentParser()
    command.add_arguments(parser)
    assert parser.parse_args(["-o", "x", "--compensator", "c.json"]).compensator == "c.json"


@pytest.mark.parametrize(("moved_s", "anew"), [(7200.0, True), (-2.0, True), (0.0, False)])
def test_after_a_long_pause_or_a_restart_of_the_clock_it_begins_anew(
    compensator, recordings, tmp_path, moved_s, anew
):
    files.save(tmp_path / "c.json", compensator)
    live, read = LiveCompensator(tmp_path / "c.json", tmp_path), samples(recordings[1])
    for time_us, mohm in read[:60]:
        live.take(time_us, mohm)
    shown = [live.take(time_us + round(moved_s * 1e6), mohm) for time_us, mohm in read[60:]]
    live.close()
    fresh = CompensatorStream(compensator)
    expected = [fresh.update(1e3 / mohm) for _, mohm in read[61:]]
    assert (shown[1:] == pytest.approx(expected, abs=1e-9)) == anew


def test_a_clock_that_slips_for_one_sample_spoils_that_one_alone(compensator, recordings, tmp_path):
    files.save(tmp_path / "c.json", compensator)
    read = samples(recordings[1])
    for name, slip_us in (("slipped", 10**13), ("whole", 0)):
        (tmp_path / name).mkdir()
        live = LiveCompensator(tmp_path / "c.json", tmp_path / name)
        for index, (time_us, mohm) in enumerate(read):
            if index != 60 or slip_us:
                live.take(time_us + slip_us * (index == 60), mohm)
        live.close()
    slipped, whole = (pd.read_csv(tmp_path / name / COMPENSATED) for name in ("slipped", "whole"))
    assert list(np.flatnonzero(slipped["status"] & int(Status.BAD_STEP))) == [60]
    np.testing.assert_array_equal(slipped.drop(index=60)["force_N"], whole["force_N"])
