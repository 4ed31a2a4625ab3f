"""Overshoot, heat and read-out against closed-form answers."""

from __future__ import annotations

import numpy as np
import pytest

from testbench.knit.conduction.heat import (
    SelfHeating,
    SelfHeatingCurrent,
    SelfHeatingTwoMasses,
    TemperatureDrift,
    ThermalSoftening,
    ThermalSofteningWander,
)
from testbench.knit.conduction.transient import (
    ElectricalOvershoot,
    ElectricalOvershootMagnitude,
    RateResistance,
    ShoulderPeak,
    on_the_way_back,
)
from testbench.knit.conduction.turning import ElectricalOvershootAnew, ElectricalOvershootReversal
from testbench.knit.readout.adc_saturation import AdcSaturation, AdcSaturationForce, AdcSaturationHigh
from testbench.knit.readout.channel_lag import ChannelLag, ChannelLagDelay
from testbench.knit.readout.interference import PeriodicInterference, PeriodicInterferenceWave
from testbench.knit.readout.load_cell import LoadCellCreep, LoadCellCreepTwoTimes, LoadCellZeroDrift

DT_S = 0.05
T = np.arange(0, 100, DT_S)
ONE = np.ones_like(T)
UP_HOLD_DOWN = 0.2 * np.interp(T, [0, 10, 40, 50], [0, 1, 1, 0])


def log_change(effect: object, strain: np.ndarray = UP_HOLD_DOWN) -> np.ndarray:
    signals = {"strain": strain, "conductance_S": ONE, "time_s": T}
    return np.log(effect.apply(signals, DT_S)["conductance_S"])  # type: ignore[attr-defined]


@pytest.mark.parametrize(("tau_s", "rise_s"), [(4.0, 0.5), (0.5, 4.0), (2.0, 2.0), (2.0, 2.0 + 1e-9)])
def test_a_transient_starts_anew_at_each_turn(tau_s: float, rise_s: float) -> None:
    triangle = 0.2 * np.interp(T, [0, 10, 20, 30, 100], [0, 1, 0, 1, 2])
    change = log_change(ElectricalOvershootAnew(gain=0.1, tau_s=tau_s, rise_s=rise_s, back=0.01), triangle)
    for turned_s, at_s, heading in ((10.0, 13.0, -1), (20.0, 26.0, 1)):
        since_s = at_s - turned_s
        if abs(tau_s - rise_s) > 1e-6:
            spike = tau_s / (tau_s - rise_s) * (np.exp(-since_s / tau_s) - np.exp(-since_s / rise_s))
        else:
            spike = since_s / tau_s * np.exp(-since_s / tau_s)
        assert change[np.searchsorted(T, at_s)] == pytest.approx(0.1 * heading * spike, rel=1e-6)


def test_overshoot_after_a_ramp_decays_with_its_time_constant() -> None:
    change = log_change(ElectricalOvershoot(gain=2.0, tau_s=4.0))
    peak = 2.0 * 0.02 * 4.0 * -np.expm1(-10 / 4.0)  # gain * rate * tau * (1 - e^-T/tau)
    at = np.searchsorted(T, [10.0, 14.0])
    np.testing.assert_allclose(change[at], [peak, peak / np.e], rtol=1e-6)


def test_overshoot_of_the_magnitude_has_the_same_sign_both_ways() -> None:
    change = log_change(ElectricalOvershootMagnitude(gain=1.0, tau_s=2.0))
    up, down = change[np.searchsorted(T, [10.0, 50.0])]
    assert up == pytest.approx(down, rel=1e-3)
    assert up == pytest.approx(0.02 * 2.0, rel=0.02)


def test_reversal_transient_does_not_know_the_speed() -> None:
    fast = log_change(ElectricalOvershootReversal(gain=0.1), 0.05 * np.abs((T + 10) % 20 - 10))
    slow = log_change(ElectricalOvershootReversal(gain=0.1), 0.01 * np.abs((T + 10) % 20 - 10))
    np.testing.assert_allclose(np.ptp(fast), np.ptp(slow), rtol=0.1)


def test_shoulder_is_on_the_way_back_only() -> None:
    change = log_change(ShoulderPeak(gain=-1.0, tau_s=5.0))
    assert np.all(np.abs(change[T < 40]) < 1e-12)
    assert change[np.searchsorted(T, 50.0)] == pytest.approx(-0.02 * 5.0 * -np.expm1(-10 / 5.0), rel=1e-3)


def test_a_late_way_back_begins_after_its_share_of_the_turn() -> None:
    back = np.linspace(1.0, 0.0, 2001)
    strain = np.concatenate([np.linspace(0.0, 1.0, 2001), back])
    at_once, late = (on_the_way_back(strain, 0.1, share) for share in (0.0, 0.5))
    turned = 1 - 2 * np.exp((back - 1) / 0.1)  # z of Dahl's law, from -1 (out) to 1 (back)
    np.testing.assert_allclose(at_once[2001:], 0.5 * (1 + turned), atol=1e-3)
    np.testing.assert_allclose(late[2001:], np.maximum(turned, 0.0), atol=1e-3)


def test_rate_shift_is_gone_when_the_motion_stops() -> None:
    change = log_change(RateResistance(gain=0.5))
    assert change[np.searchsorted(T, 9.0)] == pytest.approx(0.5 * 0.02 / 0.1, rel=1e-4)
    assert abs(change[np.searchsorted(T, 12.0)]) < 1e-6


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


def test_measured_temperature_is_used_where_there_is_one() -> None:
    effect = TemperatureDrift(coefficient_per_K=0.02, lag_s=0.1, period_s=400)
    signals = {"time_s": T, "conductance_S": ONE}
    measured = effect.apply({**signals, "temperature_C": 20 + 0.1 * T}, DT_S)["conductance_S"]
    assert np.log(measured[-1]) == pytest.approx(0.02 * 0.1 * (T[-1] - 0.1), rel=1e-6)
    unmeasured = np.log(effect.apply(signals, DT_S)["conductance_S"])
    np.testing.assert_allclose(unmeasured, 0.02 * np.sin(2 * np.pi * T / 400), atol=1e-12)


def test_force_follows_the_temperature_only_where_it_was_measured() -> None:
    effect = ThermalSoftening(softening_per_K=0.01)
    np.testing.assert_array_equal(effect.apply({"force_N": ONE}, DT_S)["force_N"], ONE)
    warm = effect.apply({"force_N": ONE, "temperature_C": 20 + T}, DT_S)["force_N"]
    np.testing.assert_allclose(warm, 1 - 0.01 * T)


def test_a_room_that_nobody_measured_softens_the_force_over_time_alone() -> None:
    effect = ThermalSofteningWander(weights=(0.0,) * 5 + (-0.1,) * 12 + (0.0,) * 5)
    time_s = np.arange(0, 1400, DT_S)  # in shorter recordings a room has fewer bumps: one a minute
    once, twice = (effect.apply({"time_s": time_s, "force_N": np.full_like(time_s, k)}, DT_S) for k in (1, 2))
    np.testing.assert_allclose(twice["force_N"], 2 * once["force_N"])
    assert once["force_N"][0] == 1
    assert once["force_N"][len(time_s) // 2] == pytest.approx(np.exp(-0.1))


def test_a_room_does_not_wander_within_a_minute() -> None:
    """However many bumps there are: in six minutes there are places for nine."""
    time_s = np.arange(0, 360, DT_S)
    unused = ThermalSofteningWander(weights=(0.0,) * 9 + (-0.1,) * 13)
    np.testing.assert_array_equal(
        unused.apply({"time_s": time_s, "force_N": 1 + time_s}, DT_S)["force_N"], 1 + time_s
    )


def test_lag_and_delay_shift_a_ramp_by_their_times() -> None:
    for effect in (ChannelLag(tau_s=1.5), ChannelLagDelay(delay_s=1.5)):
        read = effect.apply({"conductance_S": T}, DT_S)["conductance_S"]
        np.testing.assert_allclose(read[400:], T[400:] - 1.5, atol=1e-5)


def test_converters_clip_at_their_ends() -> None:
    values = np.array([1.0, 2.0, 3.0])
    top = AdcSaturation(floor_ohm=0.5).apply({"conductance_S": values}, 1.0)["conductance_S"]
    bottom = AdcSaturationHigh(floor_S=2.5).apply({"conductance_S": values}, 1.0)["conductance_S"]
    force = AdcSaturationForce(inverse_range_per_N=0.5).apply({"force_N": values}, 1.0)["force_N"]
    np.testing.assert_allclose([top, bottom, force], [[1, 2, 2], [2.5, 2.5, 3], [1, 2, 2]])


def test_clipping_starts_a_fit_near_the_ends_of_the_data() -> None:
    measured = {"conductance_S": np.linspace(1, 2, 101), "force_N": np.linspace(0, 4, 101)}
    tops_S = [1 / point["floor_ohm"] for point in AdcSaturation().starts(measured, {})]
    bottoms_S = [point["floor_S"] for point in AdcSaturationHigh().starts(measured, {})]
    tops_N = [1 / point["inverse_range_per_N"] for point in AdcSaturationForce().starts(measured, {})]
    assert tops_S[1:] == pytest.approx([1.97, 1.99], rel=1e-3)
    assert bottoms_S[1:] == pytest.approx([1.03, 1.01], rel=1e-3)
    assert tops_N[1:] == pytest.approx([3.88, 3.96], rel=1e-3)


def test_clipping_starts_a_fit_where_the_readings_pile_up() -> None:
    measured = {"force_N": np.minimum(np.linspace(0, 4, 101), 3.3)}
    assert 1 / AdcSaturationForce().starts(measured, {})[0]["inverse_range_per_N"] == pytest.approx(3.3)


def test_creeping_reading_ends_at_its_fraction_and_zero_drift_at_its_shift() -> None:
    t = np.arange(0, 1000, 0.5)
    crept = LoadCellCreep(fraction=0.05, tau_s=20).apply({"force_N": np.minimum(t, 2.0)}, 0.5)["force_N"]
    assert crept[-1] == pytest.approx(2.1)
    drifted = LoadCellZeroDrift(drift_N=0.3, tau_s=20).apply({"force_N": np.zeros_like(t), "time_s": t}, 0.5)
    assert drifted["force_N"][-1] == pytest.approx(0.3)


def test_a_reading_that_creeps_twice_is_the_sum_of_its_steps() -> None:
    force_N = np.minimum(np.arange(0, 1000, 0.5), 2.0)
    both = LoadCellCreepTwoTimes(fraction=0.1, fast_s=10, slow_s=200, share=0.3).apply({"force_N": force_N}, 0.5)
    steps = [LoadCellCreep(fraction=0.03, tau_s=10), LoadCellCreep(fraction=0.07, tau_s=200)]
    added = [step.apply({"force_N": force_N}, 0.5)["force_N"] - force_N for step in steps]
    np.testing.assert_allclose(both["force_N"] - force_N, sum(added), atol=1e-12)


def test_a_wave_of_any_form_holds_a_rectangle() -> None:
    """Its Fourier series: sin(pi k duty) cos(k a) over k, symmetric about the middle of the pulse."""
    duty, k = 0.3, np.arange(1, 7)
    series = 0.2 / k * np.sin(np.pi * k * duty)
    # a' = a + pi/2: cos(k a) = cos(k a' - k pi/2) = cos(k pi/2) cos(k a') + sin(k pi/2) sin(k a')
    pairs = np.column_stack([np.sin(k * np.pi / 2), np.cos(k * np.pi / 2)]) * series[:, None] / series[0]
    effect = PeriodicInterferenceWave(
        amplitude=float(series[0]), frequency_Hz=0.5, phase_rad=np.pi / 2, harmonics=tuple(pairs[1:].ravel())
    )
    written = effect.apply({"time_s": T, "conductance_S": np.ones_like(T)}, T[1])["conductance_S"]
    expected = sum(one * np.cos(n * np.pi * T) for n, one in zip(k, series, strict=True))
    np.testing.assert_allclose(np.log(written), expected, atol=1e-12)


def test_the_line_in_the_spectrum_is_found() -> None:
    rng = np.random.default_rng(0)
    signal = np.cumsum(rng.normal(0, 0.02, len(T))) + 0.1 * np.sin(2 * np.pi * 3.3 * T)
    started = PeriodicInterference().started({"time_s": T}, {"conductance": signal})
    assert started.model_dump()["frequency_Hz"] == pytest.approx(3.3, abs=0.02)
