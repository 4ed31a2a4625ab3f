"""Who leads has to have been refitted, and who was not settled does not overtake a winner."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace

import pytest

from testbench.discrepancy import runoff
from testbench.discrepancy.runoff import CLOSE, run_off, unproven
from tests.testbench.discrepancy.samples import weighing


def entrant(score: float, name: str) -> SimpleNamespace:
    return SimpleNamespace(
        score=score, name=name, candidate=weighing(**{name: 1.0}).ranking[0].candidate if name else None
    )


def test_the_unproven_idea_that_comes_close_is_refitted_next():
    ranked = weighing(stress_relaxation=1.0, permanent_set=0.9, clamp_slip=0.5)
    assert unproven(ranked, {"stress_relaxation"}, 0.075).idea == "permanent_set"
    assert unproven(ranked, {"stress_relaxation", "permanent_set"}, 0.075) is None
    assert unproven(ranked, set(), 1.1) is None
    assert unproven(weighing(adc_saturation=1.0), set(), 0.075) is None, "what a shape imitates is judged apart"


def test_what_is_akin_to_the_first_is_refitted_however_it_screened():
    ranked = weighing(permanent_set=1.0, stress_relaxation=0.5, clamp_slip=0.02)
    assert unproven(ranked, {"permanent_set"}, 0.075).idea == "clamp_slip"
    assert unproven(ranked, {"permanent_set", "clamp_slip"}, 0.075) is None
    assert unproven(weighing(permanent_set=0.05, clamp_slip=0.02), set(), 0.075) is None


@pytest.fixture
def contest(monkeypatch):
    """A contest in which every entrant has settled and is in its best form already."""
    monkeypatch.setattr(runoff, "settled", lambda contest, one: one)
    monkeypatch.setattr(runoff, "in_its_best_form", lambda contest, one, pool: one)
    return SimpleNamespace(calibration=SimpleNamespace(signals={}))


def test_who_was_not_settled_does_not_overtake_the_winner(contest):
    ranked = weighing(stress_relaxation=1.0, permanent_set=0.9, viscous_rate_stiffening=0.7)
    entrants = {
        "stress_relaxation": entrant(-0.3, "stress_relaxation_log"),
        "permanent_set": entrant(-0.1, "permanent_set"),
        "viscous_rate_stiffening": entrant(0.0, "viscous_rate_stiffening"),
    }
    after, _ = run_off(contest, ranked, entrants, entrant(0.0, ""), 0.075, ThreadPoolExecutor(1))
    gains = {entry.idea: entry.gain for entry in after.ranking}
    assert (after.ranking[0].idea, after.ranking[0].form) == ("stress_relaxation", "stress_relaxation_log")
    assert gains["viscous_rate_stiffening"] == pytest.approx((1 - CLOSE) * gains["stress_relaxation"])


def test_the_winner_is_counted_in_its_best_form(contest, monkeypatch):
    better = {"stress_relaxation": entrant(-0.5, "stress_relaxation_spectrum")}
    monkeypatch.setattr(runoff, "in_its_best_form", lambda contest, one, pool: better[one.candidate.idea])
    ranked = weighing(stress_relaxation=0.6, permanent_set=0.5)
    entrants = {
        "stress_relaxation": entrant(-0.3, "stress_relaxation"),
        "permanent_set": entrant(-0.2, "permanent_set"),
    }
    after, reached = run_off(contest, ranked, entrants, entrant(0.0, ""), 0.075, ThreadPoolExecutor(1))
    first, second = after.ranking[:2]
    assert (first.idea, first.form) == ("stress_relaxation", "stress_relaxation_spectrum")
    assert reached["stress_relaxation"] is better["stress_relaxation"]
    assert first.gain > 0.9
    assert second.gain < 0.5
