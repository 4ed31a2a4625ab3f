"""Heat of the current and of the room against closed-form answers."""

from __future__ import annotations

import numpy as np
import pytest

from testbench.knit.conduction.heat import (
    WANDER_STEPS,
    SelfHeating,
    SelfHeatingCurrent,
    SelfHeatingTwoMasses,
    TemperatureDrift,
    TemperatureDriftWander,
    ThermalSoftening,
    ThermalSofteningWander,
)
from tests.testbench.knit.samples import DT_S, ONE, T, log_change


@pytest.mark.parametrize("cls", [SelfHeating, SelfHeatingCurrent])
def test_self_heating_starts_cold_and_ends_at_its_coefficient(
    cls: type[SelfHeating] | type[SelfHeatingCurrent],
) -> None:
    change = log_change(cls(coefficient=-0.1, tau_s=8.0))
    np.testing.assert_allclose(change, 0.1 * np.expm1(-T / 8.0), atol=1e-12)


def test_two_masses_warm_each_in_its_own_time() -> None:
    change = log_change(SelfHeatingTwoMasses(coefficient=-0.1, fast_s=4.0, slow_s=50.0, share=0.25))
    expected = 0.1 * (0.25 * np.expm1(-T / 4.0) + 0.75 * np.expm1(-T / 50.0))
    np.testing.assert_allclose(change, expected, atol=1e-12)


def test_laws_of_the_room_are_of_one_mechanism_whatever_part_they_share() -> None:
    laws = (TemperatureDrift, TemperatureDriftWander, ThermalSoftening, ThermalSofteningWander)
    assert {law.mechanism for law in laws} == {"temperature_drift"}


def test_measured_temperature_is_used_where_there_is_one() -> None:
    effect = TemperatureDrift(coefficient_per_K=0.02, lag_s=0.1, period_s=400)
    signals = {"time_s": T, "conductance_S": ONE}
    measured = effect.apply({**signals, "temperature_C": 20 + 0.1 * T}, DT_S)["conductance_S"]
    assert np.log(measured[-1]) == pytest.approx(0.02 * 0.1 * (T[-1] - 0.1), rel=1e-6)
    unmeasured = np.log(effect.apply(signals, DT_S)["conductance_S"])
    np.testing.assert_allclose(unmeasured, 0.02 * np.sin(2 * np.pi * T / 400), atol=1e-12)


def test_force_follows_the_measured_temperature() -> None:
    effect = ThermalSoftening(softening_per_K=0.001, lag_s=0.1)
    warm = effect.apply({"time_s": T, "force_N": ONE, "temperature_C": 20 + T}, DT_S)["force_N"]
    np.testing.assert_allclose(warm, 1 - 0.001 * T, atol=2e-4)


def test_a_room_that_was_not_measured_swings_alike_in_both_channels() -> None:
    room = {"period_s": 400.0, "phase_rad": 1.0}
    force_N = ThermalSoftening(softening_per_K=0.01, **room).apply({"time_s": T, "force_N": ONE}, DT_S)["force_N"]
    warmer_K = np.sin(2 * np.pi * T / 400 + 1) - np.sin(1)
    np.testing.assert_allclose(force_N, 1 - 0.01 * warmer_K)
    drift = TemperatureDrift(coefficient_per_K=0.01, **room)
    change = drift.log_change({"time_s": T, "conductance_S": ONE}, DT_S)
    np.testing.assert_allclose(change, 1 - force_N)


def test_a_room_that_nobody_measured_softens_the_force_over_time_alone() -> None:
    effect = ThermalSofteningWander(weights=(0.0,) * 5 + (-0.1,) + (0.0,) * 15)
    time_s = np.arange(0, 1400, DT_S)  # in shorter recordings a room has fewer steps: one a minute
    once, twice = (effect.apply({"time_s": time_s, "force_N": np.full_like(time_s, k)}, DT_S) for k in (1, 2))
    np.testing.assert_allclose(twice["force_N"], 2 * once["force_N"])
    assert once["force_N"][0] == 1
    np.testing.assert_allclose(once["force_N"][len(time_s) // 2 :], np.exp(-0.1))  # a room stays where it went


def test_a_room_does_not_wander_within_a_minute() -> None:
    """However many steps there are: in six minutes there are places for eight."""
    time_s = np.arange(0, 360, DT_S)
    unused = ThermalSofteningWander(weights=(0.0,) * 8 + (-0.1,) * 13)
    np.testing.assert_array_equal(
        unused.apply({"time_s": time_s, "force_N": 1 + time_s}, DT_S)["force_N"], 1 + time_s
    )


def test_a_room_that_wanders_begins_where_it_is():
    time_s = np.arange(0, 600, 0.1)
    signals = {"time_s": time_s, "strain": np.zeros_like(time_s), "conductance_S": np.ones_like(time_s)}
    wander = TemperatureDriftWander(weights=(0.1,) + (0.0,) * (WANDER_STEPS - 1))
    assert np.log(wander.apply(signals, 0.1)["conductance_S"])[0] == pytest.approx(0.0, abs=1e-12)
