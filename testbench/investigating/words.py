"""An investigation as text for the terminal."""

from __future__ import annotations

from collections.abc import Mapping

from testbench.comparing import words
from testbench.comparing.words import percent
from testbench.diagnosis.judging.probabilities import NOTHING, UNKNOWN
from testbench.investigating.state import SURE, Investigation, RunState

SHOWN = 4
SPOKEN = {NOTHING: "nothing is missing", UNKNOWN: "something that no effect explains"}


def spoken(name: str) -> str:
    """A hypothesis in words."""
    return SPOKEN.get(name, words.spoken(name))


def belief_words(chances: Mapping[str, float]) -> str:
    """``permanent set 93 %, clamp slip 5 %``: the most probable, those under a percent left out."""
    first, *others = sorted(chances.items(), key=lambda one: -one[1])[:SHOWN]
    told = [first, *(one for one in others if one[1] >= 0.01)]
    return ", ".join(f"{spoken(name)} {percent(chance)}" for name, chance in told)


def run_words(number: int, run: RunState) -> str:
    """One run and what was believed after it."""
    said = f"run {number}, {run.seconds / 60:.1f} min: {run.words}"
    if run.expected_nats is not None:
        said += f"\n  expected to tell {run.expected_nats:.3f} nats (random motion: {run.perlin_nats or 0:.3f})"
    if run.belief is not None:
        said += f"\n  believed: {belief_words(run.belief.probabilities)}"
    return said


def ending_words(investigation: Investigation) -> str:
    """How it ended, in one sentence."""
    belief, minutes = investigation.belief, investigation.judged_s / 60
    if belief is None:
        return "nothing was judged yet"
    name, chance = belief.top
    if investigation.ended == SURE:
        return f"{spoken(name)}: {percent(chance)} after {minutes:.1f} min of motion"
    state = investigation.ended or "not ended yet"
    said = f"{state}: after {minutes:.1f} min of motion {belief_words(belief.probabilities)}"
    number, last = len(investigation.runs), investigation.runs[-1]
    waits = last.recorded and last.belief is None
    return f"{said}; run {number} is not judged yet" if waits else said


def investigation_words(investigation: Investigation) -> str:
    """All runs, and how it ended."""
    runs = [run_words(number, run) for number, run in enumerate(investigation.runs, 1)]
    return "\n".join([*runs, ending_words(investigation)])
