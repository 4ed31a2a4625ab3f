"""A second model beside a campaign's own: an earlier step of its ladder, or the model of another campaign."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gcode.support.errors import UserError
from testbench.comparing.numbers import in_words, with_error
from testbench.comparing.words import spoken
from testbench.knit.catalogue import model_from_dict
from testbench.knit.model import KnitModel
from testbench.report.document import Table
from testbench.report.parameter_table import doubts, parameter_name
from testbench.results.model_file import load_model_file
from testbench.studio import models
from testbench.studio.studio import Studio

IN_BRACKETS = "± is one standard error; a value in brackets is doubtful."


@dataclass(frozen=True)
class Beside:
    """One model, as it is drawn and listed beside another.

    Attributes
    ----------
    label : str
        What it is called on the page.
    model : KnitModel
    fit : mapping
        ``fit`` of its file; empty for an earlier step, whose file says the values alone.
    path : Path
        Where it is kept.
    """

    label: str
    model: KnitModel
    fit: Mapping[str, Any]
    path: Path


def beside_choices(studio: Studio, c: str) -> dict[str, str]:
    """What can stand beside the model of `c`: earlier steps by number, fitted campaigns of its gauge length."""
    same, rest = models.companions(studio, c)
    others = {name: f"that of {name}" for name in (*same, *rest) if models.has_model(studio, name)}
    return others | _steps(studio, c)


def _steps(studio: Studio, c: str) -> dict[str, str]:
    earlier = models.history_of(studio, c)[:-1]
    return {str(number): f"step {number}: {spoken(step['step'])}" for number, step in enumerate(earlier)}


def beside_of(studio: Studio, c: str, wanted: str) -> Beside:
    """The second model that an address asks for.

    Raises
    ------
    UserError
        If there is none.
    """
    known = beside_choices(studio, c)
    if wanted not in known:
        raise UserError(
            f"there is no second model {wanted!r} for {c}; the steps of its ladder and the fitted campaigns of its "
            f"gauge length are: {', '.join(known) or 'none'}"
        )
    catalogue = studio.effects.catalogue()
    own = wanted in _steps(studio, c)
    path = models.model_path(studio, c if own else wanted)
    file = load_model_file(path, catalogue)
    if own:
        model = model_from_dict(file.history[int(wanted)]["model"], catalogue, "history")
        return Beside(known[wanted], model, {}, path)
    return Beside(known[wanted], file.model, file.fit, path)


def side_by_side(first: Beside, label: str, model: KnitModel, fit: Mapping[str, Any]) -> Table:
    """Parameters of two models, one a column; a value that should be doubted stands in brackets."""
    rows = [
        (parameter_name(key), value_in_words(first.model, first.fit, key, fit), value_in_words(model, fit, key, fit))
        for key in parameters_of(first.fit, fit)
    ]
    return Table(("Parameter", first.label, label), rows, IN_BRACKETS)


def parameters_of(*fits: Mapping[str, Any]) -> list[str]:
    """The parameters that any of the fits has, each once, without the weights of shapes."""
    return list(dict.fromkeys(key for fit in fits for key in fit.get("parameters", {}) if "[" not in key))


def value_in_words(model: KnitModel, fit: Mapping[str, Any], key: str, other: Mapping[str, Any]) -> str:
    """A parameter's value and error; the value alone where no error is kept, nothing where the model has none."""
    if key in fit.get("parameters", {}):
        return fitted_value(fit, key)
    effect, _, name = key.partition(".")
    value = getattr(model[effect], name, None) if effect in model else None
    if not isinstance(value, int | float):
        return ""
    return in_words(value, str(other["parameters"][key]["unit"]))


def fitted_value(fit: Mapping[str, Any], key: str) -> str:
    """A fitted parameter's value and error, in brackets where it should be doubted; empty where it is not there."""
    entry = fit.get("parameters", {}).get(key)
    if entry is None:
        return ""
    text = with_error(float(entry["value"]), float(entry["standard_error"]), str(entry["unit"]))
    return f"({text})" if doubts(key, fit) else text
