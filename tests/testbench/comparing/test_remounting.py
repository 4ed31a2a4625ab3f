"""What belongs to one recording is free in each, also where a model that has it is looked at again."""

from __future__ import annotations

from testbench.comparing.remounting import held_errors, remounted
from testbench.fitting.fit import fit
from testbench.knit.readout.interference import PeriodicInterference
from testbench.measurements.measurement import prepare
from tests.testbench.builders import NOISE_LN, record, truth


def hummed(phase_rad: float, seed: int):
    hum = PeriodicInterference(amplitude=0.05, frequency_Hz=0.7, phase_rad=phase_rad)
    return prepare(record(truth().plus(hum), 120, seed=seed))


def test_a_hum_of_another_phase_leaves_nothing_to_be_explained():
    calibration, held = hummed(0.5, 1), hummed(2.5, 2)
    fitted = fit(truth().plus(PeriodicInterference(amplitude=0.04, frequency_Hz=0.7, phase_rad=0.4)), [calibration])
    assert held_errors(fitted.model, held)["conductance"] < 1.2 * NOISE_LN
    assert abs(remounted(fitted.model, held)["periodic_interference"].phase_rad - 2.5) < 0.1
