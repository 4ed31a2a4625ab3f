"""Whether what was found on one recording holds on another, told by the errors of the steps of a diagnosis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from testbench.comparing.remounting import held_errors
from testbench.measurements.joining import last_of
from testbench.recordings.recording import Recording
from testbench.results.model_file import ModelFile

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


def with_same_specimen(
    file: ModelFile, found: int, recording: Recording, held_out: Recording, clamp_play_mm: float
) -> ModelFile:
    """The ladder of a diagnosis; where it fails on a fresh specimen, the last step also says its errors on the same.

    Those are in ``errors["same_specimen"]``: of `held_out` after `recording` and a rest of `REST_S`.

    Parameters
    ----------
    file : ModelFile
        With the ladder of a diagnosis whose held-out recording was taken for one of a fresh specimen.
    found : int
        How many effects were put in.
    recording, held_out : Recording
    clamp_play_mm : float
        See `Measurement`.
    """
    if not fails_elsewhere(file.history, found):
        return file
    again = last_of([recording, held_out], [REST_S], clamp_play_mm)
    *earlier, last = file.history
    errors = {**last["errors"], "same_specimen": held_errors(file.model, again)}
    return replace(file, history=(*earlier, {**last, "errors": errors}))


def _times(errors: Mapping[str, Mapping[str, float]], kind: str, channel: str) -> float:
    """How many times the calibration error an error of this kind is."""
    return errors[kind][channel] / (errors["calibration"][channel] or 1e-300)
