"""The laws of one mechanism take each other's place."""

from __future__ import annotations

from testbench.diagnosis.fits import Fits
from testbench.diagnosis.refits import Refits
from testbench.diagnosis.rounds import Entry
from testbench.knit.catalogue import load_catalogue
from testbench.knit.model import KnitModel
from testbench.measurements.measurement import prepare
from tests.testbench.builders import record, truth

CATALOGUE = load_catalogue()


def swapped(law, sensor, channels):
    """The laws in the place of one that was put into the model of a short recording."""
    fits = Fits(prepare(record(sensor, 60, 10.0, 1, channels)), CATALOGUE, lambda _text: None)
    h = fits.compare(fits.reference.plus(law))
    return {e.law: e for e in Refits(fits).swapped(Entry(law.mechanism, law.name, law.name, h, h.log_z))}


def test_a_law_starts_as_strong_as_the_one_in_whose_place_it_stands():
    slack = CATALOGUE["slack"](slack=0.05)
    found = swapped(slack, truth(), ("force_N",))
    assert set(found) == {"slack_gradual"}
    model = found["slack_gradual"].hypothesis.model
    assert "slack" not in model
    assert "slack_gradual" in model


def test_a_law_of_a_signal_that_no_law_makes_takes_no_place():
    late, no_force = CATALOGUE["channel_lag"](tau_s=0.1), KnitModel.of(CATALOGUE["piezoresistance"]())
    found = swapped(late, no_force, ("resistance_ohm",))
    assert set(found) == {"channel_lag_resistance"}
