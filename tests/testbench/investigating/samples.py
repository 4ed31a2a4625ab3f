"""A short investigation whose diagnosis is a table: the loop is tested, not what it believes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from testbench.fitting import constants
from testbench.investigating import loop
from testbench.investigating.benches import SimulatedBench
from testbench.investigating.state import BeliefState, Investigation, LikelyState, Settings
from tests.testbench.builders import CATALOGUE, NOISE_LN, NOISE_N, truth

SET, SLIP = "permanent_set", "clamp_slip"


def hidden():
    """The sensor in the rig."""
    return truth().plus(CATALOGUE[SET]())


def asked(**changes) -> Settings:
    """Two-minute runs, six minutes in all."""
    return Settings(**{"bounds": {"duration_s": 120}, "budget_s": 360, "trials": 2, "rest_s": 5, **changes})


class Believing:
    """Takes the place of the diagnosis: the chance of a permanent set after each run, in turn."""

    def __init__(self, *chances: float) -> None:
        self.chances, self.asked = list(chances), []

    def __call__(self, measurement, runs, catalogue, start=None, most=1, tell=None) -> BeliefState:
        chance = self.chances[len(self.asked)]
        self.asked.append((runs, measurement))
        models = (hidden(), truth().plus(CATALOGUE["clamp_slip_sliding"]()))
        shares = {SET: chance, SLIP: 0.9 * (1 - chance), "unknown": 0.1 * (1 - chance)}
        likely = [
            LikelyState(name=name, chance=shares[name], model=model.to_dict(), scales={})
            for name, model in zip((SET, SLIP), models, strict=True)
        ]
        noise = {"force": NOISE_N, "conductance": NOISE_LN}
        return BeliefState(probabilities=shares, own=shares, verdict="missing", noise=noise, pieces=30, likely=likely)


def scripted_belief(monkeypatch, *chances: float) -> Believing:
    """Puts a table of beliefs in the place of the diagnosis; they are told as they are, with no doubt in evidence."""
    believing = Believing(*chances)
    monkeypatch.setattr(loop, "belief_after", believing)
    monkeypatch.setattr(constants, "MISLED", 0.0)
    return believing


def investigated(
    folder: Path, monkeypatch, chances: Sequence[float], bench=None, resume: bool = False, **changes
) -> tuple[Investigation, Believing]:
    """An investigation from start to end, or from where one is."""
    believing = scripted_belief(monkeypatch, *chances)
    if not resume:
        loop.begin(folder, asked(**changes), "sample")
    return loop.proceed(folder, bench or SimulatedBench(hidden()), CATALOGUE), believing
