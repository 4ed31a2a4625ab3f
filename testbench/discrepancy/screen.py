"""Which effect would explain the residual: a cheap test for every catalogue entry.

Each candidate's trace is set against the residual after the base has had its say (a score test), fitted on one
recording and judged on the other, and the other way round. Both judgements count, block by block.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from testbench.discrepancy.baseline import SHAPES
from testbench.discrepancy.candidates import Candidate, expand, is_vector, two_signed
from testbench.discrepancy.ceiling import could_explain
from testbench.discrepancy.fit import shape_scales
from testbench.discrepancy.folds import Folds, across, within
from testbench.discrepancy.measurement import Measurement
from testbench.discrepancy.parameters import free_parameters
from testbench.discrepancy.traces import Columns, Traces, traces_of_one
from testbench.knit.effect import Effect
from testbench.knit.model import KnitModel


@dataclass(frozen=True)
class Score:
    """How well the best single form of an idea explains the residual.

    Attributes
    ----------
    idea : str
    loss : float
        Whitened squared error, judged where it was not fitted.
    best : Candidate
        The form and shape that speaks for the idea.
    coefficient : float
        Of its trace.
    """

    idea: str
    loss: float
    best: Candidate
    coefficient: float


STIFF, FLEXIBLE = "stiff", "flexible"
WITHOUT_SLIP = "without any slip"
# What an effect that is free in every recording must do better to be preferred to one that is not.
PRICE_PER_RECORDING = 0.1


@dataclass(frozen=True)
class Judgement:
    """Losses of the base alone and of every idea, over the ways the base may bend.

    Attributes
    ----------
    base : dict of mode to float
        Cross-judged loss of the base without any candidate.
    ideas : dict of idea to dict of mode to float
    spokesmen : dict of (idea, mode) to Score
        The single form that speaks for the idea.
    ceiling : float
        Loss when a free-form map of the residual helps the flexible base: what any effect could reach.
    depends_on : dict of (channel, group of coordinates) to float
        Loss when only that group of the free form helps.
    """

    base: Mapping[str, float]
    ideas: Mapping[str, Mapping[str, float]]
    spokesmen: Mapping[tuple[str, str], Score]
    ceiling: float
    depends_on: Mapping[tuple[str, str], float]


def modes(traces: Traces) -> dict[str, np.ndarray]:
    """Ways the base may bend: stiff, flexible, and flexible but for one shape; kept sensitivities."""
    owners = np.array([address.split(".")[0] for address in traces.addresses])
    # Bouc-Wen loops stay: what the slip elements would be without them no linear sum can tell.
    owners[owners == "hysteresis_bouc_wen"] = "hysteresis"
    shapes = [shape for shape in SHAPES if shape in owners]
    found = {STIFF: ~np.isin(owners, shapes), FLEXIBLE: np.ones(len(owners), bool)}
    for shape in shapes:
        found[f"without {shape}"] = owners != shape
    slips = (owners == "hysteresis_shape") | np.array([".slip_" in address for address in traces.addresses])
    if slips.any():
        found[WITHOUT_SLIP] = ~slips
    return found


def judge_ideas(traces: Traces) -> Judgement:
    """Cross-judge every idea under every mode of the base."""
    members: dict[str, list[int]] = {}
    for index, candidate in enumerate(traces.candidates):
        members.setdefault(candidate.idea, []).append(index)
    base: dict[str, float] = {}
    ideas: dict[str, dict[str, float]] = {idea: {} for idea in members}
    spokesmen: dict[tuple[str, str], Score] = {}
    own = [i for i, candidate in enumerate(traces.candidates) if candidate.effect.per_recording]
    over, inside = across(traces.first, traces.second), within(traces.first, traces.second)
    for mode, kept in modes(traces).items():
        folds = _Judges(Folds(traces, over, kept), Folds(traces, inside, kept, own))
        base[mode] = folds.across.bare
        for idea, indices in members.items():
            score = _best_score(traces, idea, indices, folds)
            ideas[idea][mode], spokesmen[idea, mode] = score.loss, score
    return Judgement(base, ideas, spokesmen, *could_explain(traces))


@dataclass(frozen=True)
class _Judges:
    """Folds across recordings, and within each for what belongs to one recording."""

    across: Folds
    within: Folds


def _best_score(traces: Traces, idea: str, members: list[int], folds: _Judges) -> Score:
    """The best of: each form's single best point; all linear points of one form, or of all forms, together."""
    forms: dict[str, list[int]] = {}
    for index in members:
        forms.setdefault(traces.candidates[index].form, []).append(index)
    scores = []
    for indices in forms.values():
        own = traces.candidates[indices[0]].effect.per_recording
        scores.append(_form_score(traces, idea, indices, folds.within if own else folds.across, folds.across.bare))
    best = min(scores, key=lambda score: score.loss)
    linear = [index for index in members if _is_linear(traces.candidates[index].effect)]
    if len(forms) > 1 and linear:
        signed = [two_signed(type(traces.candidates[index].effect)) for index in linear]
        together = folds.across.loss([1 + index for index in linear], signed)
        best = replace(best, loss=min(best.loss, together))
    return best


def _is_linear(effect: Effect) -> bool:
    return _is_additive(effect) and not effect.per_recording


def _is_additive(effect: Effect) -> bool:
    """Whether several points of the shape grid may act together (a spectrum); bends put together bend to anything."""
    return not (effect.nonlinear or effect.imitable)


def _form_score(traces: Traces, idea: str, members: list[int], folds: Folds, bare: float) -> Score:
    effect = traces.candidates[members[0]].effect
    signed = two_signed(type(effect))
    alone = [folds.loss([1 + index], [signed]) for index in members]
    best = int(np.argmin(alone))
    loss = alone[best]
    if _is_additive(effect) and len(members) > 1:
        loss = min(loss, folds.loss([1 + index for index in members], [signed] * len(members)))
    # Relative to the same base on the same folds, then brought to the scale of the folds across recordings.
    loss = loss / folds.bare * bare
    if effect.per_recording:
        loss += PRICE_PER_RECORDING * max(bare - loss, 0.0)
    return Score(idea, loss, traces.candidates[members[best]], folds.amount(1 + members[best], signed))


def best_start(fitted_model: KnitModel, effect: Effect, calibration: Measurement) -> Effect:
    """`effect` at the point of its shape grid, and with the strength, that explains most of the residual.

    A fit that adds an effect starts here: from the wrong time constant it would not find the right one.
    """
    return best_starts(fitted_model, [effect], calibration)[0]


def best_starts(fitted_model: KnitModel, effects: Sequence[Effect], calibration: Measurement) -> list[Effect]:
    """`best_start` for each of several effects, each on its own."""
    parameters = free_parameters(fitted_model, shape_scales(calibration))
    part = Columns(fitted_model, parameters, calibration)
    kept: list[Candidate] = []
    for effect in effects:
        form = type(effect)
        if form.strength and not is_vector(form, form.strength):
            for candidate in expand([form], form.name, fitted_model, calibration, part.state, part.residual):
                found = part.trace(candidate)
                if found is not None:
                    kept.append(candidate)
                    part.traces.append(found)
    if not kept:
        return list(effects)
    traces = traces_of_one(part, kept)
    total = traces.first.total
    folds = Folds(traces, [(total, total)], np.ones(len(parameters), bool))
    return [_best_point(effect, traces, folds) for effect in effects]


def _best_point(effect: Effect, traces: Traces, folds: Folds) -> Effect:
    members = [index for index, candidate in enumerate(traces.candidates) if candidate.form == effect.name]
    if not members:
        return effect
    score = _form_score(traces, effect.name, members, folds, folds.bare)
    return score.best.at(score.coefficient)
