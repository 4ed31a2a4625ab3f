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


def side_by_side(*sides: tuple[str, Mapping[str, Any], KnitModel | None]) -> Table:
    """Parameters of models, one a column; a value that should be doubted stands in brackets.

    A side is its label, its fit and, where that does not hold all of its parameters, the model itself.
    """
    fits = [fit.get("parameters", {}) for _, fit, _ in sides]
    units = {key: str(entry["unit"]) for fit in fits for key, entry in fit.items() if "[" not in key}
    rows = [
        (parameter_name(key), *(value_in_words(key, unit, fit, model) for _, fit, model in sides))
        for key, unit in units.items()
    ]
    return Table(("Parameter", *(label for label, _, _ in sides)), rows, IN_BRACKETS)


def value_in_words(key: str, unit: str, fit: Mapping[str, Any], model: KnitModel | None) -> str:
    """A parameter's value and error; the value alone where no error is kept, nothing where the model has none."""
    entry = fit.get("parameters", {}).get(key)
    if entry is not None:
        text = with_error(float(entry["value"]), float(entry["standard_error"]), unit)
        return f"({text})" if doubts(key, fit) else text
    effect, _, name = key.partition(".")
    value = getattr(model[effect], name, None) if model and effect in model else None
    return in_words(value, unit) if isinstance(value, int | float) else ""
