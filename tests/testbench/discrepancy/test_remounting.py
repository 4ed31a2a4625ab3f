"""What belongs to one recording is free in each, also where a model that has it is looked at again."""

from __future__ import annotations

import numpy as np

from testbench.discrepancy.evidence import structure_left
from testbench.discrepancy.fit import fit
from testbench.discrepancy.measurement import prepare
from testbench.discrepancy.remounting import held_errors, remounted
from testbench.discrepancy.traces import collect
from testbench.discrepancy.verdict import STRUCTURE_LEFT
from testbench.knit.catalogue import Catalogue
from testbench.knit.interference import PeriodicInterference
from tests.testbench.discrepancy.samples import NOISE_LN, record, truth


def hummed(phase_rad: float, seed: int):
    hum = PeriodicInterference(amplitude=0.05, frequency_Hz=0.7, phase_rad=phase_rad)
    return prepare(record(truth().plus(hum), 120, seed=seed))


def test_a_hum_of_another_phase_leaves_nothing_to_be_explained():
    calibration, held = hummed(0.5, 1), hummed(2.5, 2)
    fitted = fit(truth().plus(PeriodicInterference(amplitude=0.04, frequency_Hz=0.7, phase_rad=0.4)), [calibration])
    assert held_errors(fitted.model, held)["conductance"] < 1.2 * NOISE_LN
    assert abs(remounted(fitted.model, held)["periodic_interference"].phase_rad - 2.5) < 0.1
    plain = collect(fitted, fitted.model, calibration, held, Catalogue({}))["plain"]
    assert plain.second.total[0, 0] < 1.5 * plain.first.total[0, 0]
    assert structure_left(fitted, calibration, held) < 0.02


def test_structure_that_a_model_leaves_is_seen():
    shifted = truth().with_parameters({"contact.series_ohm": 300.0})
    one, other = (prepare(record(shifted, 300, seed=seed)) for seed in (1, 2))
    wrong = fit(truth(), [one], only=["drift"])
    assert structure_left(wrong, one, other) > 3 * STRUCTURE_LEFT
    assert np.isclose(structure_left(fit(shifted, [one]), one, other), 0.0, atol=0.02)
