"""The score of a compensator as a plain JSON document: the interface to the report and the studio.

Its shape is documented in docs/compensation.md; `testbench` reads the file and never imports this package.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from compensation.model.compensator import TrainedCompensator
from compensation.model.prediction import predicted
from compensation.series import score
from compensation.series.preprocessing import Series, series_of
from gcode.support.arrays import FloatArray
from testbench.recordings.recording import Recording

FORMAT, FORMAT_VERSION = "knitbench-score", 1
TRACE_POINTS = 1500
ZOOM_POINTS = 600
ZOOM_S, ZOOMS = 60.0, 3


def score_recordings(compensator: TrainedCompensator, recordings: Sequence[Recording]) -> dict[str, Any]:
    """Score a compensator as it runs in use (its memories begin as a stream's do): the document, ready for JSON."""
    rows = [_score_one(compensator, recording) for recording in recordings]
    held_out = [row for row in rows if row["role"] == "held-out"]
    return {
        "format": FORMAT,
        "version": FORMAT_VERSION,
        "compensator": {
            "target": compensator.target,
            "unit": compensator.unit,
            "parameters": compensator.parameter_count,
            "networks": len(compensator.networks),
            "per_recording_scaling": compensator.per_recording,
            "recipe": dict(compensator.recipe),
        },
        "recordings": rows,
        "summary": _summary(held_out or rows),
    }


def _trained_on(recipe: Mapping[str, Any], part: Series) -> bool:
    """Whether a part of it was learned from, by its content; by its path where an older file says no more."""
    if "trained_digests" in recipe:
        return part.digest in recipe["trained_digests"] or part.holds_any(recipe.get("trained_marks", []))
    return any(_is_of(part, source) for source in recipe.get("trained_on", []))


def _is_reference(note: Mapping[str, Any], part: Series) -> bool:
    """Whether a part of it was the reference of a recalibration; one of a few samples is known by its path."""
    return part.holds_any(note["marks"]) if note.get("marks") else _is_of(part, note["on"])


def _is_of(part: Series, source: str) -> bool:
    """Whether a series was read from this place."""
    return Path(part.source).resolve() == Path(source).resolve()


def _role(recipe: Mapping[str, Any], part: Series) -> str:
    """What a recording was to a compensator: learned from, a reference that it was recalibrated by, or neither."""
    if _trained_on(recipe, part):
        return "training"
    references = recipe.get("recalibrated", [])
    return "reference" if any(_is_reference(note, part) for note in references) else "held-out"


def _score_one(compensator: TrainedCompensator, recording: Recording) -> dict[str, Any]:
    learned = series_of(recording, compensator.target, compensator.resampling_hz)
    part, prediction = _as_it_runs(compensator, recording, learned)
    before = score.r2_before(part.truth, part.conductance_S, compensator.sign)
    after = score.r2(part.truth, prediction)
    return {
        "source": part.source,
        "role": _role(compensator.recipe, learned),
        "duration_s": float(part.time_s[-1] - part.time_s[0]),
        "samples": len(part),
        "r2_before": before,
        "r2_after": after,
        "r2_rescaled": score.r2_before(part.truth, prediction),
        "r2_ordinary": score.r2_ordinary(part.truth, prediction),
        "r2_after_interval": score.block_interval(part.truth, prediction, part.time_s),
        "rho2_before": score.rho_squared(part.truth, part.conductance_S),
        "gain": after - before,
        "rms_error": float(np.sqrt(np.mean((part.truth - prediction) ** 2))),
        **_traces(part, prediction, compensator.sign),
    }


def _as_it_runs(compensator: TrainedCompensator, recording: Recording, learned: Series) -> tuple[Series, FloatArray]:
    """What is scored, and the prediction of it: as `learned`, but of a slower recording than that its own samples.

    Between them, the grid that is learned from has straight lines to the next sample, which nobody in use knows.
    """
    if compensator.per_recording or recording.mean_rate_hz >= compensator.rate_hz:
        return learned, compensator.in_use.predict_series(learned)
    own = series_of(recording, compensator.target, None)
    return own, predicted(compensator, own.time_s, 1.0 / own.conductance_S).value


def _summary(rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    keys = ("r2_before", "r2_after", "r2_rescaled", "gain")
    mean = {key: float(np.mean([row[key] for row in rows])) for key in keys}
    criterion = score.error_of_two(rows[0]["r2_after"], rows[1]["r2_after"]) if len(rows) == 2 else None
    over = " and ".join(dict.fromkeys(row["role"] for row in rows))
    return {"over": over, "recordings": len(rows), **mean, "E": criterion}


def _traces(part: Series, prediction: np.ndarray, sign: float) -> dict[str, Any]:
    """F, G and p, thinned over the whole recording, and whole in a few short windows."""
    raw = sign * score.standardised(part.conductance_S) * part.truth.std() + part.truth.mean()

    def cut(rows: np.ndarray | slice) -> dict[str, list[float]]:
        columns = {"F": part.truth, "G": part.conductance_S, "G_rescaled": raw, "p": prediction}
        shown = {name: [float(f"{value:.6g}") for value in column[rows]] for name, column in columns.items()}
        return {"time_s": np.round(part.time_s[rows], 6).tolist(), **shown}

    step = -(-len(part) // TRACE_POINTS)
    return {"trace": cut(slice(None, None, step)), "zooms": [cut(rows) for rows in _windows(part.time_s)]}


def _windows(time_s: np.ndarray) -> list[np.ndarray]:
    """Rows of windows at the start, the middle and the end."""
    length = min(ZOOM_S, (time_s[-1] - time_s[0]) / ZOOMS)
    begins = np.linspace(time_s[0], time_s[-1] - length, ZOOMS)
    found = [np.flatnonzero((time_s >= begin) & (time_s <= begin + length)) for begin in begins]
    return [rows[:: -(-len(rows) // ZOOM_POINTS)] for rows in found if len(rows)]
