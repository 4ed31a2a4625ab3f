"""Set of the knit against closed-form answers, and what a knit that has become too long does."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from testbench.knit.kinematics.length import TAUT
from testbench.knit.kinematics.permanent_set import (
    PermanentSet,
    PermanentSetCreep,
    PermanentSetRecovering,
    PermanentSetViscoplastic,
    PermanentSetWorked,
    PermanentSetYield,
)
from testbench.knit.lags import overstress_flow
from tests.testbench.knit.samples import UP_DOWN_UP

HELD = np.full(2001, 0.25)


def test_quick_set_is_a_share_of_the_largest_stretch() -> None:
    added = PermanentSet(fraction=0.2, tau_s=0.01).added({"strain": UP_DOWN_UP}, 1.0)
    assert added[600] == pytest.approx(0.2 * 0.3, rel=0.02)


def test_a_knit_that_grew_too_long_hangs_limp_until_the_length_is_taken_up() -> None:
    strain = PermanentSet(fraction=0.2, tau_s=0.01, renewed=0).apply({"strain": UP_DOWN_UP}, 1.0)["strain"]
    np.testing.assert_array_equal(strain[541:660], 0.0)
    assert strain[-1] == pytest.approx(0.24, abs=1e-3)


def test_it_never_hangs_limp_where_that_part_of_the_law_is_absent() -> None:
    long = PermanentSet(fraction=0.3, tau_s=0.01, renewed=0)
    absent = long.replaced(pretension=TAUT)
    up_and_down = 0.8 * np.abs(np.sin(np.linspace(0, 20, 2000)))
    stretched = absent.apply({"strain": up_and_down}, 0.05)["strain"]
    np.testing.assert_allclose(stretched, up_and_down - absent.added({"strain": up_and_down}, 0.05))


def test_pretension_lets_it_pull_a_little_below_the_start() -> None:
    effect = PermanentSet(fraction=0.2, tau_s=0.01, renewed=0, pretension=0.02)
    assert np.min(effect.apply({"strain": UP_DOWN_UP}, 1.0)["strain"]) == pytest.approx(-0.02)


def test_strain_counts_on_the_new_length_where_that_stretches_along() -> None:
    effect = PermanentSetYield(fraction=0.5, limit=0.1, span=0.2, renewed=1)
    strain = effect.apply({"strain": UP_DOWN_UP}, 1.0)["strain"]
    assert strain[300] == pytest.approx((0.3 - 0.1) / 1.1)


def test_set_grows_with_a_power_beyond_the_limit() -> None:
    effect = PermanentSetYield(fraction=0.5, limit=0.1, power=2, span=0.4)
    added = effect.added({"strain": UP_DOWN_UP}, 1.0)
    np.testing.assert_allclose(added[[50, 100, 200, 300, 600]], np.array([0, 0, 0.0125, 0.05, 0.05]), atol=1e-9)


def test_flow_in_a_hold_approaches_the_raised_yield_point_exponentially() -> None:
    effect = PermanentSetViscoplastic(rate_per_s=0.05, limit=0.15, hardening=1.5, power=1, span=0.3)
    added = effect.added({"strain": HELD}, 0.05)
    time_s = 0.05 * np.arange(len(HELD))
    np.testing.assert_allclose(added, 0.1 / 2.5 * -np.expm1(-2.5 * 0.05 * time_s), rtol=1e-9)
    assert np.all(effect.added({"strain": 0.14 * HELD / 0.25}, 0.05) == 0)


@settings(max_examples=25)
@given(st.floats(1e-4, 5.0), st.floats(1.0, 5.0), st.floats(1.0, 30.0))
def test_flow_never_overshoots_the_overload_and_its_halves_add_up(
    rate: float, power: float, hardening: float
) -> None:
    over = np.full(101, 0.7)
    flowed = overstress_flow(over, rate, hardening, power)
    assert np.all(np.diff(flowed) >= 0)
    assert flowed[-1] <= 0.7 / hardening * (1 + 1e-9)
    half = overstress_flow(np.full(201, 0.7), rate / 2, hardening, power)
    np.testing.assert_allclose(half[::2], flowed, rtol=1e-6, atol=1e-12)


def test_creep_adds_the_same_length_in_every_e_fold_of_time() -> None:
    effect = PermanentSetCreep(amount=0.01, scale_s=1.0, span=0.25)
    added = effect.added({"strain": HELD}, 1.0)
    assert added[999] - added[99] == pytest.approx(0.01 * np.log(10), rel=1e-6)


def test_a_large_stretch_counts_with_its_power_in_creep() -> None:
    strain = np.full(1000, 0.25)
    half, whole = (
        PermanentSetCreep(amount=0.01, scale_s=1e3, power=3, span=0.25).added({"strain": share * strain}, 1.0)[-1]
        for share in (0.5, 1.0)
    )
    assert np.expm1(half / 0.01) == pytest.approx(np.expm1(whole / 0.01) / 8, rel=1e-6)


def test_recovering_set_of_a_hold_grows_exponentially() -> None:
    t = np.arange(0, 1000, 0.5)
    added = PermanentSetRecovering(fraction=0.1, tau_s=100).added({"strain": np.where(t > 0, 0.2, 0.0)}, 0.5)
    np.testing.assert_allclose(added[1:], 0.02 * -np.expm1(-(t[1:] - 0.25) / 100), atol=1e-6)


def test_ratchet_saturates_over_the_path() -> None:
    added = PermanentSetWorked(amount=0.02, scale=0.45).added({"strain": UP_DOWN_UP}, 1.0)
    assert added[-1] == pytest.approx(0.02 * (1 - np.exp(-2)), rel=0.02)


def test_a_set_worked_in_over_no_path_is_a_power_of_the_largest_stretch() -> None:
    strain = np.concatenate([np.linspace(0, top, 500) for top in (0.1, 0.2)])
    added = PermanentSetWorked(amount=0.02, scale=0.01, power=2.0, span=0.2).added({"strain": strain}, 1.0)
    assert added[-1] == pytest.approx(0.02, rel=0.1)
    assert added[499] == pytest.approx(0.02 / 4, rel=0.2)


def test_a_set_that_is_worked_in_follows_a_new_largest_stretch_along_the_path() -> None:
    out, back = np.linspace(0, 0.2, 500), np.linspace(0.2, 0, 500)
    strain = np.concatenate([out, *[back, out] * 3])
    added = PermanentSetWorked(amount=0.02, scale=0.4, power=1.0, span=0.2).added({"strain": strain}, 1.0)
    tops = added[[499, 1499, 2499, 3499]]  # 0.4 of path apart, less what does not count at two turns
    np.testing.assert_allclose(np.diff(0.02 - tops) / (tops[:-1] - 0.02), 1 - np.exp(-0.392 / 0.4), rtol=1e-2)
