"""After an alarm of the force the run is planned anew, within the strain that was reached."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from gcode.support.errors import UserError
from testbench.campaigns.plan import Plan
from testbench.investigating import benches
from testbench.investigating.benches import PortBench, SimulatedBench
from testbench.investigating.state import NAME, load_investigation, program_folder, run_folder
from testbench.recordings.files import read_recording
from testbench.rig.acquisition.recorder import Limits
from testbench.rig.connection.parts import in_memory
from testbench.rig.simulation.played import played
from tests.testbench.investigating.samples import hidden, investigated


class Link:
    """A port whose rig plays the program that it is asked for, as fast as it is listened to."""

    lines: list[bytes]

    def __init__(self, *_port) -> None:
        self.parts = in_memory(self.lines)

    def __iter__(self):
        return self.parts

    def close(self) -> None:
        pass


class Rig(PortBench):
    """A real rig, as far as an investigation sees."""

    def run(self, order, report, stopped=lambda: False):
        motion, _ = played(order.program, order.gauge_length_mm)
        Link.lines = SimulatedBench(hidden()).plan(order).wire_lines(motion)
        super().run(order, report, stopped)


@pytest.fixture
def rig(monkeypatch) -> Rig:
    """It stops where the sensor needs more than `MOST_N`: less than its first motion needs."""
    monkeypatch.setattr(benches, "SerialLink", Link)
    return Rig("port", limits=Limits(max_force_N=MOST_N))


MOST_N = 1.0


def planned_percent(folder, number: int) -> float:
    """Largest strain of a plan."""
    table = np.loadtxt(program_folder(folder, number) / "trajectory.csv", delimiter=",", skiprows=1)
    return float(table[:, 1].max()) / 25 * 100


def test_an_alarm_is_not_met_for_ever(tmp_path, monkeypatch, rig):
    folder, asked = tmp_path / "i", {"max_force_N": MOST_N, "motion": "perlin"}
    with pytest.raises(UserError, match="planned anew then, with less strain"):
        investigated(folder, monkeypatch, [], rig, **asked)
    first = planned_percent(folder, 1)
    reached = 100 * read_recording(run_folder(folder, 1))["displacement_mm"][-1] / 25
    alarms = 1
    while alarms < 20:
        try:
            ended, _ = investigated(folder, monkeypatch, [0.5, 0.99], rig, resume=True)
            break
        except UserError:
            alarms += 1
    assert len(ended.runs) == 2
    assert all((folder / f"run-1-alarm-{k}" / "recording.csv").is_file() for k in range(1, alarms + 1))
    allowed = load_investigation(folder).settings.strain_allowed_percent
    assert allowed <= 0.9 * reached < first
    for number in (1, 2):
        assert planned_percent(folder, number) <= allowed + 1e-6
        assert np.abs(read_recording(run_folder(folder, number))["force_N"]).max() <= MOST_N


def test_where_nothing_is_left_to_plan_it_says_so_and_keeps_the_recording(tmp_path, monkeypatch, rig):
    folder = tmp_path / "i"
    with pytest.raises(UserError, match="alarm"):
        investigated(folder, monkeypatch, [], Rig("port", limits=Limits(max_force_N=0.02)), motion="perlin")
    with pytest.raises(UserError, match=r"no motion can be planned within .* move .*run-1 away"):
        investigated(folder, monkeypatch, [], rig, resume=True)
    (folder / "run-1").rename(folder / "elsewhere")
    with pytest.raises(UserError, match="ended early"):
        investigated(folder, monkeypatch, [], rig, resume=True)


def test_killed_before_the_recording_is_set_aside_it_is_set_aside_once_more(tmp_path, monkeypatch, rig):
    folder = tmp_path / "i"
    with pytest.raises(UserError, match="alarm"):
        investigated(folder, monkeypatch, [], rig, max_force_N=MOST_N, motion="perlin")
    state = json.loads((folder / NAME).read_text())
    (folder / NAME).write_text(json.dumps(state | {"runs": []}))
    with pytest.raises(UserError, match="alarm"):
        investigated(folder, monkeypatch, [], Rig("port", limits=Limits(max_force_N=0.01)), resume=True)
    assert (folder / "run-1-alarm-1").is_dir()
    assert load_investigation(folder).settings.strain_allowed_percent is not None


def test_where_the_device_sent_no_force_the_same_motion_is_recorded_anew(tmp_path, monkeypatch, rig):
    """The load cell was not connected: that says nothing of the motion."""
    folder, deaf = tmp_path / "i", Rig("port", limits=Limits(max_force_N=1e3))
    lines_of = Plan.wire_lines
    monkeypatch.setattr(
        Plan, "wire_lines", lambda self, motion: list(replace(self.rig(motion).readings(), force_uN=None).lines())
    )
    with pytest.raises(UserError, match="connect the load cell"):
        investigated(folder, monkeypatch, [], deaf, max_force_N=1e3, motion="perlin")
    program = (program_folder(folder, 1) / "program.tap").read_bytes()
    monkeypatch.setattr(Plan, "wire_lines", lines_of)
    ended, _ = investigated(folder, monkeypatch, [0.99], deaf, resume=True)
    assert ended.settings.strain_allowed_percent is None
    assert (program_folder(folder, 1) / "program.tap").read_bytes() == program
    assert (folder / "run-1-alarm-1").is_dir()
