"""The grid that a recording is put on."""

from __future__ import annotations

import numpy as np
import pytest

from testbench.comparing.model_errors import noise_floors, rms_errors
from testbench.fitting.evidence.independent_samples import HOLD_STEP, on_the_grid, telling
from testbench.measurements import preparing
from testbench.measurements.bins import Bins
from testbench.measurements.coarser import _turns_kept, coarser
from testbench.measurements.preparing import prepare
from testbench.measurements.splitting import split
from testbench.recordings.channels import DISPLACEMENT, FORCE
from testbench.recordings.recording import Recording
from tests.testbench.builders import NOISE_N, record, truth

GAUGE_LENGTH_MM = 100.0


def triangles(rate_hz: float, noise_N: float = 0.0) -> Recording:
    """200 cycles of 4 s up to 20 % strain; every turn falls on a sample."""
    time_s = np.arange(0, 800, 1 / rate_hz)
    phase = (time_s * 0.25) % 1
    strain = 0.4 * np.minimum(phase, 1 - phase)
    force_N = 10 * strain + 30 * strain**3
    noise = noise_N * np.random.default_rng(0).standard_normal(len(time_s))
    return Recording(time_s, {DISPLACEMENT: GAUGE_LENGTH_MM * strain, FORCE: force_N + noise}, GAUGE_LENGTH_MM)


def test_samples_at_even_times_and_their_turns_are_kept():
    recording = triangles(12.0)
    measurement = prepare(recording)
    rows = slice(len(measurement.grid_s))
    np.testing.assert_allclose(measurement.grid_s, recording.time_s[rows], atol=1e-9)
    np.testing.assert_allclose(measurement.measured["force"], recording[FORCE][rows], atol=1e-9)
    assert measurement.signals["strain"].max() == pytest.approx(0.2, abs=1e-9)


def test_where_bins_are_averaged_the_grid_lies_in_the_middle_of_their_samples():
    assert prepare(triangles(100.0)).grid_s[0] == pytest.approx(0.015)


@pytest.mark.parametrize("rate_hz", [40.0, 50.0, 100.0, 200.0])
@pytest.mark.parametrize("jitter", [0.0, 0.33])
def test_a_sharp_turn_is_never_overshot(rate_hz, jitter):
    """A friction would remember the turn that was not there for as long as the strain is held."""
    steps = np.exp(jitter * np.random.default_rng(1).standard_normal(int(100 * rate_hz))) / rate_hz
    time_s = np.cumsum(steps)

    def strain_at(times_s):
        """Up in 2 s, held for 2 s, down in 2 s, held for 2 s."""
        return 0.1 * np.clip(np.abs((times_s % 8) - 5) - 1, 0, 2)

    bins = Bins(time_s - time_s[0], 25.0)
    binned, true = bins(strain_at(time_s)), strain_at(bins.grid_s + time_s[0])
    assert 0.0 <= binned.min() <= binned.max() <= 0.2 + 1e-12
    around = np.array([strain_at(bins.grid_s + time_s[0] + off_s) for off_s in (-0.06, 0.0, 0.06)])
    held = np.ptp(around, axis=0) < 1e-12
    assert np.abs(binned - true)[held].max() < 1e-12
    assert np.abs(binned - true).max() < 0.1 * 0.04


def test_an_empty_bin_holds_what_lies_between_its_neighbours_at_its_own_time():
    time_s = np.arange(0, 100, 0.02)
    time_s = np.delete(time_s, [500, 501, 502, 503, 504])
    bins = Bins(time_s, 25.0)
    np.testing.assert_allclose(bins(3.0 * time_s), 3.0 * bins.grid_s, atol=1e-9)


def test_what_is_held_out_cannot_be_seen_in_what_is_fitted():
    """With a jump of the force in the last third the calibration is the same to the last bit."""
    whole = triangles(12.0, 0.01)
    other = {**whole.channels, FORCE: whole[FORCE] + 5.0 * (whole.time_s > 600)}
    parts = [split(one)[0] for one in (whole, Recording(whole.time_s, other, GAUGE_LENGTH_MM))]
    for name in ("signals", "measured"):
        one, another = (getattr(part, name) for part in parts)
        assert all(np.array_equal(values, another[key]) for key, values in one.items())
    assert parts[0].grid_s[-1] < 540


@pytest.mark.parametrize("rate_hz", [12.0, 100.0])
def test_what_was_interpolated_over_a_gap_does_not_count(rate_hz):
    whole = triangles(rate_hz)
    kept = (whole.time_s < 101.3) | (whole.time_s > 104.1)
    measurement = prepare(Recording(whole.time_s[kept], {k: v[kept] for k, v in whole.channels.items()}, 100.0))
    gap = (measurement.grid_s > 101.4) & (measurement.grid_s < 104.0)
    outside = (measurement.grid_s > 10) & ((measurement.grid_s < 101.2) | (measurement.grid_s > 104.2))
    assert not measurement.counts[gap].any()
    assert measurement.counts[outside].all()


def test_in_a_hold_that_is_sampled_rarely_samples_count_and_nothing_between_them():
    time_s = np.r_[np.arange(0, 60, 0.1), np.arange(60, 3600, 30.0)]
    strain = np.minimum(time_s / 50, 1.0)
    force_N = strain + 1e-3 * np.random.default_rng(0).standard_normal(len(time_s))
    measurement = telling(prepare(Recording(time_s, {DISPLACEMENT: 30 * strain, FORCE: force_N}, GAUGE_LENGTH_MM)))
    held_s = measurement.grid_s[measurement.counts & (measurement.grid_s > 200)]
    np.testing.assert_allclose(held_s[:30], np.arange(210, 1110, 30), atol=measurement.dt_s)
    np.testing.assert_allclose(held_s, 30 * np.round(held_s / 30), atol=measurement.dt_s)
    assert np.diff(held_s).max() < 30 + HOLD_STEP * 3600


@pytest.mark.parametrize("rate_hz", [2.0, 10.0, 40.0])
@pytest.mark.parametrize("stroke_s", [60.0, 600.0, 3600.0])
def test_a_slow_stroke_is_motion_at_every_rate(stroke_s, rate_hz):
    time_s = np.arange(0, 2 * stroke_s, 1 / rate_hz)
    strain = 0.3 * (1 - np.abs(time_s / stroke_s - 1))
    force_N = 10 * strain + 1e-3 * np.random.default_rng(0).standard_normal(len(time_s))
    slow = prepare(Recording(time_s, {DISPLACEMENT: GAUGE_LENGTH_MM * strain, FORCE: force_N}, GAUGE_LENGTH_MM))
    assert telling(slow).counts.sum() > 0.8 * slow.counts.sum()
    assert telling(on_the_grid(slow)).counts.sum() > 0.8 * on_the_grid(slow).counts.sum()


@pytest.mark.parametrize("rate_hz", [12.0, 50.0])
def test_a_motion_that_repeats_itself_leaves_the_noise_floor_alone(rate_hz):
    measurement = prepare(triangles(rate_hz, noise_N=0.004))
    assert noise_floors(measurement)["force"] == pytest.approx(0.004, rel=0.15)


def test_the_ramp_before_a_hold_is_no_burn_in():
    time_s = np.arange(0, 600, 0.1)
    strain = np.minimum(time_s / 6, 1.0)
    force_N = strain * (1 - 0.1 * np.log1p(time_s)) + 1e-3 * np.random.default_rng(0).standard_normal(len(time_s))
    held = Recording(time_s, {DISPLACEMENT: GAUGE_LENGTH_MM * strain, FORCE: force_N}, GAUGE_LENGTH_MM)
    measurement = prepare(held)
    assert measurement.grid_s[measurement.counts][0] < 0.2
    cycled = prepare(triangles(12.0))
    assert cycled.grid_s[cycled.counts][0] == pytest.approx(3.0, abs=0.1)


@pytest.mark.parametrize("every", [2, 3, 5, 7])
def test_a_coarser_grid_keeps_the_turns_and_the_start(every):
    recording = triangles(12.0)
    fine = prepare(recording)
    coarse = coarser(fine, 12.0 / every)
    strain = coarse.signals["strain"]
    turns = (strain[1:-1] - strain[:-2]) * (strain[2:] - strain[1:-1]) < 0
    assert coarse.grid_s[0] == 0.0
    assert len(strain) == len(fine.grid_s) // every
    np.testing.assert_allclose(np.unique(strain[1:-1][turns].round(9)), [0.0, 0.2], atol=1e-6)
    np.testing.assert_allclose(coarse.measured["force"], 10 * strain + 30 * strain**3, atol=1e-9)


def test_a_coarser_grid_of_a_noisy_hold_takes_no_extremes():
    fine = prepare(triangles(12.0))
    noise = 1e-4 * np.random.default_rng(1).standard_normal(len(fine.grid_s))
    kept = _turns_kept(0.1 + noise, 6, 1e-4)
    assert np.ptp(np.diff(kept)[1:]) == 0


def test_most_points_hold_whatever_the_rate():
    assert len(coarser(prepare(triangles(25.0)), 12.5, most_points=1000).grid_s) <= 1000


def test_a_long_recording_enters_thinned_its_times_kept(monkeypatch):
    monkeypatch.setattr(preparing, "MOST_READINGS", 4000)
    measurement = prepare(triangles(12.0))
    np.testing.assert_allclose(np.diff(measurement.grid_s), 3 / 12, atol=1e-9)
    assert measurement.recording.duration_s == pytest.approx(800, abs=0.5)


def test_times_since_1970_fill_the_bins_as_times_from_zero_do():
    """A double knows them to a quarter of a microsecond."""
    time_s = np.arange(0, 120, 0.02)
    late_s = (time_s + 1.7e9) - 1.7e9
    assert not np.array_equal(late_s, time_s)
    np.testing.assert_array_equal(Bins(late_s, 25.0)._filled, Bins(time_s, 25.0)._filled)


def paused(pause_s: float, rate_hz: float = 12.5) -> Recording:
    """The triangles with a gap after a quarter of them."""
    whole = triangles(rate_hz)
    late = whole.time_s >= 200
    return Recording(whole.time_s + pause_s * late, whole.channels, GAUGE_LENGTH_MM)


def test_a_gap_takes_few_points_of_the_grid_away_and_no_share_of_the_held_out_part():
    counted = [int(one.counts.sum()) for one in split(paused(0.0))]
    after_gap = [int(one.counts.sum()) for one in split(paused(3600.0))]
    assert after_gap == pytest.approx(counted, abs=30)
    whole, late = prepare(paused(0.0)), prepare(paused(1800.0))
    assert on_the_grid(late).dt_s == pytest.approx(on_the_grid(whole).dt_s)


def test_a_held_out_recording_has_a_rate_of_its_own() -> None:
    """Rare samples to fit on are no reason to judge between rare points."""
    held = split(record(truth(), 240, 2.0, 1), record(truth(), 60, 40.0, 1))[1]
    assert rms_errors(truth(), held)["force"] < 1.1 * NOISE_N
