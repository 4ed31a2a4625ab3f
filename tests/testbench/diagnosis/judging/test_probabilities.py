"""Probabilities as they are told: what errors of evidences do to them."""

from __future__ import annotations

import numpy as np
import pytest

from testbench.diagnosis.judging.probabilities import UNKNOWN, over_errors, prior_of


def each_of_its_own(**chances: float) -> dict[str, dict[str, float]]:
    """Hypotheses each of which has a model of its own."""
    return {name: {name: float(np.log(chance))} for name, chance in chances.items()}


@pytest.mark.parametrize("mechanisms", [[], ["slack"], ["slack", "buckling", "drift"]])
def test_what_is_believed_before_sums_to_one(mechanisms):
    believed = prior_of(mechanisms)
    assert sum(believed.values()) == pytest.approx(1.0)
    assert set(believed) == {"nothing", "unknown", *mechanisms}


def test_a_few_nats_are_nearly_a_tie_and_thirty_are_none():
    """The difference of two evidences has an error of 2 sqrt(2) nats: the mean of a logistic normal is 0.81."""
    near = over_errors(each_of_its_own(a=0.95, b=0.05))
    assert near["a"] == pytest.approx(0.81, abs=0.02)
    assert over_errors(each_of_its_own(a=1 - 1e-13, b=1e-13))["a"] == pytest.approx(1.0, abs=1e-6)
    assert over_errors(each_of_its_own(a=0.5, b=0.5))["a"] == pytest.approx(0.5, abs=0.02)


def test_the_error_of_one_evidence_is_that_of_all_hypotheses_that_it_speaks_for():
    shared = {"stress_relaxation": {"stress_relaxation": np.log(0.95)}, UNKNOWN: {"stress_relaxation": np.log(0.05)}}
    assert over_errors(shared)[UNKNOWN] == pytest.approx(0.05)


def test_the_errors_of_the_evidences_do_not_depend_on_the_order():
    evidences = each_of_its_own(a=0.7, b=0.2, c=0.1)
    turned = over_errors(dict(reversed(evidences.items())))
    assert over_errors(evidences) == pytest.approx(turned)
    assert sum(turned.values()) == pytest.approx(1.0)
