"""An investigation in words: it claims no more motion than was judged."""

from __future__ import annotations

from testbench.investigating.state import BeliefState, Investigation, RunState, Settings
from testbench.investigating.words import ending_words

CHANCES = {"permanent_set": 0.6, "clamp_slip": 0.4}
BELIEF = BeliefState(
    probabilities=CHANCES, own=CHANCES, verdict="missing", noise={"force": 0.01}, pieces=30, likely=[]
)


def investigated(*runs: RunState) -> Investigation:
    return Investigation(settings=Settings(bounds={"duration_s": 120}, budget_s=600), runs=list(runs))


def test_motion_that_was_not_judged_yet_is_not_claimed() -> None:
    judged = RunState(words="random motion", seconds=120.0, recorded=True, belief=BELIEF)
    said = "not ended yet: after 2.0 min of motion permanent set 60 %, clamp slip 40 %"
    recorded = RunState(words="holds", seconds=90.0, recorded=True)
    assert ending_words(investigated(judged, recorded)) == f"{said}; run 2 is not judged yet"
    assert ending_words(investigated(judged, RunState(words="holds", seconds=90.0))) == said
    assert ending_words(investigated(judged)) == said
    assert ending_words(investigated(recorded)) == "nothing was judged yet"
