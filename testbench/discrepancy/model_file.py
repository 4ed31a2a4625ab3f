"""``model.json``: a fitted model, what it was fitted on, and the history of its errors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from gcode.support.console import knitbench_version
from gcode.support.errors import UserError
from gcode.support.files import read_json, write_json
from testbench.discrepancy.fit import Fit
from testbench.knit.catalogue import Catalogue, load_catalogue, model_from_dict
from testbench.knit.model import KnitModel
from testbench.recording import Recording


@dataclass(frozen=True)
class ModelFile:
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
        One entry a step of the ladder, the oldest first; see `testbench.discrepancy.ladder`.
    """

    model: KnitModel
    gauge_length_mm: float
    fitted_on: str = ""
    held_out: str = ""
    fit: Mapping[str, Any] = field(default_factory=dict)
    history: tuple[Mapping[str, Any], ...] = ()

    def save(self, path: str | Path) -> None:
        """Write atomically."""
        write_json(
            path,
            self.model.to_dict()
            | {
                "gauge_length_mm": self.gauge_length_mm,
                "fitted_on": self.fitted_on,
                "held_out": self.held_out,
                "fit": dict(self.fit),
                "history": [dict(step) for step in self.history],
                "knitbench": knitbench_version(),
            },
        )


def load_model_file(path: str | Path, catalogue: Catalogue | None = None) -> ModelFile:
    """Read ``model.json``.

    Raises
    ------
    UserError
        For anything that is not a model of this version; the message names the file and the remedy.
    """
    data = read_json(path, "model")
    model = model_from_dict(data, catalogue or load_catalogue(), str(path))
    try:
        return ModelFile(
            model,
            float(data.get("gauge_length_mm", 0.0)),
            str(data.get("fitted_on", "")),
            str(data.get("held_out", "")),
            dict(data.get("fit", {})),
            tuple(data.get("history", ())),
        )
    except (TypeError, ValueError) as error:
        raise UserError(f"{path}: damaged model file ({error}); fit it again with `testbench fit`") from error


def check_same_set_up(file: ModelFile, recording: Recording, path: str | Path) -> None:
    """Refuse to compare a model with a recording of another gauge length.

    Raises
    ------
    UserError
    """
    if file.gauge_length_mm and abs(file.gauge_length_mm - recording.gauge_length_mm) > 1e-3 * file.gauge_length_mm:
        raise UserError(
            f"{path}: fitted at a gauge length of {file.gauge_length_mm:g} mm, but {recording.source} has "
            f"{recording.gauge_length_mm:g} mm; fit a model on a recording of the same set-up"
        )


def fit_summary(fit: Fit) -> dict[str, Any]:
    """JSON-ready parameters with standard errors, and plain lists of what cannot be trusted."""
    parameters = {}
    for p, x, error in zip(fit.parameters, fit.vector, fit.standard_errors, strict=True):
        value = p.to_physical(x)
        parameters[p.address] = {
            "value": value,
            "unit": p.unit,
            "standard_error": float(error * (value if p.log else 1)),
        }
    return {
        "parameters": parameters,
        "at_bound": fit.at_bound(),
        "unidentified": fit.unidentified(),
        "correlated": [list(pair) for pair in fit.correlated()],
        "residual_scale": {channel: float(value) for channel, value in fit.scale.items()},
        "iterations": fit.iterations,
    }
