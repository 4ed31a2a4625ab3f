"""Base laws of the wrong kind are exchanged before a law is sought, unless the user gave them."""

from __future__ import annotations

from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from testbench.diagnosis.searching.search import Search
from testbench.fitting.baseline import SHAPES
from testbench.knit.mechanics.elasticity import ElasticityTwoSlopes
from testbench.measurements.splitting import split
from testbench.proposing import proposal, propose_law
from testbench.proposing.hunt import Hunt
from testbench.recordings.recording import Recording
from tests.testbench.builders import CATALOGUE, record, truth
from tests.testbench.proposing.test_propose import Network

KNEE = 0.163
TWO_SLOPES = ElasticityTwoSlopes(stiffness_N=6.0, more_N=24.0, knee=KNEE, width=0.01)


@cache
def recordings() -> tuple[Recording, Recording]:
    """A knit with a knee in its elasticity, and a network that no catalogue has."""
    model = truth().plus(TWO_SLOPES).plus(Network())
    first, second = (record(model, 120.0, seed=seed) for seed in (1, 2))
    return first, second


@cache
def search() -> Search:
    """With the base that every recording begins with."""
    return Search(split(*recordings())[0], CATALOGUE, lambda text: None)


def test_a_knee_that_the_base_has_not_is_put_in_before_a_law_is_sought():
    hunt = Hunt(search(), "my_effect")
    assert search().flexible.model["elasticity"].name == "elasticity"
    assert hunt.base.model["elasticity"].name == "elasticity_two_slopes"
    assert hunt.base.log_z > search().flexible.log_z + 10
    assert hunt.stiff["elasticity"].knee == pytest.approx(KNEE, abs=0.01)
    assert not any(name in SHAPES for name in hunt.stiff)  # a base that shall not begin bent begins there


def test_laws_that_the_user_gave_are_kept():
    hunt = Hunt(search(), "my_effect", given=True)
    assert hunt.base is search().flexible
    assert hunt.stiff is search().start


@pytest.mark.slow
def test_the_law_is_found_beside_the_knee_and_the_ladder_says_what_was_exchanged():
    proposed = propose_law(*recordings(), name="my_effect", catalogue=CATALOGUE, most=1)
    steps = [step["step"] for step in proposed.after.history]
    assert steps == ["baseline", "+ shape freedom", "+ other base laws", "+ my_effect"]
    errors = [step["errors"]["held_out"] for step in proposed.after.history]
    assert errors[2]["force"] < errors[1]["force"]
    assert proposed.error_before in errors[1:3]  # the better of the two bases is the yardstick
    for channel, floor in proposed.noise_floor.items():
        assert np.round(proposed.error_after[channel] / floor, 2) < 1.2


def test_a_refit_that_foretells_less_than_the_given_model_is_no_yardstick(monkeypatch):
    held_out = {"baseline": 1.0, "+ shape freedom": 2.0, "+ other base laws": 1.5}

    def on_the_ladder(fit, before, name, calibration, held):
        steps = before.history if before else ()
        return SimpleNamespace(history=(*steps, {"errors": {"held_out": {"force": held_out[name]}}}))

    monkeypatch.setattr(proposal, "on_the_ladder", on_the_ladder)
    monkeypatch.setattr(proposal, "Fit", SimpleNamespace(of=lambda h: h))
    monkeypatch.setattr(proposal, "noise_floors", lambda held: {"force": 0.1})
    monkeypatch.setattr(proposal, "not_judged", lambda calibration: [])
    search = SimpleNamespace(baseline="given", flexible="bent")
    hunt = SimpleNamespace(search=search, base="other", name="mine", said_nothing_left=False, grid=None)
    told = proposal._judged(hunt, [], None, None, None)
    assert told.error_before == told.error_after == {"force": 1.0}
