"""Where a refit with a law starts."""

from __future__ import annotations

import numpy as np
import pytest

from testbench.diagnosis.judging.entries import Proposal
from testbench.diagnosis.searching.proposals import laws_of
from testbench.diagnosis.searching.starts import best_start, drawn_anew
from testbench.fitting.baseline import starting_baseline, with_shapes
from testbench.fitting.evidence.laplace import fitted
from testbench.fitting.evidence.sample_noise import likelihood_of, noise_of
from testbench.knit.catalogue import Catalogue
from testbench.knit.kinematics.grip import Slack
from testbench.knit.readout.interference import PeriodicInterferenceForce
from testbench.measurements.preparing import prepare
from tests.testbench.builders import record, truth


def test_a_law_that_holds_where_the_whole_step_does_not_starts_as_strong_as_it_was_proposed():
    hum = PeriodicInterferenceForce(amplitude_N=0.1, frequency_Hz=0.7, phase_rad=0.5)
    measurement = prepare(record(truth().plus(hum), 60, 10.0, 1, ("force_N",)))
    base = truth().without("contact").without("drift")
    likelihood = likelihood_of(base, measurement, noise_of(measurement))
    h = fitted(with_shapes(base, measurement), likelihood, base, iterations=4)
    astray = np.full(len(h.vector), 3.0)  # of the parameters of the base, and of the weights that bend it
    proposed = Proposal("periodic_interference", hum.name, hum, 100.0, astray, None)
    assert best_start(h, proposed, likelihood)[hum.name] == hum


def test_a_base_is_drawn_anew_over_what_slack_leaves_of_the_stretch():
    """Drawn over all of the motion it is far too soft beside the slack of the sensor."""
    measurement = prepare(record(truth().plus(Slack(slack=0.18)), 60, 10.0, 1, ("force_N",)))
    base = starting_baseline(measurement)
    likelihood = likelihood_of(base, measurement, noise_of(measurement))
    h = fitted(base, likelihood, base, iterations=4)
    (law,) = laws_of(h, likelihood, Catalogue({"slack": Slack}))
    model = drawn_anew(h, law, likelihood)
    assert model["slack"].slack == pytest.approx(0.18, abs=0.02)
    left, before = (measurement.residual(one)["force"].std() for one in (model, h.model.plus(model["slack"])))
    assert left < 0.5 * before
