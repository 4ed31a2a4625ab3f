"""Models of one measurement, as they are fitted last."""

from __future__ import annotations

import numpy as np
import pytest

from testbench.diagnosis.searching.fits import Fits
from testbench.fitting.evidence.laplace import fitted
from testbench.knit.mechanics.relaxation import StressRelaxation
from testbench.knit.readout.interference import PeriodicInterference
from testbench.measurements.preparing import prepare
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


def test_a_fit_that_was_cut_short_earns_nothing_by_steps_that_it_did_not_take():
    """To first order almost all of a weak law's misfit could go; only what has gone counts."""
    relaxes = StressRelaxation(fraction=0.3, tau_s=10.0)
    fits = Fits(prepare(record(truth().plus(relaxes), 60, 25.0, 1)), CATALOGUE, lambda _text: None)
    weak = fits.start.plus(relaxes.replaced(fraction=0.01))
    cut_short, whole = (fitted(weak, fits.compared, fits.reference, iterations=n) for n in (0, 14))
    of_law = cut_short.priors.group < 0
    np.testing.assert_array_equal(cut_short.evidence.coefficients[of_law], 0.0)
    assert cut_short.log_z < whole.log_z - 50


def test_a_fit_at_rest_stays_as_it_is():
    """What a refit with shapes as free as without data does not improve keeps its own scales."""
    fits = Fits(prepare(record(truth(), 60, 25.0, 1)), CATALOGUE, lambda _text: None)
    rest = fits.at_rest(fits.compare(fits.bent(fits.start)))
    again = fits.at_rest(rest)
    assert again is rest or again.log_z > rest.log_z
