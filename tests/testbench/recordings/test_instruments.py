"""Instruments against what can be worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.random import default_rng
from pydantic import ValidationError

from gcode.support.errors import first_problem
from testbench.recordings.instruments import Divider, Encoder, LoadCell, SampleClock, Truth

TIME = np.arange(0, 60, 0.005)
EVEN = np.arange(0.1, 59.9, 1 / 41.5)


def constant(force_N: float = 1.0, resistance_ohm: float = 4e5) -> Truth:
    return Truth(TIME, 0 * TIME, force_N + 0 * TIME, 1 / resistance_ohm + 0 * TIME)


def test_the_clock_has_the_measured_mean_and_spread_of_rates():
    times_s = SampleClock().times(1380.0, default_rng(5))
    rates_hz = 1 / np.diff(times_s)
    assert np.mean(rates_hz) == pytest.approx(41.5, abs=0.4)
    assert np.std(rates_hz) == pytest.approx(14.2, abs=0.4)
    assert (np.diff(times_s) > 0).all()
    assert 1379.5 < times_s[-1] <= 1380.0


@pytest.mark.parametrize("rate_hz", [1.0, 5.0, 1000.0])
def test_a_clock_of_another_rate_has_the_spread_as_the_same_share(rate_hz):
    """14.2 Hz of 5 left 0.6 samples a second."""
    assert SampleClock(rate_hz=rate_hz).rate_sd_hz / rate_hz == pytest.approx(14.2 / 41.5, rel=1e-12)
    times_s = SampleClock(rate_hz=rate_hz).times(4000 / rate_hz, default_rng(1))
    assert (len(times_s) - 1) / times_s[-1] == pytest.approx(rate_hz / (1 + (14.2 / 41.5) ** 2), rel=0.03)


def test_the_spread_is_bit_for_bit_what_it_was_where_it_was_measured_or_given():
    assert SampleClock() == SampleClock(rate_hz=41.5) == SampleClock(rate_sd_hz=14.2)
    assert SampleClock().model_dump() == {"rate_hz": 41.5, "rate_sd_hz": 14.2}
    assert SampleClock(rate_hz=5, rate_sd_hz=14.2).rate_sd_hz == 14.2


def test_a_rate_that_is_none_is_refused_by_its_own_name():
    with pytest.raises(ValidationError) as refused:
        SampleClock(rate_hz="fast")
    assert first_problem(refused.value).startswith("rate_hz: Input should be a valid number")


def test_a_clock_without_jitter_ticks_evenly():
    times_s = SampleClock(rate_hz=50, rate_sd_hz=0).times(10.0, default_rng(1))
    assert np.allclose(np.diff(times_s), 0.02)
    assert len(times_s) == 501


def test_load_cell_noise_is_that_of_the_data_sheet():
    cell = LoadCell()
    read = cell.read(constant(2.5), EVEN, default_rng(1))
    # 2 mV/V at 5 V and 98.07 N: 0.102 mV/N; 35 nV * sqrt(8) / 0.102 mV/N = 0.97 mN.
    assert read.mean() == pytest.approx(2.5, abs=2e-4)
    assert read.std() == pytest.approx(0.97e-3, rel=0.1)


def test_load_cell_sticks_at_the_rail():
    read = LoadCell(noise_V=0).read(constant(500.0), EVEN, default_rng(1))
    # 0.5 * 5 V / 128 = 19.53 mV over 0.102 mV/N.
    assert read == pytest.approx(191.5, abs=0.1)


@pytest.mark.parametrize("ohm", [2e4, 6.06e5, 5e6])
def test_divider_reads_resistance_within_its_steps(ohm):
    divider = Divider(noise_V=0)
    read = divider.read(constant(resistance_ohm=ohm), EVEN, default_rng(1))
    # dR = dV (R_ref + R)^2 / (V_supply R_ref), half a step of 125 uV either way.
    step_ohm = 125e-6 * (606e3 + ohm) ** 2 / (3.3 * 606e3)
    assert np.abs(read - ohm).max() <= 0.5 * step_ohm * 1.001


@pytest.mark.parametrize(("ohm", "low", "high"), [(1e-3, 0, 20), (1e13, 1e9, 1e12)])
def test_divider_at_its_rails_stays_positive_and_finite(ohm, low, high):
    read = Divider(noise_V=0).read(constant(resistance_ohm=ohm), EVEN, default_rng(1))
    assert (read > low).all()
    assert (read < high).all()


def test_divider_averages_the_last_25_ms():
    ramp = Truth(TIME, 0 * TIME, None, 1e-6 * (1 + TIME / 60))
    read = Divider(noise_V=0).read(ramp, EVEN, default_rng(1))
    lag_s = EVEN - np.interp(1 / read, ramp.conductance_S, TIME)
    # The mean age of the conversions in a 25 ms window at 128 SPS: between 10 and 17 ms.
    assert 0.009 < lag_s.mean() < 0.018


def test_encoder_counts():
    read = Encoder(count_mm=0.01).read(Truth(TIME, TIME / 60, None, None), EVEN)
    assert np.allclose(read / 0.01, np.rint(read / 0.01))
    assert np.abs(read - EVEN / 60).max() <= 0.005 + 1e-12


@pytest.mark.parametrize("ohm", [0.5, 1e13])
def test_a_divider_is_one_that_can_be_soldered(ohm):
    with pytest.raises(ValidationError, match="reference_ohm"):
        Divider(reference_ohm=ohm)
