"""What belongs to one recording is free in each, also where a model that has it is looked at again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from testbench.comparing.remounting import held_errors, remounted
from testbench.fitting.fit import fit
from testbench.knit.conduction.heat import (
    WANDER_STEPS,
    TemperatureDrift,
    TemperatureDriftTrend,
    TemperatureDriftWander,
    ThermalSoftening,
)
from testbench.knit.readout.interference import PeriodicInterference
from testbench.measurements.preparing import prepare
from tests.testbench.builders import NOISE_LN, record, truth


def hummed(phase_rad: float, seed: int):
    hum = PeriodicInterference(amplitude=0.05, frequency_Hz=0.7, phase_rad=phase_rad)
    return prepare(record(truth().plus(hum), 120, seed=seed))


def test_a_hum_of_another_phase_leaves_nothing_to_be_explained():
    calibration, held = hummed(0.5, 1), hummed(2.5, 2)
    fitted = fit(truth().plus(PeriodicInterference(amplitude=0.04, frequency_Hz=0.7, phase_rad=0.4)), calibration)
    assert held_errors(fitted.model, held)["conductance"] < 1.2 * NOISE_LN
    assert abs(remounted(fitted.model, held)["periodic_interference"].phase_rad - 2.5) < 0.1


def in_a_room(swing_K: float, phase_rad: float, seed: int, coefficient_per_K: float = 0.02):
    """A sensor beside whose recording the temperature was not measured."""
    room = TemperatureDrift(coefficient_per_K=coefficient_per_K * swing_K, period_s=300.0, phase_rad=phase_rad)
    return prepare(record(truth().plus(room), 400, seed=seed))


def test_an_unmeasured_room_swings_as_far_as_it_likes_in_each_recording():
    calibration, held = in_a_room(1.0, 0.5, 1), in_a_room(4.0, 2.5, 2)
    start = truth().plus(TemperatureDrift(coefficient_per_K=0.02, period_s=300.0, phase_rad=0.5))
    fitted = fit(start, calibration)
    assert held_errors(fitted.model, held)["conductance"] < 1.2 * NOISE_LN


def test_how_a_sensor_follows_a_measured_temperature_is_its_own_in_all_recordings():
    warm = {"strain": np.zeros(3), "temperature_C": np.array([20.0, 21.0, 22.0])}
    for effect in (TemperatureDrift(), ThermalSoftening()):
        assert effect.of_one_recording(warm) == ()
        assert effect.strength in effect.of_one_recording({"strain": np.zeros(3)})


def test_a_room_that_warmed_once_need_not_warm_again():
    warming, held = (truth().plus(TemperatureDriftTrend(coefficient_per_h=pace)) for pace in (1.0, -1.5))
    fitted = fit(warming, prepare(record(warming, 300, seed=1)))
    assert held_errors(fitted.model, prepare(record(held, 300, seed=2)))["conductance"] < 1.2 * NOISE_LN


@pytest.mark.parametrize("gain", [-0.5, 0.05, 2.0])
def test_a_room_warms_at_its_own_pace_beside_another_gain(gain: float):
    warming = truth().plus(TemperatureDriftTrend(coefficient_per_h=1.0))
    held = prepare(record(warming, 300, seed=2))
    shifted = replace(held, measured=held.measured | {"conductance": held.measured["conductance"] + gain})
    assert remounted(warming, shifted)["temperature_drift_trend"].coefficient_per_h == pytest.approx(1.0, abs=0.01)


def test_a_recording_that_shows_nothing_of_the_room_leaves_the_model_as_it_is():
    wandering = truth().plus(TemperatureDriftWander(weights=(0.01,) * WANDER_STEPS))
    held = prepare(record(truth(), 60, channels=("force_N",)))
    assert remounted(wandering, held)["elasticity"] == wandering["elasticity"]
