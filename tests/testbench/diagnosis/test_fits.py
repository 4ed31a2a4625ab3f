"""Models of one measurement, as they are fitted last."""

from __future__ import annotations

import pytest

from testbench.diagnosis.fits import Fits
from testbench.knit.readout.interference import PeriodicInterference
from testbench.measurements.measurement import prepare
from tests.testbench.builders import CATALOGUE, record, truth


@pytest.mark.parametrize("hidden_Hz", [5.0, 7.5])
def test_a_hum_has_the_frequency_of_the_whole_recording_not_the_one_that_the_grid_shows(hidden_Hz):
    """On the grid of the comparison, 12.5 Hz, both are one of 5 Hz."""
    hum = PeriodicInterference(amplitude=0.05, frequency_Hz=hidden_Hz)
    fits = Fits(prepare(record(truth().plus(hum), 60, 25.0, 1)), CATALOGUE, lambda _text: None)
    assert 1 / fits.measurement.dt_s == pytest.approx(12.5)
    seen = fits.compare(fits.start.plus(hum.replaced(frequency_Hz=5.0)))
    (last,) = fits.sharp([seen])
    assert last.model[hum.name].frequency_Hz == pytest.approx(hidden_Hz, abs=0.01)
