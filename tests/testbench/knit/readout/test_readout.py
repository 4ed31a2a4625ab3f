"""What instruments add to a reading, against closed-form answers."""

from __future__ import annotations

import numpy as np
import pytest

from testbench.knit.readout.adc_saturation import AdcSaturation, AdcSaturationForce, AdcSaturationHigh
from testbench.knit.readout.channel_lag import (
    ChannelLag,
    ChannelLagDelay,
    ChannelLagForce,
    ChannelLagForceDelay,
    ChannelLagForceTwoFilters,
    ChannelLagResistance,
    ChannelLagTwoFilters,
)
from testbench.knit.readout.interference import PeriodicInterference, PeriodicInterferenceWave
from testbench.knit.readout.load_cell import LoadCellCreep, LoadCellCreepTwoTimes, LoadCellZeroDrift
from tests.testbench.knit.samples import DT_S, T


@pytest.mark.parametrize(
    "late",
    [
        ChannelLag(tau_s=1.5),
        ChannelLagDelay(delay_s=1.5),
        ChannelLagForce(tau_s=1.5),
        ChannelLagForceTwoFilters(tau_s=1.5, second=0.6),
        ChannelLagForceDelay(delay_s=1.5),
    ],
    ids=lambda law: law.name,
)
def test_lag_and_delay_shift_a_ramp_by_their_times(late) -> None:
    (signal,) = late.writes
    read = late.apply({signal: T}, DT_S)[signal]
    np.testing.assert_allclose(read[400:], T[400:] - 1.5, atol=1e-5)


@pytest.mark.parametrize(
    "late", [ChannelLagResistance(tau_s=1.5), ChannelLagTwoFilters(tau_s=1.5)], ids=lambda law: law.name
)
def test_a_late_ohmmeter_shifts_a_ramp_of_the_resistance(late) -> None:
    read = late.apply({"conductance_S": 1 / (1 + T)}, DT_S)["conductance_S"]
    np.testing.assert_allclose(1 / read[400:], T[400:] - 0.5, atol=1e-5)


def test_two_equal_filters_answer_a_step_later_and_more_steeply_than_one() -> None:
    step = np.where(T < 1, 0.0, 1.0)
    once = ChannelLagForce(tau_s=1.0).apply({"force_N": step}, DT_S)["force_N"]
    twice = ChannelLagForceTwoFilters(tau_s=1.0, second=1.0).apply({"force_N": step}, DT_S)["force_N"]
    after = T[T >= 1] - 1
    np.testing.assert_allclose(twice[T >= 1], 1 - (1 + 2 * after) * np.exp(-2 * after), atol=0.05)
    assert twice[np.searchsorted(T, 1.2)] < once[np.searchsorted(T, 1.2)]
    assert twice[np.searchsorted(T, 3.0)] > once[np.searchsorted(T, 3.0)]


def test_converters_clip_at_their_ends() -> None:
    values = np.array([1.0, 2.0, 3.0])
    top = AdcSaturation(floor_ohm=0.5).apply({"conductance_S": values}, 1.0)["conductance_S"]
    bottom = AdcSaturationHigh(floor_S=2.5).apply({"conductance_S": values}, 1.0)["conductance_S"]
    force = AdcSaturationForce(inverse_range_per_N=0.5).apply({"force_N": values}, 1.0)["force_N"]
    np.testing.assert_allclose([top, bottom, force], [[1, 2, 2], [2.5, 2.5, 3], [1, 2, 2]])


def test_clipping_starts_a_fit_near_the_ends_of_noisy_data() -> None:
    n = np.arange(101)
    noise = np.where((n > 20) & (n < 80), 0.1 * (-1.0) ** n, 0.0)
    measured = {"conductance_S": np.linspace(1, 2, 101) + noise, "force_N": np.linspace(0, 4, 101) + 4 * noise}
    tops_S = [1 / point["floor_ohm"] for point in AdcSaturation().starts(measured, {})]
    bottoms_S = [point["floor_S"] for point in AdcSaturationHigh().starts(measured, {})]
    tops_N = [1 / point["inverse_range_per_N"] for point in AdcSaturationForce().starts(measured, {})]
    assert tops_S[1:] == pytest.approx([1.97, 1.99], rel=1e-3)
    assert bottoms_S[1:] == pytest.approx([1.03, 1.01], rel=1e-3)
    assert tops_N[1:] == pytest.approx([3.88, 3.96], rel=1e-3)


def test_clipping_starts_a_fit_where_the_readings_pile_up() -> None:
    measured = {"force_N": np.minimum(np.linspace(0, 4, 101), 3.3)}
    assert 1 / AdcSaturationForce().starts(measured, {})[0]["inverse_range_per_N"] == pytest.approx(3.3)


def test_a_level_that_readings_go_beyond_is_no_rail():
    """A knit pulled to 2 N again and again, and once to 3 N: what piles up at 2 N was not cut off there."""
    triangles = 2.0 * np.abs((T % 20.0) / 10.0 - 1.0)
    held = np.minimum(triangles, 1.8)
    beyond = np.where(0.95 * T[-1] < T, 1.5 * triangles, held)
    rails, none = ([p["inverse_range_per_N"] for p in _starts(AdcSaturationForce, x)] for x in (held, beyond))
    assert rails == pytest.approx([1 / 1.8] * len(rails))
    assert none == [0.0]


def _starts(law, values: np.ndarray) -> list[dict]:
    return law().starts({law.writes[0]: values}, {})


@pytest.mark.parametrize("law", [AdcSaturation, AdcSaturationHigh, AdcSaturationForce])
@pytest.mark.parametrize("unit", [1e-9, 1e-3, 1.0, 1e3])
def test_data_without_a_rail_have_none_in_any_unit(law, unit):
    """A coarse grid of usual sizes would cut off all of some sensors and nothing of others."""
    triangles = 1.0 + np.abs((T % 20.0) / 10.0 - 1.0)
    free = triangles * (1 + 0.5 * (0.95 * T[-1] < T) - 0.5 * (0.05 * T[-1] > T))  # once beyond, at either end
    assert _starts(law, unit * free) == [{law.strength: 0.0}]
    cut_off = _starts(law, unit * np.clip(triangles, 1.2, 1.8))
    assert all(point[law.strength] > 0 for point in cut_off)


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


def test_a_hum_looks_on_a_coarse_grid_as_one_of_those_that_it_is_unfolded_to() -> None:
    hidden = PeriodicInterference(amplitude=0.1, frequency_Hz=7.5, phase_rad=0.3)
    others = hidden.replaced(frequency_Hz=1 / (2 * DT_S) - 7.5).unfolded(1 / (2 * DT_S), 1 / (2 * DT_S))
    assert {round(one.frequency_Hz, 9) for one in others} == {7.5}

    def read(effect, time_s):
        return effect.apply({"time_s": time_s, "conductance_S": np.ones_like(time_s)}, DT_S)["conductance_S"]

    best = min(others, key=lambda one: np.std(read(one, T) - read(hidden, T)))
    assert np.std(read(best, T) - read(hidden, T)) < 0.4 * np.std(read(hidden, T))
    assert np.std(read(best, T[::2]) - read(hidden, T[::2])) < 0.4 * np.std(read(hidden, T[::2]))
