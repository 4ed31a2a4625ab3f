"""Evidence of several specimens, and one real diagnosis in the loop."""

from __future__ import annotations

import pytest

import testbench as tb
from testbench.fitting import constants
from testbench.investigating.belief import doubted, over_specimens


def test_one_specimen_says_what_it_says():
    said = {"nothing": 0.2, "unknown": 0.1, "clamp_slip": 0.7}
    assert over_specimens([said]) == pytest.approx(said)


def test_a_specimen_that_says_nothing_new_changes_nothing():
    u = constants.PRIOR_UNKNOWN
    prior = {
        "nothing": constants.PRIOR_NOTHING,
        "unknown": (1 - constants.PRIOR_NOTHING) * u,
        "clamp_slip": 0.5 * (1 - constants.PRIOR_NOTHING) * (1 - u),
        "permanent_set": 0.5 * (1 - constants.PRIOR_NOTHING) * (1 - u),
    }
    said = {"nothing": 0.1, "unknown": 0.1, "clamp_slip": 0.6, "permanent_set": 0.2}
    assert over_specimens([said, prior]) == pytest.approx(said)


def test_the_odds_of_specimens_multiply():
    said = {"nothing": 0.0, "unknown": 0.0, "clamp_slip": 0.75, "permanent_set": 0.25}
    together = over_specimens([said, said, said])
    assert together["clamp_slip"] / together["permanent_set"] == pytest.approx(27)
    assert sum(together.values()) == pytest.approx(1)


def test_a_mechanism_that_one_specimen_could_not_show_is_as_likely_as_its_others_say():
    """Each says by how much: of what it could not show it says what it says of *nothing*."""
    whole = {"nothing": 0.2, "unknown": 0.1, "clamp_slip": 0.1, "permanent_set": 0.6}
    part = {"nothing": 0.25, "unknown": 0.05, "permanent_set": 0.7}
    together = over_specimens([whole, part])
    odds = together["clamp_slip"] / together["nothing"]
    assert odds == pytest.approx(whole["clamp_slip"] / whole["nothing"])


SLIPS = {"nothing": 0.0, "unknown": 0.0, "clamp_slip": 1.0, "permanent_set": 0.0}
SETS = {**SLIPS, "clamp_slip": 0.0, "permanent_set": 1.0}


def test_one_recording_makes_nothing_sure_and_two_that_agree_do():
    prior = 0.5 * (1 - constants.PRIOR_NOTHING) * (1 - constants.PRIOR_UNKNOWN)
    assert doubted([SLIPS])["clamp_slip"] == pytest.approx(1 - constants.MISLED * (1 - prior))
    assert doubted([SLIPS, SLIPS])["clamp_slip"] > 0.95
    assert sum(doubted([SLIPS, SLIPS]).values()) == pytest.approx(1)


def test_a_leap_is_doubted_like_a_first_answer():
    assert doubted([SETS, SETS, SLIPS]) == pytest.approx(doubted([SLIPS]))
    assert doubted([SETS, SLIPS, SLIPS]) == pytest.approx(doubted([SLIPS, SLIPS]))


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
