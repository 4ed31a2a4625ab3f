"""A rig that delivers at once leaves the bytes that its lines leave when they go over the wire."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from testbench.knit.catalogue import baseline
from testbench.recordings.instruments import Instruments, Room, SampleClock
from testbench.rig.acquisition.recorder import Recorder
from testbench.rig.acquisition.sink import Sink
from testbench.rig.connection.parts import Accepted, Chunk, in_memory
from testbench.rig.protocol.stream import Intake
from testbench.rig.simulation.at_once import at_once, is_plain
from testbench.rig.simulation.simulated import SimulatedRig
from tests.testbench.rig.rigs import triangle

NO_RESISTANCE = baseline().without("drift").without("contact")
RIGS = {
    "the paper's bench": SimulatedRig(baseline(), triangle(120.0), 25.0, 3),
    "a thermometer": SimulatedRig(baseline(), triangle(), 25.0, 4, Instruments(room=Room(swing_C=3.0))),
    "force alone": SimulatedRig(NO_RESISTANCE, triangle(), 25.0, 5),
    "a slow clock": SimulatedRig(baseline(), triangle(), 25.0, 6, Instruments(clock=SampleClock(rate_hz=0.7))),
    "a long gauge and a stretch below zero": SimulatedRig(baseline(), triangle(top_mm=-12.0), 900.0, 7),
}


def kept(folder, link):
    """What a recorder makes of a link: its files, and how it ended."""
    folder.mkdir()
    intake = Intake(host_clock=False)
    sink = Sink(folder)
    reports = []
    status = Recorder(intake, sink, 25.0, duration_s=20.0, report=lambda now: reports.append(repr(now))).run(link)
    sink.close()
    files = {path.name: path.read_bytes() for path in folder.iterdir()}
    return files, status, reports, (intake.accepted, intake.lost, intake.bad, intake.channels, intake.anchor)


@pytest.mark.parametrize("name", RIGS)
def test_the_files_the_status_and_the_counts_are_those_of_the_wire(tmp_path, name):
    rig = RIGS[name]
    assert kept(tmp_path / "a", at_once(rig)) == kept(tmp_path / "b", in_memory(rig.lines()))


def test_nothing_is_decoded_where_every_line_would_be_accepted():
    assert {type(part) for part in at_once(RIGS["the paper's bench"])} >= {Accepted}
    assert not any(isinstance(part, Chunk) for part in at_once(RIGS["the paper's bench"]))


def test_a_gap_goes_over_the_wire_so_that_it_is_an_event(tmp_path):
    slow = RIGS["a slow clock"]
    assert not is_plain(slow.readings())
    files, *_ = kept(tmp_path / "a", at_once(slow))
    assert b'"event": "gap"' in files["events.jsonl"]


def test_a_number_that_no_line_can_carry_is_left_to_the_wire():
    readings = RIGS["a thermometer"].readings()
    assert is_plain(readings)
    assert not is_plain(replace(readings, displacement_nm=readings.displacement_nm + 10**10))
    assert not is_plain(replace(readings, resistance_mohm=readings.resistance_mohm + 10**15))
    assert not is_plain(replace(readings, resistance_mohm=-readings.resistance_mohm))
    assert not is_plain(replace(readings, force_uN=readings.force_uN - 10**11))
    assert not is_plain(replace(readings, temperature_mC=readings.temperature_mC + 10**7))
    assert not is_plain(replace(readings, micros=np.zeros_like(readings.micros)))
