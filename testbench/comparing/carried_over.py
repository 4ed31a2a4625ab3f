"""Whether what was found on one recording holds on another, told by the errors of the steps of a diagnosis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

CLEARLY = 0.8  # of an error: what leaves more has not changed it
LEFT_AT_MOST = 0.5  # of what laws should explain, by those that are named
FAILS = 3.0  # times the calibration error, held out
REST_S = 60.0  # between recordings of one specimen, where nobody said so

Steps = Sequence[Mapping[str, Any]]  # the history of a diagnosis


def step_before(history: Steps, found: int) -> Mapping[str, Any]:
    """The step that the candidates of a diagnosis were weighed against: the last before what was found was put in."""
    return history[max(len(history) - found, 1) - 1]


def changed(history: Steps, found: int) -> list[str]:
    """Channels whose error is clearly smaller for what was found; all of them where none is."""
    before, now = (step["errors"]["calibration"] for step in (step_before(history, found), history[-1]))
    return [c for c in now if now[c] < CLEARLY * before[c]] or list(now)


def fails_elsewhere(history: Steps, found: int) -> str:
    """What is said where a model that is right on its own recording fails on the held-out one; empty where not.

    Parameters
    ----------
    history : sequence of mapping
        Steps of the diagnosis, as a model file keeps them.
    found : int
        How many effects were put in.
    """
    errors = history[-1]["errors"]
    times = {c: _times(errors, "held_out", c) for c in changed(history, found)}
    worst = max(times, key=lambda c: times[c])
    if times[worst] < FAILS:
        return ""
    fails = f"held out the error of the {worst} is {times[worst]:.0f} times as large: "
    if worst in errors.get("same_specimen", {}) and (again := _times(errors, "same_specimen", worst)) < FAILS:
        return (
            f"{fails}that is for a fresh specimen. For the same one, after a rest of {REST_S:g} s, it is "
            f"{again:.2g} times as large: if it is the same, say how long it rested"
        )
    if found:
        other = "Another mechanism may be the cause, or what the specimen had gone through before"
        return f"{fails}what was found does not carry over. {other}"
    return (
        f"{fails}that recording shows what this one does not. Diagnose it as well, or one that has the motion of both"
    )


def _times(errors: Mapping[str, Mapping[str, float]], kind: str, channel: str) -> float:
    """How many times the calibration error an error of this kind is."""
    return errors[kind][channel] / (errors["calibration"][channel] or 1e-300)
