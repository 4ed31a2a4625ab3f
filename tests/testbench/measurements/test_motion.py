"""The motion behind a noisy reading of the displacement."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from testbench.knit.mechanics.hysteresis import HysteresisBoucWen
from testbench.measurements.motion import TURN, reading_noise, without_reading_noise, without_small_turns
from testbench.measurements.preparing import prepare
from testbench.recordings.channels import DISPLACEMENT, FORCE
from testbench.recordings.recording import Recording

RATE_HZ, GAUGE_LENGTH_MM = 25.0, 50.0
TIME_S = np.arange(0, 300, 1 / RATE_HZ)


def ramps_and_holds(time_s: np.ndarray, hold_s: float = 20.0, speed_per_s: float = 0.02) -> np.ndarray:
    """Strain up to 0.2, down to 0.05 and so on, with a hold after each ramp."""
    corners, values, at = [0.0], [0.0], 0.0
    for target in [0.2, 0.05] * 20:
        at += abs(target - values[-1]) / speed_per_s
        corners, values = [*corners, at, at + hold_s], [*values, target, target]
        at += hold_s
    return np.interp(time_s, corners, values)


def noise(sd: float, seed: int) -> np.ndarray:
    return np.random.default_rng(seed).normal(0, sd, len(TIME_S))


def moved(reading: np.ndarray, sd: float) -> np.ndarray:
    """The motion behind a reading, as `prepare` takes it."""
    return without_small_turns(*without_reading_noise(reading, sd), sd)[0]


def turns(motion: np.ndarray) -> int:
    ways = np.sign(np.diff(motion))
    return int(np.sum(np.diff(ways[ways != 0]) != 0))


@given(st.floats(1e-6, 1e-3), st.integers(0, 1000))
def test_the_noise_of_a_reading_is_found_at_uneven_times(sd, seed):
    rng = np.random.default_rng(seed)
    time_s = np.cumsum(rng.uniform(0.5, 1.5, len(TIME_S))) / RATE_HZ
    reading = 0.1 - 0.1 * np.cos(0.4 * time_s) + rng.normal(0, sd, len(time_s))
    assert reading_noise(time_s, reading) == pytest.approx(sd, rel=0.25)


def test_a_clock_that_jitters_is_no_noise():
    read_at_s = TIME_S + np.random.default_rng(0).uniform(-0.01, 0.01, len(TIME_S))
    strain = ramps_and_holds(read_at_s)
    assert np.std(strain - ramps_and_holds(TIME_S)) > 5e-5
    assert reading_noise(TIME_S, strain) < 1e-12


def test_a_reading_too_short_to_tell_has_no_noise():
    assert reading_noise(TIME_S[:6], TIME_S[:6] ** 2) == 0.0


def test_without_noise_nothing_changes():
    strain = ramps_and_holds(TIME_S)
    np.testing.assert_allclose(without_reading_noise(strain, 0.0)[0], strain, rtol=0, atol=1e-12)
    np.testing.assert_allclose(without_small_turns(strain, strain, 0.0)[0], strain, rtol=0, atol=1e-12)


@given(st.floats(1e-6, 1e-3), st.integers(0, 1000))
def test_turns_stay_and_holds_become_still(sd, seed):
    strain = ramps_and_holds(TIME_S)
    found = moved(strain + noise(sd, seed), sd)
    assert np.max(np.abs(found - strain)) < 6 * sd
    assert np.std(found - strain) < 0.5 * sd
    middle_of_hold = (TIME_S > 15) & (TIME_S < 25)  # the first hold lasts from 10 s to 30 s
    assert np.median(np.abs(found[middle_of_hold] - 0.2)) < 0.25 * sd


def test_the_level_of_a_hold_is_found_ten_times_as_closely_as_it_is_read():
    strain = ramps_and_holds(TIME_S)
    middle_of_hold = (TIME_S > 15) & (TIME_S < 25)
    found = [moved(strain + noise(1e-4, seed), 1e-4)[middle_of_hold] for seed in range(30)]
    assert np.mean([np.median(np.abs(one - 0.2)) for one in found]) < 0.1e-4


@given(st.floats(1e-5, 1e-3), st.integers(0, 1000))
def test_a_smooth_motion_is_found_more_closely_than_it_is_read(sd, seed):
    strain = 0.1 - 0.1 * np.cos(0.4 * TIME_S)
    found, left = without_reading_noise(strain + noise(sd, seed), sd)
    off = found - strain
    assert np.std(off) < 0.7 * sd
    assert np.sqrt(np.mean(left**2)) == pytest.approx(np.std(off), rel=0.4)


@given(st.floats(1e-5, 1e-3), st.integers(0, 1000))
def test_no_sample_is_thought_free_of_noise(sd, seed):
    strain = 0.1 - 0.1 * np.cos(0.4 * TIME_S)
    found, left = without_reading_noise(strain + noise(sd, seed), sd)
    assert 0.6 < np.sqrt(np.mean(((found - strain) / left) ** 2)) < 1.5


@pytest.mark.parametrize("sd", [1e-7, 1e-5, 1e-3])
def test_it_is_never_further_off_than_the_reading(sd):
    """However quickly the motion turns: its bends are not cut off for the sake of the noise."""
    strain = 0.1 - 0.1 * np.cos(2 * np.pi * 2.0 * TIME_S)
    found, left = without_reading_noise(strain + noise(sd, seed=0), sd)
    assert np.std(found - strain) < 1.05 * sd
    assert np.sqrt(np.mean(left**2)) == pytest.approx(np.std(found - strain), rel=0.2)


@given(st.floats(1e-6, 1e-3), st.integers(0, 1000))
def test_a_hold_stands_still_and_turns_keep_their_place(sd, seed):
    strain = ramps_and_holds(TIME_S)
    smooth, left = without_reading_noise(strain + noise(sd, seed), sd)
    found = without_small_turns(smooth, left, sd)[0]
    middle_of_hold = (TIME_S > 15) & (TIME_S < 25)
    assert turns(found[middle_of_hold]) <= 2 < 20 < turns(smooth[middle_of_hold])
    assert turns(strain) <= turns(found) < turns(strain) + 10
    assert np.max(np.abs(found - smooth)) < 1.01 * TURN * sd


@pytest.mark.parametrize("step_mm", [0.002, 0.005, 0.02])
def test_steps_of_the_reading_are_noise_though_it_repeats_itself_when_slow(step_mm):
    strain = 0.1 - 0.1 * np.cos(0.4 * TIME_S)
    reading_mm = np.round(GAUGE_LENGTH_MM * strain / step_mm) * step_mm
    recording = Recording(TIME_S, {DISPLACEMENT: reading_mm, FORCE: 10 * strain}, GAUGE_LENGTH_MM)
    made = prepare(recording)
    moved = 0.1 - 0.1 * np.cos(0.4 * made.grid_s)
    off = made.signals["strain"] - moved
    assert np.std(off) < 0.6 * step_mm / GAUGE_LENGTH_MM / 12**0.5
    assert 0.4 * np.std(off) < np.sqrt(np.mean(made.strain_noise**2)) < 1.1 * np.std(off)


def test_a_ramp_before_a_long_hold_is_no_coarse_step():
    strain = np.interp(TIME_S, [0, 5, 11, 300], [0, 0, 0.3, 0.3])
    reading_mm = np.round(100.0 * (strain + noise(2e-5, seed=3)), 3)
    made = prepare(Recording(TIME_S, {DISPLACEMENT: reading_mm, FORCE: 10 * strain}, 100.0))
    moved = np.interp(made.grid_s, [0, 5, 11, 300], [0, 0, 0.3, 0.3])
    ramp = (made.grid_s > 4) & (made.grid_s < 12)
    assert np.max(np.abs(made.signals["strain"] - moved)[ramp]) < 1e-4


def test_friction_keeps_its_force_in_a_hold_that_was_read_with_noise():
    strain = ramps_and_holds(TIME_S)
    reading = strain + noise(1e-4, seed=1)
    friction = HysteresisBoucWen(friction_N=1.0, pressed=0.0, threshold=0.02, skew=0.0)
    at_its_end = np.searchsorted(TIME_S, 29.0)

    def force_N(motion: np.ndarray) -> float:
        signals = {"strain": motion, "force_N": np.zeros_like(motion)}
        return float(friction.apply(signals, 1 / RATE_HZ)["force_N"][at_its_end])

    assert force_N(strain) > 0.99
    assert force_N(reading) < 0.1
    smooth, left = without_reading_noise(reading, 1e-4)
    assert force_N(smooth) > 0.8
    assert force_N(without_small_turns(smooth, left, 1e-4)[0]) > 0.95


@given(st.floats(1e-6, 1e-3), st.integers(0, 1000))
def test_a_hold_is_known_as_well_as_a_mean_of_its_readings(sd, seed):
    strain = ramps_and_holds(TIME_S)
    found, left = without_small_turns(*without_reading_noise(strain + noise(sd, seed), sd), sd)
    middle_of_hold = (TIME_S > 15) & (TIME_S < 25)
    assert np.median(left[middle_of_hold]) < 0.2 * sd
    assert np.sqrt(np.mean(((found - strain) / left) ** 2)) < 1.5


def test_a_turn_that_the_noise_hid_is_part_of_the_error():
    sd, small = 1e-3, 4e-3
    strain = np.interp(TIME_S, [0, 100, 103, 106, 300], [0, 0.1, 0.1 - small, 0.1, 0.3])
    found, left = without_small_turns(*without_reading_noise(strain + noise(sd, seed=4), sd), sd)
    turn = (TIME_S > 100) & (TIME_S < 106)
    assert np.ptp(found[turn]) < 0.5 * small
    assert 0.6 < np.sqrt(np.mean(((found - strain) / left)[turn] ** 2)) < 1.5


def test_a_measurement_moves_as_the_machine_did():
    strain = ramps_and_holds(TIME_S)
    reading_mm = GAUGE_LENGTH_MM * (strain + noise(1e-4, seed=2))
    recording = Recording(TIME_S, {DISPLACEMENT: reading_mm, FORCE: 10 * strain}, GAUGE_LENGTH_MM)
    seen = prepare(recording).signals["strain"]
    moved = ramps_and_holds(prepare(recording).grid_s)
    assert np.std(seen - moved) < 0.85e-4
