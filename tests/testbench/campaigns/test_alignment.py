"""Alignment: a delay and a drift put in by hand come out again."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import gcode
from gcode.support.errors import UserError
from testbench import cli
from testbench.campaigns.alignment import PLANNED, align, applied, best_lag
from testbench.campaigns.campaign import simulate_campaign
from testbench.recordings.files import read_recording
from testbench.recordings.recording import Recording
from testbench.rig.simulation.played import played
from testbench.rig.simulation.simulated import SIMULATED_HZ, Motion
from tests.testbench.rig.rigs import plan


def wander(duration_s: float = 240.0, seed: int = 1) -> Motion:
    """A smooth, never-repeating motion."""
    time_s = np.arange(int(duration_s * SIMULATED_HZ)) / SIMULATED_HZ
    rng = np.random.default_rng(seed)
    waves = [np.sin(2 * np.pi * rng.uniform(0.02, 0.3) * time_s + rng.uniform(0, 6)) for _ in range(8)]
    return Motion(time_s, 3.0 + np.sum(waves, axis=0) * 0.5)


def recorded(motion: Motion, delay_s: float, drift_ppm: float, tail_s: float = 5.0, seed: int = 2) -> Recording:
    """What a rig records of `motion` with clocks apart: jittered samples, encoder steps, another zero."""
    rng = np.random.default_rng(seed)
    end_s = motion.duration_s + delay_s + tail_s
    time_s = np.cumsum(rng.uniform(0.01, 0.04, int(end_s / 0.025)))
    planned_s = (1 + drift_ppm * 1e-6) * time_s - delay_s
    seen_mm = np.interp(planned_s, motion.time_s, motion.displacement_mm) + 1.25
    return Recording(time_s, {"displacement_mm": np.round(seen_mm / 1.25e-3) * 1.25e-3}, 25.0)


@pytest.mark.parametrize(
    ("delay_s", "drift_ppm"), [(0, 0), (7.321, 0), (3.0, 150), (12.5, -400), (0.8, 20_000), (-20.0, 100)]
)
def test_delay_and_drift_come_out_as_they_were_put_in(delay_s, drift_ppm):
    motion = wander()
    found = align(recorded(motion, delay_s, drift_ppm), motion)
    assert found.delay_s == pytest.approx(delay_s, abs=2e-3)
    assert found.drift_ppm == pytest.approx(drift_ppm, abs=10)
    assert found.offset_mm == pytest.approx(1.25, abs=1e-3)
    assert found.rms_mm < 2e-3


def test_a_short_run_is_placed_where_its_clock_does_not_begin_at_zero():
    """Too short for windows: one correlation places it."""
    motion = wander(40.0)
    recording = recorded(motion, 0.0, 0, tail_s=0.0)
    later = replace(recording, time_s=recording.time_s + 8.0)
    assert align(later, motion).delay_s == pytest.approx(8.0, abs=5e-3)


def test_applied_the_recording_is_on_the_plans_clock():
    motion = wander()
    recording = recorded(motion, 7.321, 300)
    found = align(recording, motion)
    on_plan = applied(recording, motion, found)
    assert on_plan.time_s[0] >= 0
    assert on_plan.time_s[-1] <= motion.duration_s
    assert np.abs(on_plan["displacement_mm"] - 1.25 - on_plan[PLANNED]).max() < 5e-3


def test_a_repeated_motion_is_still_placed_by_its_ends():
    time_s = np.arange(int(120 * SIMULATED_HZ)) / SIMULATED_HZ
    motion = Motion(
        time_s, np.where((time_s > 10) & (time_s < 90), 2 - 2 * np.cos(2 * np.pi * (time_s - 10) / 10), 0)
    )
    assert align(recorded(motion, 4.0, 50), motion).delay_s == pytest.approx(4.0, abs=5e-3)


def test_another_programs_recording_is_refused():
    with pytest.raises(UserError, match="does not follow this program"):
        align(recorded(wander(seed=9), 0, 0), wander(seed=1))


@pytest.mark.parametrize("drift_ppm", [-10_000, 10_000])
def test_a_machine_that_runs_at_another_pace_is_followed_from_its_rest_on(tmp_path, drift_ppm):
    """The liveliest window begins while the stage still stands, before the plan."""
    gcode.generate("paper-1", seed=3, duration_s=300).write(tmp_path)
    motion = played(tmp_path / "program.tap")[0]
    found = align(recorded(motion, 10.0, drift_ppm), motion)
    assert found.drift_ppm == pytest.approx(drift_ppm, abs=20)
    assert found.delay_s == pytest.approx(10.0, abs=0.01)


def test_a_displacement_in_another_unit_is_refused():
    motion = wander()
    given = recorded(motion, 7.0, 0)
    with pytest.raises(UserError, match=r"correlation 1\.00, difference .* is the displacement in mm"):
        align(replace(given, channels={"displacement_mm": given["displacement_mm"] / 10}), motion)


def test_a_machine_that_stopped_in_mid_program_is_refused():
    """Placed behind the plan's last strokes, its rest looks like the plan's: only a part of the strokes fits."""
    time_s = np.arange(int(300 * SIMULATED_HZ)) / SIMULATED_HZ
    motion = Motion(time_s, 2.5 - 2.5 * np.cos(2 * np.pi * time_s / 10))
    stopped = Motion(time_s, np.where(time_s < 152.5, motion.displacement_mm, 2.5))
    with pytest.raises(UserError, match="was it run to its end"):
        align(recorded(stopped, 10.0, 0), motion)


@pytest.mark.parametrize("stop_s", [20.0, 120.0, 230.0])
def test_a_machine_that_paused_in_mid_program_is_refused_and_the_place_is_told(stop_s):
    """All strokes but the last few agree then, and with them the correlation."""
    motion = wander()
    paused_s = np.where(motion.time_s < stop_s, motion.time_s, np.maximum(stop_s, motion.time_s - 1.5))
    paused = Motion(motion.time_s, np.interp(paused_s, motion.time_s, motion.displacement_mm))
    with pytest.raises(UserError, match=r"about \d+ s\); .* without a stop"):
        align(recorded(paused, 5.0, 0), motion)


def test_a_stage_that_is_moved_away_after_its_program_is_aligned():
    motion = wander()
    given = recorded(motion, 5.0, 0, tail_s=8.0)
    away_mm = given["displacement_mm"] + np.where(given.time_s > 250.0, 2.0, 0.0)
    assert align(replace(given, channels={"displacement_mm": away_mm}), motion).delay_s == pytest.approx(
        5.0, abs=0.01
    )


def test_a_stage_that_stands_still_is_refused():
    motion = wander()
    still = Motion(motion.time_s, 0 * motion.time_s)
    with pytest.raises(UserError, match="nothing moves"):
        align(recorded(motion, 0, 0), still)


@pytest.mark.parametrize("shift", [-40, 0, 25])
def test_best_lag_of_shifted_noise(shift):
    noise = np.random.default_rng(1).normal(size=2000)
    seen = noise[100 - shift : 1100 - shift]
    lag, quality = best_lag(seen, noise[100:1100])
    assert lag == shift
    assert quality == pytest.approx(1.0)


def test_the_command_reports_and_applies(tmp_path, capsys):
    wish = plan(tmp_path)
    simulate_campaign(wish, tmp_path / "c", played(wish.program)[0])
    assert cli.main(["align", str(tmp_path / "c"), "-o", str(tmp_path / "d"), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["delay_s"] == pytest.approx(0, abs=2e-3)
    assert cli.main(["verify", str(tmp_path / "d")]) == 0
    aligned = read_recording(tmp_path / "d")
    assert aligned.metadata["recipe"]["aligned"]["delay_s"] == found["delay_s"]
    assert aligned.metadata["recipe"]["seed"] == 1
