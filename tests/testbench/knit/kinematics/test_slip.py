"""Slip of the clamps against closed-form answers, and the jumps by which it is found."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from testbench.knit.kernels import crossings
from testbench.knit.kinematics.jumps import jumps, slips
from testbench.knit.kinematics.slip import (
    NEVER_S,
    ClampSlip,
    ClampSlipEvents,
    ClampSlipOnce,
    ClampSlipRepeated,
    ClampSlipSliding,
)
from tests.testbench.knit.samples import UP_DOWN_UP


def test_slips_are_a_staircase_of_the_largest_stretch() -> None:
    lost = ClampSlip(fraction=0.5, limit=0.1, step=0.1).added({"strain": UP_DOWN_UP}, 0.05)
    np.testing.assert_allclose(lost[[50, 150, 250, 600, 750]], [0, 0.05, 0.10, 0.15, 0.15], atol=1e-12)


def test_each_pass_slips_once_more() -> None:
    lost = ClampSlipRepeated(amount=0.01, limit=0.15).added({"strain": UP_DOWN_UP}, 0.05)
    np.testing.assert_allclose(lost[[0, 300, 600, 900]], [0, 0.01, 0.01, 0.02], atol=1e-12)


def test_a_pass_needs_a_return_before_it_counts_again() -> None:
    wiggle = np.array([0.0, 0.21, 0.195, 0.21, 0.1, 0.21])
    np.testing.assert_array_equal(crossings(wiggle, 0.2, 0.18), [0, 1, 1, 1, 1, 2])


def test_single_slip_happens_at_its_moment() -> None:
    time_s = np.arange(5.0)
    effect = ClampSlipOnce(amount=0.1, when_s=3, renewed=0)
    strain = effect.apply({"time_s": time_s, "strain": np.ones(5)}, 1.0)["strain"]
    np.testing.assert_allclose(strain, [1, 1, 1, 0.9, 0.9])


def test_sliding_adds_up_the_time_beyond_the_limit() -> None:
    held = np.full(1001, 0.25)
    effect = ClampSlipSliding(amount=0.02, limit=0.2, work_s=1.0, order=1)
    lost = effect.added({"strain": held}, 0.02)
    np.testing.assert_allclose(lost, 0.02 * (1 - 1 / (1 + 0.05 * 0.02 * np.arange(1001))), atol=1e-12)
    assert np.all(effect.apply({"strain": 0.15 * held / 0.25}, 0.02)["strain"] == 0.15)


@pytest.mark.parametrize(
    "law",
    [
        ClampSlip(limit=0.1),
        ClampSlipRepeated(amount=0.01, limit=0.15),
        ClampSlipSliding(limit=0.1),
        ClampSlipOnce(amount=0.1, when_s=60.0),
        ClampSlipEvents(amounts=(0.1,) + 11 * (0.0,), slip_times_s=(60.0,) + 11 * (NEVER_S,)),
    ],
    ids=lambda law: law.name,
)
def test_a_knit_that_was_clamped_anew_has_not_slipped_yet(law) -> None:
    count = len(UP_DOWN_UP)
    once = {"time_s": np.arange(count) * 0.1, "strain": UP_DOWN_UP}
    twice = {"time_s": np.arange(2 * count) * 0.1, "strain": np.tile(UP_DOWN_UP, 2)}
    alone, after = law.added(once, 0.1), law.added(twice | {"clamping": np.repeat([0.0, 1.0], count)}, 0.1)
    np.testing.assert_array_equal(after[:count], alone)
    slips_at_a_strain = "time_s" not in law.reads
    np.testing.assert_allclose(after[count:], alone if slips_at_a_strain else 0.0, atol=1e-12)
    assert np.max(law.added(twice, 0.1)[count:]) > 0


def test_onsets_start_a_fit_inside_the_strain_that_was_reached() -> None:
    measured = {"strain": UP_DOWN_UP, "time_s": np.arange(len(UP_DOWN_UP)) * 0.1}
    for law in (ClampSlip(), ClampSlipRepeated(), ClampSlipSliding()):
        limits = [point["limit"] for point in law.starts(measured, {})]
        assert 0.05 < min(limits) < max(limits) < np.max(UP_DOWN_UP)


def test_events_lengthen_the_knit_from_their_moments_on() -> None:
    time_s = np.arange(6.0)
    times_s = (2.0, 4.0) + (NEVER_S,) * 10
    effect = ClampSlipEvents(amounts=(0.1, 0.05) + (0.02,) * 10, slip_times_s=times_s)
    lost = effect.added({"time_s": time_s, "strain": np.ones(6)}, 1.0)
    np.testing.assert_allclose(lost, [0, 0, 0.1, 0.1, 0.15, 0.15])


def test_a_straight_line_has_no_jumps_and_a_step_has_its_height() -> None:
    x = 3.0 * np.arange(200) + 2.0 * (np.arange(200) >= 100)
    found = jumps(x, 0.04)
    assert np.max(np.abs(found[:90])) < 1e-9
    assert np.max(found) == pytest.approx(2.0)
    assert abs(int(np.argmax(found)) - 100) <= 2


def _cycled(seed: int) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Two minutes of a knit in motion, and a smooth misfit with noise."""
    time_s = np.arange(0, 120, 0.04)
    strain = 0.15 - 0.1 * np.cos(0.4 * time_s)
    signals = {"time_s": time_s, "strain": strain, "force_N": 8 * strain}
    noise = np.random.default_rng(seed).standard_normal(len(time_s))
    return signals, 0.2 * np.sin(0.23 * time_s) + 0.01 * noise


def test_where_nothing_slipped_hardly_a_slip_is_seen() -> None:
    seen = [slips(signals, {"force": smooth}) for signals, smooth in map(_cycled, range(100))]
    assert sum(bool(found) for found in seen) <= 2  # five standard deviations, thousands of moments


@settings(max_examples=15)
@given(st.integers(0, 10_000))
def test_slips_are_found_where_they_were(seed: int) -> None:
    signals, smooth = _cycled(seed)
    # well up, on a way out, on the way back and near a turn
    when_s = np.array([5.4, 56.6, 102.0]) + np.random.default_rng(seed).uniform(-0.5, 0.5, 3)
    slipped = smooth - 0.16 * np.sum(signals["time_s"][:, None] >= when_s, axis=1)
    found_s, amounts = np.transpose(sorted(slips(signals, {"force": slipped})[:3]))
    np.testing.assert_allclose(found_s, when_s, atol=0.13)
    np.testing.assert_allclose(amounts, 0.02, rtol=0.3)


def test_one_slip_starts_where_the_misfit_jumps() -> None:
    time_s = np.arange(0, 120, 0.04)
    strain = 0.15 - 0.1 * np.cos(0.4 * time_s)
    signals = {"time_s": time_s, "strain": strain, "force_N": 8 * strain}
    noise = 0.01 * np.random.default_rng(0).standard_normal(len(time_s))
    (point,) = ClampSlipOnce().starts(signals, {"force": noise - 0.16 * (time_s >= 53)})
    assert point["when_s"] == pytest.approx(53, abs=0.13)
    assert len(ClampSlipOnce().starts(signals, {"force": noise})) == 4


def test_a_slip_is_found_where_samples_are_further_apart_than_slips() -> None:
    """Recordings of a day are compared every three seconds."""
    signals, smooth = _cycled(0)
    signals["time_s"] = 75.0 * signals["time_s"]
    slipped = smooth - 0.16 * (signals["time_s"] >= 75 * 56.6)
    found = slips(signals, {"force": slipped})
    assert len(found) <= 3
    assert abs(found[0][0] - 75 * 56.6) <= 2 * 75 * 0.04
