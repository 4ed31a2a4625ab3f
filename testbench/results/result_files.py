"""Results as other commands read them again: diagnoses, scores, designed experiments; every entry in use is checked.

What a later version adds beside these entries is passed on as it is.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from gcode.support.errors import UserError
from gcode.support.strict import json_of, read_text, validated
from testbench.knit.effect_names import HYPOTHESES
from testbench.recordings.stored import GaugeLength, Label, StoredModel, checked_model
from testbench.results.model_file import Errors, ExtraKept, Step, Summary

MOST_BYTES = 64 << 20
SCORE_FORMAT = "knitbench-score"
IN_A_DIAGNOSIS = ("verdict", "probabilities", "found", "ranking", "error_before", "error_after", "noise_floor")
LARGEST = 1e15  # beyond any quantity that is written; its square is still a number
Finite = Annotated[float, Field(ge=-LARGEST, le=LARGEST)]
Share = Annotated[float, Field(ge=0, le=1 + 1e-9)]
Size = Annotated[float, Field(ge=0, le=LARGEST)]
MOST_EFFECTS, MOST_POINTS = 1000, 1_000_000


class _Named(ExtraKept):
    """A mechanism (``effect``) and the law of it that fits best; ``form`` is what older files call the law."""

    effect: Label
    law: Label

    @model_validator(mode="before")
    @classmethod
    def _law(cls, data: Any) -> Any:
        if not isinstance(data, dict) or "form" not in data or "law" in data:
            return data
        return {"law" if key == "form" else key: value for key, value in data.items()}


class _Ranked(_Named):
    probability: Share
    log_evidence: Finite
    gain: Finite
    held_out_gain: tuple[Finite, Finite, Finite] | None = None
    error_share_left: Size = 1.0
    tied_for_first: bool = False


class _Found(_Named):
    probability: Share
    log_evidence: Finite


class _Dependence(ExtraKept):
    channel: Label
    coordinate: Label
    gain: Finite


class StoredDiagnosis(ExtraKept):
    """What ``testbench diagnose --json`` writes."""

    verdict: Literal["missing", "nothing_missing", "unknown"]
    probabilities: dict[Label, Share]
    found: Annotated[list[_Found], Field(max_length=MOST_EFFECTS)]
    ranking: Annotated[list[_Ranked], Field(max_length=MOST_EFFECTS)]
    tied: Annotated[list[Label], Field(max_length=MOST_EFFECTS)] = Field(default_factory=list)
    base_misfits: Annotated[list[Label], Field(max_length=MOST_EFFECTS)] = Field(default_factory=list)
    other_laws: Annotated[list[Label], Field(max_length=MOST_EFFECTS)] = Field(default_factory=list)
    bends_like: Label | Literal[""] = ""
    depends_on: Annotated[list[_Dependence], Field(max_length=MOST_EFFECTS)] = Field(default_factory=list)
    left_unexplained: Finite = 1.0
    error_before: dict[Label, Size]
    error_after: dict[Label, Size]
    noise_floor: dict[Label, Size]
    model_before: StoredModel | None = None
    model_after: StoredModel | None = None
    parameters_after: Summary = Field(default_factory=Summary)
    history: Annotated[list[Step], Field(max_length=1000)] = Field(default_factory=list)

    @model_validator(mode="after")
    def _agrees_with_itself(self) -> StoredDiagnosis:
        ranked = {one.effect for one in self.ranking}
        strange = [name for name in self.tied if name not in ranked]
        if strange:
            raise ValueError(f"tied: {strange[0]!r} is not in the ranking")
        if self.verdict == "missing" and not (self.ranking and self.found):
            raise ValueError("verdict: something is missing, but nothing is ranked or found")
        named = [*HYPOTHESES, *(one.effect for one in self.ranking), *filter(None, [self.bends_like])]
        if unknown := [name for name in named if name not in self.probabilities]:
            raise ValueError(f"probabilities: there is none of {unknown[0]!r}")
        Errors(calibration=self.error_before, held_out=self.error_after)
        if set(self.error_before) != set(self.error_after) or set(self.error_before) != set(self.noise_floor):
            raise ValueError("error_before, error_after and noise_floor must be of the same channels")
        return self


class _Columns(ExtraKept):
    time_s: Annotated[list[Finite], Field(max_length=MOST_POINTS)]

    @model_validator(mode="after")
    def _of_one_length(self) -> _Columns:
        lengths = {len(getattr(self, column)) for column in type(self).model_fields}
        if len(lengths) > 1 or lengths == {0}:
            raise ValueError(f"{', '.join(type(self).model_fields)} must be of one length, and not empty")
        return self


class _Trace(_Columns):
    F: list[Finite]
    G: list[Finite]
    G_rescaled: list[Finite]
    p: list[Finite]


class _Scored(ExtraKept):
    source: Annotated[str, Field(max_length=4096)]
    role: Label
    r2_before: Finite
    r2_after: Finite
    r2_after_interval: tuple[Finite, Finite] | None  # None: too short for one
    rho2_before: Finite
    gain: Finite
    rms_error: Size
    trace: _Trace
    zooms: Annotated[list[_Trace], Field(min_length=1, max_length=100)]


class _Compensator(ExtraKept):
    target: Literal["force", "displacement"]
    unit: Label
    parameters: Annotated[int, Field(ge=0)]


class _ScoreSummary(ExtraKept):
    over: Label
    recordings: Annotated[int, Field(ge=1)]
    r2_before: Finite
    r2_after: Finite
    gain: Finite
    E: Finite | None = None


class StoredScore(ExtraKept):
    """What ``compensation score -o`` writes."""

    format: Literal["knitbench-score"]
    version: Literal[1]
    compensator: _Compensator
    recordings: Annotated[list[_Scored], Field(min_length=1, max_length=1000)]
    summary: _ScoreSummary


class _Option(ExtraKept):
    protocol: Label
    duration_s: Size
    log_odds: Finite
    grade: Label
    channel: Label


class _Left(_Columns):
    over_noise: list[Finite]


class StoredExperiment(ExtraKept):
    """What ``testbench experiment --json`` writes."""

    rivals: Annotated[list[Label], Field(min_length=2, max_length=100)]
    gauge_length_mm: GaugeLength
    options: Annotated[list[_Option], Field(min_length=1, max_length=1000)]
    left: dict[Literal["force", "conductance"], _Left]


def read_diagnosis(path: str | Path) -> Mapping[str, Any]:
    """What `testbench diagnose --json` wrote.

    Raises
    ------
    UserError
        If it is missing or is something else.
    """
    return checked_diagnosis(_read(path, "diagnosis"), path)


def checked_diagnosis(data: Any, path: str | Path) -> Mapping[str, Any]:
    """A diagnosis as pages and designs read it: every entry checked, its laws under the key ``law``.

    Parameters
    ----------
    data : dict
        What `testbench diagnose --json` writes.
    path : path
        What an error calls it.

    Raises
    ------
    UserError
        If it is something else.
    """
    if not isinstance(data, dict) or any(key not in data for key in IN_A_DIAGNOSIS):
        raise UserError(f"{path}: not a diagnosis of this version; `testbench diagnose --json FILE` writes one")
    for name in ("model_before", "model_after"):
        checked_model(data.get(name), path)
    return _plain(validated(data, StoredDiagnosis, path, "diagnosis"))


def read_score(path: str | Path) -> Mapping[str, Any]:
    """What `compensation score -o` wrote.

    Raises
    ------
    UserError
        If it is missing or is something else.
    """
    data = _read(path, "score")
    if not isinstance(data, dict) or data.get("format") != SCORE_FORMAT:
        raise UserError(
            f"{path}: not a score (its format must be {SCORE_FORMAT!r}); `compensation score -o` writes one"
        )
    return _plain(validated(data, StoredScore, path, "score"))


def read_experiment(path: str | Path) -> Mapping[str, Any]:
    """What `testbench experiment --json` wrote.

    Raises
    ------
    UserError
        If it is missing or is something else.
    """
    return _plain(validated(_read(path, "experiment"), StoredExperiment, path, "experiment"))


def _read(path: str | Path, what: str) -> Any:
    return json_of(read_text(path, what, MOST_BYTES), what, path)


def _plain(model: ExtraKept) -> Mapping[str, Any]:
    return model.model_dump(mode="json", exclude_unset=True)
