"""Evidence of several specimens, and one real diagnosis in the loop."""

from __future__ import annotations

import pytest

import testbench as tb
from testbench.diagnosis import constants
from testbench.investigating.belief import before_any, with_one_more

NAMES = ("nothing", "unknown", "clamp_slip", "permanent_set")
SLIPS = {"nothing": 1e-6, "unknown": 1e-6, "clamp_slip": 1 - 3e-6, "permanent_set": 1e-6}


def test_the_prior_is_that_of_the_diagnosis():
    prior = before_any(NAMES)
    assert prior["clamp_slip"] == prior["permanent_set"]
    assert prior["nothing"] == pytest.approx(constants.PRIOR_NOTHING * (1 - constants.PRIOR_UNKNOWN))
    assert sum(prior.values()) == pytest.approx(1)


def test_a_recording_that_says_nothing_new_changes_nothing():
    prior = before_any(NAMES)
    assert with_one_more(prior, prior, prior) == pytest.approx(prior)
    told = with_one_more(prior, SLIPS, prior)
    assert with_one_more(told, SLIPS, SLIPS) == pytest.approx(told)


def test_one_motion_makes_nothing_sure_and_two_that_agree_do():
    prior = before_any(NAMES)
    once = with_one_more(prior, SLIPS, prior)
    assert once["clamp_slip"] == pytest.approx(1 - constants.MISLED * (1 - prior["clamp_slip"]), abs=1e-4)
    twice = with_one_more(once, SLIPS, prior)  # a fresh specimen
    assert twice["clamp_slip"] > 0.95
    surer = {name: chance**2 for name, chance in SLIPS.items()}  # one specimen, whose second run said the same
    assert with_one_more(once, surer, SLIPS)["clamp_slip"] == pytest.approx(twice["clamp_slip"], abs=1e-4)
    assert sum(twice.values()) == pytest.approx(1)


def test_a_motion_that_misled_is_made_good_by_others():
    prior = before_any(NAMES)
    sets = {**SLIPS, "clamp_slip": 1e-6, "permanent_set": 1 - 3e-6}
    told = with_one_more(prior, sets, prior)
    for _ in range(3):
        told = with_one_more(told, SLIPS, prior)
    assert told["clamp_slip"] > 0.95


@pytest.mark.slow
def test_a_relaxing_sensor_is_found_and_told(tmp_path):
    sensor = tb.baseline() + tb.effects.StressRelaxation(fraction=0.3)
    found = tb.investigate(sensor, tmp_path / "i", run_minutes=2, budget_minutes=4, trials=2, progress=False)
    assert found.hypothesis == "stress_relaxation"
    assert sum(found.probabilities.values()) == pytest.approx(1)
    assert (tmp_path / "i" / "belief-1.png").is_file()
    likely = found.state.runs[0].belief.likely
    assert len(likely) >= 2
    assert "stress_relaxation" in [one.name for one in likely]
