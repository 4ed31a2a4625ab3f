"""Contacts that feel the strain are told from contacts that feel the force."""

from __future__ import annotations

import pytest

import gcode
import testbench as tb
from testbench.fitting.baseline import starting_baseline
from testbench.fitting.fit import fit
from testbench.measurements.preparing import prepare
from tests.testbench.builders import CATALOGUE, record, truth


def sensor(strain_share):
    """Wide loops of force, and contacts that feel more or less of them."""
    drive = CATALOGUE["contact_drive"](strain_share=strain_share, low_N=0.0, span_N=2.7, span=0.3)
    return truth().with_parameters({"hysteresis.friction_N": 0.6}).plus(drive)


@pytest.mark.parametrize(("strain_share", "low", "high"), [(0.0, 0.0, 0.1), (1.0, 0.9, 1.0)])
def test_a_fit_finds_what_the_contacts_feel(strain_share, low, high):
    measurement = prepare(record(sensor(strain_share)))
    found = fit(starting_baseline(measurement), measurement).model["contact_drive"]
    assert low <= found.strain_share <= high


@pytest.mark.parametrize("seed", [3, 7])
def test_the_exponent_of_the_contacts_is_known_as_well_as_is_said(seed):
    """With a resistance in series walked down to nothing no fit came back: the exponent was 30 errors off."""
    program = gcode.generate("paper-1", seed=3, duration_s=120)
    measurement = prepare(tb.simulate(tb.baseline(), program, seed=seed))
    found = fit(starting_baseline(measurement), measurement)
    told = found.summary()["parameters"]["contact.exponent"]
    assert abs(told["value"] - 0.5) < 4 * told["standard_error"]


@pytest.mark.parametrize("channel", ["force_N", "resistance_ohm"])
def test_one_channel_alone_cannot_tell(channel):
    laws = starting_baseline(prepare(record(truth(), channels=(channel,))))
    assert "contact_drive" not in laws
    assert "contact_hysteresis" not in laws
