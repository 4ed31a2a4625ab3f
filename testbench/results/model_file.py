"""``model.json``: a fitted model, what it was fitted on, and the history of its errors."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Annotated, Any

from pydantic import ConfigDict, Field, model_validator

from gcode.support.console import knitbench_version
from gcode.support.errors import UserError
from gcode.support.files import write_json
from gcode.support.read_only import Unchanging
from gcode.support.strict import StrictModel, read_json, validated
from testbench.knit.catalogue import Catalogue, load_catalogue, model_from_dict
from testbench.knit.model import KnitModel
from testbench.measurements.responses import CONDUCTANCE_CHANNEL, FORCE_CHANNEL, UNIT_OF
from testbench.recordings.between import MOST_REST_S, Between
from testbench.recordings.channels import FORCE, RESISTANCE
from testbench.recordings.recording import Recording
from testbench.recordings.stored import Label, StoredModel, checked_model

AT_BOUND, UNTOLD = "at a bound", "this recording cannot tell"
Source = Annotated[str, Field(max_length=4096)]  # the name of a recording
MEASURED_AS = {FORCE_CHANNEL: FORCE, CONDUCTANCE_CHANNEL: RESISTANCE}


class ExtraKept(StrictModel):
    """What a later version adds beside the entries that are checked is passed on as it is."""

    model_config = ConfigDict(frozen=True, extra="allow", allow_inf_nan=False)


class _Parameter(ExtraKept):
    value: float
    unit: Label
    standard_error: Annotated[float, Field(ge=0)]


class Summary(ExtraKept):
    """What `testbench.fitting.fit.Fit.summary` makes."""

    parameters: dict[Label, _Parameter] = Field(default_factory=dict)
    at_bound: list[Label] = Field(default_factory=list)
    unidentified: list[Label] = Field(default_factory=list)
    correlated: list[tuple[Label, Label, float]] = Field(default_factory=list)
    residual_scale: dict[Label, float] = Field(default_factory=dict)


class Errors(ExtraKept):
    calibration: dict[Label, Annotated[float, Field(ge=0)]]
    held_out: dict[Label, Annotated[float, Field(ge=0)]]
    same_specimen: dict[Label, Annotated[float, Field(ge=0)]] = Field(default_factory=dict)


class _Zero(ExtraKept):
    """A `testbench.comparing.clamping.Zero`."""

    shift_mm: float
    standard_error_mm: Annotated[float, Field(ge=0)]
    play_mm: Annotated[float, Field(gt=0, le=1e5)]
    force_N: float | None = None


class Step(ExtraKept):
    """What `testbench.comparing.ladder.ladder_step` makes."""

    step: Label
    model: StoredModel
    errors: Errors
    noise_floor: dict[Label, Annotated[float, Field(ge=0)]]
    fitted_on: Source = ""
    held_out: Source = ""
    zero: _Zero | None = None
    rest_s: Annotated[float, Field(gt=0, lt=MOST_REST_S)] | None = None
    recordings: Annotated[int, Field(ge=1)] = 1  # in a row, that it was fitted on
    fit: Summary | None = None  # of a step that is not the last

    @model_validator(mode="after")
    def _same_channels(self) -> Step:
        known = set(self.errors.held_out)
        if known - set(UNIT_OF) or known != set(self.errors.calibration) or known != set(self.noise_floor):
            raise ValueError(f"errors and noise_floor must be of the same channels, of {', '.join(UNIT_OF)}")
        return self


class _Rest(StrictModel):
    """What a model file says beside the model."""

    model_config = ConfigDict(frozen=True, extra="ignore", allow_inf_nan=False)

    gauge_length_mm: Annotated[float, Field(ge=0, le=1e6)] = 0.0
    fitted_on: Source = ""
    held_out: Source = ""
    fit: Summary = Summary()
    history: Annotated[list[Step], Field(max_length=1000)] = Field(default_factory=list)


@dataclass(frozen=True)
class ModelFile(Unchanging):
    """What ``model.json`` holds.

    Attributes
    ----------
    model : KnitModel
    gauge_length_mm : float
    fitted_on, held_out : str
        Names of the recordings.
    fit : mapping
        Parameters with unit and standard error; at_bound, unidentified, correlated.
    history : tuple of mapping
        One entry a step of the ladder, the oldest first; see `testbench.comparing.ladder`.
    """

    model: KnitModel
    gauge_length_mm: float
    fitted_on: str = ""
    held_out: str = ""
    fit: Mapping[str, Any] = field(default_factory=dict)
    history: tuple[Mapping[str, Any], ...] = ()

    @property
    def between(self) -> Between:
        """The recording that it was fitted on and the held-out one, as its last step was judged."""
        last = self.history[-1] if self.history else {}
        zero = last.get("zero")
        return Between(float(zero["play_mm"]) if zero else 0.0, last.get("rest_s"))

    @property
    def of_several(self) -> bool:
        """Whether its last step was fitted on several recordings in a row."""
        return bool(self.history) and self.history[-1].get("recordings", 1) > 1

    def save(self, path: str | Path) -> None:
        """Write atomically."""
        beside = {one.name: getattr(self, one.name) for one in fields(self) if one.name != "model"}
        write_json(path, self.model.to_dict() | beside | {"knitbench": knitbench_version()})


def load_model_file(path: str | Path, catalogue: Catalogue | None = None) -> ModelFile:
    """Read ``model.json``.

    Raises
    ------
    UserError
        For anything that is not a model of this version; the message names the file and the remedy.
    """
    data = checked_model(read_json(path, "model"), path)
    model = model_from_dict(data, catalogue or load_catalogue(), str(path))
    try:
        rest = _beside_the_model(data, path)
    except UserError as error:
        raise UserError(f"{error}; fit it again with `testbench fit`") from None
    return ModelFile(model, **{"gauge_length_mm": 0.0, **rest, "history": tuple(rest.get("history", ()))})


def about_model(path: str | Path) -> Mapping[str, Any]:
    """What a model file says beside the model: gauge_length_mm, fitted_on, held_out, fit, history; those it has.

    Raises
    ------
    UserError
        As `load_model_file`; only the effects are not made.
    """
    return _beside_the_model(checked_model(read_json(path, "model"), path), path)


def _beside_the_model(data: Mapping[str, Any], path: str | Path) -> dict[str, Any]:
    return validated(data, _Rest, path, "model").model_dump(mode="json", exclude_unset=True)


def doubted(fit: Mapping[str, Any]) -> dict[str, str]:
    """Why a fitted value should not be trusted, by its address: a bound holds it, or else the recording is silent."""
    untold, at_bound = fit.get("unidentified", ()), fit.get("at_bound", ())
    return dict.fromkeys(untold, UNTOLD) | dict.fromkeys(at_bound, AT_BOUND)


def same_source(kept: str, source: str) -> bool:
    """Whether a recording is the one that a model file names.

    Where nothing is at the path that was kept (the folder has moved), campaign and file must have the same names.
    """
    if not kept or os.path.abspath(kept) == os.path.abspath(source):
        return bool(kept)
    return not os.path.exists(kept) and Path(kept).parts[-2:] == Path(source).parts[-2:]


def check_same_set_up(file: ModelFile, recording: Recording, path: str | Path) -> None:
    """Refuse a recording of another gauge length than the model's, or of a channel that it knows nothing of."""
    if file.history:
        fitted = file.history[-1]["errors"]["calibration"]
        for channel, column in MEASURED_AS.items():
            if channel not in fitted and recording.has(column):
                raise UserError(
                    f"{path}: fitted on {' and '.join(fitted)} alone, but {recording.source} has {column}, too; fit "
                    "a model on a recording of the same channels, or leave that column out"
                )
    if file.gauge_length_mm and abs(file.gauge_length_mm - recording.gauge_length_mm) > 1e-3 * file.gauge_length_mm:
        raise UserError(
            f"{path}: fitted at a gauge length of {file.gauge_length_mm:g} mm, but {recording.source} has "
            f"{recording.gauge_length_mm:g} mm; fit a model on a recording of the same set-up"
        )
