"""The simulated rig at once and behind its pseudo-terminal make the same recording."""

from __future__ import annotations

import json

import numpy as np
import pytest

from gcode.programs.make import make
from gcode.trajectories.designed import Hold, Triangle
from gcode.trajectories.trajectory import Limits, TrajectorySpec
from testbench.investigating.benches import Order, PtyBench, SimulatedBench, status_of
from testbench.recordings.files import read_recording
from tests.testbench.investigating.samples import hidden

# pyserial drops what has come while it opens a port: on a busy machine that is seconds, 20 times faster than real.
SHORT = Hold(duration_s=40.0) + Triangle(high_percent=20, speed_mm_per_s=5, cycles=4)


@pytest.fixture
def order(tmp_path):
    """Some triangles after a rest."""
    made = make(TrajectorySpec.of(SHORT, name="short", limits=Limits()), 1, 25.0)
    made.write(tmp_path / "plan")
    return Order(tmp_path / "plan" / "program.tap", tmp_path / "run", 25.0, seed=3)


def microseconds(recording) -> np.ndarray:
    """Times as whole numbers, shape (n,)."""
    return np.rint(recording.time_s * 1e6).astype(np.int64)


def test_over_the_pseudo_terminal_comes_what_the_rig_makes_at_once(order, tmp_path):
    at_once = SimulatedBench(hidden())
    PtyBench(at_once, speed=20).run(order, lambda status: None)
    assert status_of(order.folder) == "complete"
    recorded = read_recording(order.folder)
    direct = Order(order.program, tmp_path / "direct", 25.0, seed=3)
    at_once.run(direct, lambda status: None)
    made = read_recording(direct.folder)
    first, *later = (json.loads(line) for line in (order.folder / "events.jsonl").read_text().splitlines())
    start = json.loads((direct.folder / "events.jsonl").read_text().splitlines()[0])
    # The device counts its lines from 0, so a number says which line arrived first; the clock says it of the others.
    made_us = microseconds(made)
    arrived_us = microseconds(recorded) + made_us[first["sequence"]]
    arrived_us = arrived_us[arrived_us <= made_us[-1]]  # a recorder goes on for a second after the motion
    lines = np.searchsorted(made_us, arrived_us)
    assert first["boot"] == start["boot"]
    assert np.array_equal(made_us[lines], arrived_us)
    for channel in ("displacement_mm", "force_N", "resistance_ohm"):
        assert np.array_equal(recorded[channel][: len(lines)], made[channel][lines])
    until_s = recorded.time_s[len(lines) - 1]
    lost = [(event["time_s"], event.get("lost", 0)) for event in later]
    assert lines[-1] + 1 - lines[0] - len(lines) == sum(count for time_s, count in lost if time_s <= until_s)
    assert recorded.metadata["counts"]["lost"] == sum(count for _, count in lost)
    assert len(lines) > 300
    assert recorded.metadata["origin"] == "recorded"


def test_what_is_there_already_is_not_made_again(order):
    bench = SimulatedBench(hidden())
    bench.run(order, lambda status: None)
    before = (order.folder / "recording.csv").stat().st_mtime_ns
    bench.run(order, lambda status: None)
    PtyBench(bench, speed=1.0).run(order, lambda status: None)
    assert (order.folder / "recording.csv").stat().st_mtime_ns == before


def test_a_specimen_that_went_through_a_motion_answers_otherwise(order, tmp_path):
    bench = SimulatedBench(hidden())
    bench.run(order, lambda status: None)
    aged = Order(order.program, tmp_path / "aged", 25.0, [order.program], 5.0, seed=3)
    bench.run(aged, lambda status: None)
    fresh, again = read_recording(order.folder), read_recording(aged.folder)
    assert not np.array_equal(fresh.time_s[:1000], again.time_s[:1000])  # each recording has chance of its own
    time_s = np.arange(0.0, min(fresh.time_s[-1], again.time_s[-1]), 0.02)
    mm, newtons = (
        np.interp(time_s, fresh.time_s, fresh[c]) - np.interp(time_s, again.time_s, again[c])
        for c in ("displacement_mm", "force_N")
    )
    assert np.max(np.abs(mm)) < 0.02
    assert np.median(np.abs(newtons)) > 0.05
