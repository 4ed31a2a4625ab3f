"""A shape that is taken out of a model because it is not used changes nothing by going."""

from __future__ import annotations

import pytest

from testbench.comparing.model_errors import rms_errors
from testbench.diagnosis.searching.candidates import is_vector
from testbench.diagnosis.searching.proposals import Screen, laws_of
from testbench.fitting import constants
from testbench.fitting.baseline import SHAPES, with_shapes
from testbench.fitting.evidence.hypothesis import Hypothesis
from testbench.fitting.evidence.laplace import fitted
from testbench.fitting.evidence.sample_noise import likelihood_of, noise_of
from testbench.knit.catalogue import load_catalogue
from testbench.measurements.coarser import coarser
from testbench.measurements.measurement import Measurement
from testbench.measurements.preparing import prepare
from tests.testbench.builders import CATALOGUE, record, truth

SLOPE_PER_KS = 0.3  # of the drift: 0.09 in ln G over five minutes, thirty times the noise


@pytest.fixture(scope="module")
def bent() -> tuple[Hypothesis, Measurement]:
    """A model with all shapes, of which the sensor needs the slope of the drift alone, fitted to five minutes."""
    model = truth().without("drift").plus(CATALOGUE["drift_shape"](slope_per_ks=SLOPE_PER_KS))
    measurement = coarser(prepare(record(model, 300, 12.5, seed=1)), constants.GRID_HZ)
    start = with_shapes(model, measurement, CATALOGUE)
    likelihood = likelihood_of(start, measurement, noise_of(measurement)).in_pieces
    return fitted(start, likelihood, truth().without("drift"), iterations=2), measurement


def test_what_is_switched_off_changes_nothing(bent):
    h, measurement = bent
    assert set(h.model_in_use) < set(h.model)
    assert rms_errors(h.model_in_use, measurement) == pytest.approx(rms_errors(h.model, measurement), rel=0.01)


def test_a_drift_without_weights_is_in_use_while_it_has_a_slope(bent):
    h, _ = bent
    assert h.model["drift_shape"].slope_per_ks == pytest.approx(SLOPE_PER_KS, rel=0.2)
    assert [name for name in SHAPES if name in h.model_in_use] == ["drift_shape"]


def test_what_is_switched_off_makes_no_law_look_better(bent):
    """A law is worth the same beside a model with idle shapes as beside the same model without them."""
    h, measurement = bent
    likelihood = likelihood_of(h.model, measurement, noise_of(measurement)).in_pieces
    without = fitted(h.model_in_use, likelihood, truth().without("drift"), iterations=0)
    with_idle, bare = (
        {p.law: float(p.gain) for p in Screen(one, likelihood).proposals(laws_of(one, likelihood, load_catalogue()))}
        for one in (h, without)
    )
    scalars = [law for law in bare if not is_vector(CATALOGUE[law], CATALOGUE[law].strength)]
    assert len(scalars) > 60
    assert max(abs(with_idle[law] - bare[law]) for law in scalars) < 1.0


def test_combinations_of_weights_that_the_data_do_not_see_make_no_law_look_better(bent, monkeypatch):
    """Laws are worth the same whether such combinations are left out or not."""
    h, measurement = bent
    likelihood = likelihood_of(h.model, measurement, noise_of(measurement)).in_pieces
    laws = laws_of(h, likelihood, load_catalogue())
    some = Screen(h, likelihood)
    monkeypatch.setattr("testbench.fitting.evidence.directions.UNSEEN", -1.0)
    every = Screen(h, likelihood)
    assert len(some.normal.mean) < 0.7 * len(every.normal.mean) == 0.7 * len(h.priors.parameters)
    gains = [{p.law: float(p.gain) for p in screen.proposals(laws)} for screen in (some, every)]
    assert len(gains[1]) > 60
    assert max(abs(gains[0][law] - gain) for law, gain in gains[1].items()) < 0.5
