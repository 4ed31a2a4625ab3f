"""Contacts that feel the strain are told from contacts that feel the force."""

from __future__ import annotations

import pytest

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


@pytest.mark.parametrize("channel", ["force_N", "resistance_ohm"])
def test_one_channel_alone_cannot_tell(channel):
    laws = starting_baseline(prepare(record(truth(), channels=(channel,))))
    assert "contact_drive" not in laws
    assert "contact_hysteresis" not in laws
