"""`add`: an effect put into a model, started where the data want it, everything refitted; `undo` takes it back."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from gcode.support.errors import UserError
from testbench.api.arguments import AnyModel, Effects, Source, catalogue_of, model_file_of, recordings_for
from testbench.api.models.fitting import FitResult
from testbench.api.models.ladder import Ladder
from testbench.api.progress import Tell, telling
from testbench.comparing.ladder import NO_LONGER_PAYS, idle_effects
from testbench.comparing.ladder import undo as taken_back
from testbench.comparing.model_errors import over_the_floors
from testbench.diagnosis.adding import add_effect
from testbench.knit.catalogue import BASELINE
from testbench.measurements.splitting import split
from testbench.results.model_file import ModelFile


def add(
    model: AnyModel,
    effect: str,
    recording: Source,
    held_out: Source | None = None,
    *,
    effects: Effects = None,
    gauge_length_mm: float | None = None,
    progress: Tell | bool | None = None,
) -> FitResult:
    """Put an effect of the catalogue into a model, refit, and put the step on the ladder.

    The search starts at the strength and the times that the residual asks for; ``tb.fit(recording, model=fit.model +
    effect)`` starts at the parameters of `effect` instead.

    Parameters
    ----------
    model : KnitModel, result or path
    effect : str
        Its name in the catalogue (``testbench effects`` lists them).
    recording, held_out : Recording or path
        To refit on, and to judge on; default: the last third of `recording`.
    effects : path, Catalogue or effect classes, optional
        The user's own effects.
    gauge_length_mm : float, optional
        In mm, for paths of bare CSV files; default: the model's.
    progress : callable or bool, optional
        See `testbench.api.progress.telling`.

    Returns
    -------
    FitResult

    Raises
    ------
    UserError
        If there is no such effect, or it is no name, or the recordings do not fit the model or each other.

    Examples
    --------
    >>> import testbench as tb
    >>> recording = tb.example(tb.effects.StressRelaxation(fraction=0.3))
    >>> base = tb.fit(recording, progress=False)
    >>> tb.add(base, "stress_relaxation", recording, progress=False).ladder
    <Ladder baseline + stress_relaxation>
    """
    if not isinstance(effect, str):
        raise UserError(
            f"effect: must be a name such as 'stress_relaxation', got {effect!r}; an object goes into the model: "
            "tb.fit(recording, model=fit.model + effect)"
        )
    catalogue = catalogue_of(effects)
    file = model_file_of(model, catalogue)
    first, second, between = recordings_for(model, file, recording, held_out, gauge_length_mm)
    calibration, held = split(first, second, between=between)
    with telling(progress) as tell:
        larger = add_effect(file, effect, calibration, held, catalogue, tell)
    gone = sorted(_laws(file) - _laws(larger))
    told = [f"{effect} takes the place of {name}: a model has one law of the kind" for name in gone]
    return FitResult(larger, calibration, held, (*told, *_worse_fitted(larger)))


def undo(model: AnyModel, *, effects: Effects = None) -> Ladder:
    """Take the last step of a model's ladder back.

    Parameters
    ----------
    model : result or path
    effects : path, Catalogue or effect classes, optional
        The user's own effects.

    Returns
    -------
    Ladder
        Of the model before that step.

    Raises
    ------
    UserError
        If there is no step to take back.

    Examples
    --------
    >>> import testbench as tb
    >>> recording = tb.example(tb.effects.StressRelaxation(fraction=0.3))
    >>> base = tb.fit(recording, progress=False)
    >>> tb.undo(tb.add(base, "stress_relaxation", recording, progress=False))
    <Ladder baseline>
    """
    catalogue = catalogue_of(effects)
    return Ladder(taken_back(model_file_of(model, catalogue), catalogue))


def no_longer_pays(found: FitResult, added: str) -> list[str]:
    """Effects of a model that hardly lower its held-out error, now that another one was added.

    Parameters
    ----------
    found : FitResult
        Of `add`.
    added : str
        The effect that came last; it is not asked about, nor is a second one of the same law.
    """
    # A law without a strength (piezoresistance in place of contact) makes a signal that others need.
    effects = found.model.effects.items()
    optional = {name for name, one in effects if one.strength and one.name != added} - set(BASELINE)
    return idle_effects(found.file, found.calibration, found.held_out, optional)


def _worse_fitted(file: ModelFile) -> list[str]:
    """What to say where the last step of a ladder fits worse than the one before did, on the same recording."""
    *_, before, now = (None, *file.history)
    if before is None or (before.get("fitted_on"), before["noise_floor"]) != (now["fitted_on"], now["noise_floor"]):
        return []
    was, is_now = (over_the_floors(step["errors"]["calibration"], now["noise_floor"]) for step in (before, now))
    if is_now <= was * (1 + NO_LONGER_PAYS):
        return []
    told = f"the model fits worse than before: its error was {was:.3g} noise floors, and is {is_now:.3g}"
    return [f"{told}; undo takes the step back"]


def _laws(file: ModelFile) -> set[str]:
    return {effect.name for effect in file.model.effects.values()}


def laws_with(diagnosis: Mapping[str, Any], law: str, model: AnyModel, effects: Effects = None) -> list[str]:
    """The laws to `add` one after the other so that one of a diagnosis is in: what the base itself needs goes first.

    Parameters
    ----------
    diagnosis : mapping
        As ``testbench diagnose --json`` writes it.
    law : str
    model : KnitModel, result or path
        What it has already is left out.
    effects : path, Catalogue or effect classes, optional
    """
    has = _laws(model_file_of(model, catalogue_of(effects)))
    wanted = [*diagnosis.get("other_laws", ()), *diagnosis.get("base_misfits", ()), law]
    return [name for name in wanted if name not in has]
