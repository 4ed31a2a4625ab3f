"""Which effect would explain the residual: a cheap test for every catalogue entry.

Each candidate's trace is set against the residual after the base has had its say (a score test), fitted on one
recording and judged on the other, and the other way round. Both judgements count, block by block.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from testbench.discrepancy.baseline import SHAPES
from testbench.discrepancy.candidates import (
    Candidate,
    candidate_ideas,
    expand,
    is_vector,
    trace,
    two_signed,
)
from testbench.discrepancy.fit import Fit, prior_ridge, shape_scales
from testbench.discrepancy.freeform import features
from testbench.discrepancy.grams import Grams, Rows, grams, reduce_to_traces
from testbench.discrepancy.measurement import Measurement
from testbench.discrepancy.noise import autoregression, robust_sd, whitened
from testbench.discrepancy.parameters import FreeParameter, free_parameters, values_of
from testbench.discrepancy.sensitivity import sensitivities
from testbench.knit.catalogue import Catalogue
from testbench.knit.effect import Effect, FloatArray
from testbench.knit.model import KnitModel, SimulationCache


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


@dataclass(frozen=True)
class Traces:
    """Everything one weighing of the evidence works on.

    Attributes
    ----------
    candidates : tuple of Candidate
    first, second : Grams
        Of the calibration and the held-out recording. Columns: residual, sensitivities, traces, free-form features.
    addresses : tuple of str
        Parameters whose sensitivities make the base.
    weights, ridge : ndarray, shape (base,)
        Their present values (fit coordinates) and prior precisions.
    features : tuple of (str, str)
        Channel and group of each free-form feature.
    """

    candidates: tuple[Candidate, ...]
    first: Grams
    second: Grams
    addresses: tuple[str, ...]
    weights: FloatArray
    ridge: FloatArray
    features: tuple[tuple[str, str], ...] = ()


WHITE_STRIDE, PLAIN_STRIDE, WHITENING_STRIDE = 2, 4, 5


def collect(
    fitted: Fit,
    unbent: KnitModel,
    calibration: Measurement,
    held: Measurement,
    catalogue: Catalogue,
    progress: Callable[[str], None] | None = None,
) -> dict[str, Traces]:
    """Simulate every candidate on both recordings and form the inner products.

    Parameters
    ----------
    fitted : Fit
        The base with its shape freedom.
    unbent : KnitModel
        The base without it: where imitable effects show what they would do.

    Returns
    -------
    dict of {"white", "plain"} to Traces
        The same evidence weighed twice. Whitened, noise of any colour counts for what it is, and quick effects stand
        out; plain, what matters is how much of the error goes away, and slow effects are not taken for slow noise.
    """
    parts = [_Columns(fitted.model, fitted.parameters, one, unbent) for one in (calibration, held)]
    kept: list[Candidate] = []
    for idea, forms in candidate_ideas(catalogue, fitted.model).items():
        if progress:
            progress(f"screening {idea}")
        for candidate in expand(forms, idea, fitted.model, calibration, parts[0].state, parts[0].residual):
            found = [part.trace(candidate) for part in parts]
            if _counts(candidate, found):
                kept.append(candidate)
                for part, item in zip(parts, found, strict=True):
                    part.traces.append(item or part.nothing)
    free = [_free_columns(part.measurement) for part in parts]
    addresses = tuple(p.address for p in fitted.parameters)
    ridge = prior_ridge(fitted.parameters, calibration)
    weighed = {}
    for name, white, stride in (("white", True, WHITE_STRIDE), ("plain", False, PLAIN_STRIDE)):
        filters, scale = _whitening(parts[0], white)
        both = [
            grams(_joined(part.rows(), extra), part.measurement, filters, scale, len(addresses), stride)
            for part, extra in zip(parts, free, strict=True)
        ]
        names = tuple(name for name, _ in free[0])
        weighed[name] = Traces(tuple(kept), both[0], both[1], addresses, fitted.vector, ridge, names)
    return weighed


def _counts(candidate: Candidate, found: Sequence[Mapping[str, FloatArray] | None]) -> bool:
    """Whether a candidate changes anything: in both recordings, or in one if what it does belongs to one."""
    if candidate.effect.per_recording:
        return any(item is not None for item in found)
    return all(item is not None for item in found)


FreeColumns = list[tuple[tuple[str, str], FloatArray]]


def _free_columns(measurement: Measurement) -> FreeColumns:
    """Free-form features, once for each channel: ((channel, group), values)."""
    groups = features(measurement)
    return [((c, group), row) for c in measurement.channels for group, rows in groups.items() for row in rows]


def _joined(columns: Mapping[str, Rows], free: FreeColumns) -> dict[str, Rows]:
    return {
        channel: [*rows, *(row if name[0] == channel else None for name, row in free)]
        for channel, rows in columns.items()
    }


class _Columns:
    """Residual, sensitivities and traces of one measurement."""

    def __init__(
        self,
        model: KnitModel,
        parameters: Sequence[FreeParameter],
        measurement: Measurement,
        unbent: KnitModel | None = None,
    ) -> None:
        self.model, self.unbent, self.measurement = model, unbent or model, measurement
        self.caches = {False: SimulationCache(), True: SimulationCache()}
        self.plain = measurement.modelled(self.unbent)
        self.modelled, self.jacobian = sensitivities(model, parameters, measurement, SimulationCache())
        self.state = model.simulate(measurement.signals, measurement.dt_s)
        self.residual = {c: measurement.measured[c] - self.modelled[c] for c in measurement.channels}
        self.traces: list[dict[str, FloatArray]] = []
        self.nothing = {c: np.zeros_like(values) for c, values in self.residual.items()}

    def trace(self, candidate: Candidate) -> dict[str, FloatArray] | None:
        if candidate.effect.per_recording:
            effect = candidate.effect
            here = effect.for_recording(self.state, self.residual, self.measurement.dt_s)
            same_size = {effect.strength: getattr(effect, effect.strength)}
            candidate = replace(candidate, effect=here.replaced(**same_size))
        alone = candidate.effect.imitable
        model, base = (self.unbent, self.plain) if alone else (self.model, self.modelled)
        return trace(candidate, model, self.measurement, base, self.caches[alone])

    def rows(self) -> dict[str, Rows]:
        """Residual, sensitivities and traces of each channel."""
        return {
            channel: [self.residual[channel], *self.jacobian[channel], *(item[channel] for item in self.traces)]
            for channel in self.measurement.channels
        }


def _whitening(part: _Columns, white: bool) -> tuple[dict[str, FloatArray], dict[str, float]]:
    """Whitening filter and scale a channel, from what is left of the residual when everything may explain it."""
    filters, scale = {}, {}
    counts = part.measurement.counts
    for channel, rows in part.rows().items():
        picked = np.stack([row[counts][::WHITENING_STRIDE] for row in rows if row is not None])
        picked -= picked.mean(axis=1, keepdims=True)
        norms = np.linalg.norm(picked[1:], axis=1)
        norms[norms == 0] = 1.0  # a trace that does not touch this channel
        gram = (picked[1:] @ picked[1:].T) / np.outer(norms, norms)
        gram[np.diag_indices_from(gram)] += 1e-4
        amounts = np.linalg.solve(gram, (picked[1:] @ picked[0]) / norms) / norms
        left = rows[0] - sum(amount * row for amount, row in zip(amounts, rows[1:], strict=True))
        filters[channel] = autoregression(left[counts]) if white else np.ones(1)
        scale[channel] = max(robust_sd(whitened(left, filters[channel])[counts]), 1e-300)
    return filters, scale


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
    for mode, kept in modes(traces).items():
        folds = _Judges(_Folds(traces, _across(traces), kept), _Folds(traces, _within(traces), kept, own))
        base[mode] = folds.across.bare
        for idea, indices in members.items():
            score = _best_score(traces, idea, indices, folds)
            ideas[idea][mode], spokesmen[idea, mode] = score.loss, score
    across = _Folds(traces, _across(traces), modes(traces)[FLEXIBLE])
    groups = {name: _free_loss(traces, across, [name]) for name in dict.fromkeys(traces.features)}
    return Judgement(base, ideas, spokesmen, _free_loss(traces, across, list(groups)), groups)


FREE_RIDGES = (10.0, 300.0, 1e4)  # shares of the largest inner product per mille


def _free_loss(traces: Traces, folds: _Folds, groups: Sequence[tuple[str, str]]) -> float:
    """Loss with some groups of the free form, shrunk by the ridge that judges best."""
    start = 1 + len(traces.candidates)
    chosen = [start + i for i, name in enumerate(traces.features) if name in set(groups)]
    return min(sum(part.judged(chosen, part.shrunk(chosen, ridge)) for part in folds.parts) for ridge in FREE_RIDGES)


def _across(traces: Traces) -> list[tuple[FloatArray, FloatArray]]:
    """Fit on either recording, judge on the other."""
    first, second = traces.first.total, traces.second.total
    return [(first, second), (second, first)]


def _within(traces: Traces) -> list[tuple[FloatArray, FloatArray]]:
    """Fit on every other block of a recording, judge on the rest of the same recording."""
    pairs = []
    for part in (traces.first, traces.second):
        even, odd = part.blocks[::2].sum(axis=0), part.blocks[1::2].sum(axis=0)
        pairs += [(even, odd), (odd, even)]
    return pairs


class _Folds:
    """The same base fitted and judged on several pairs of block sets.

    Only the candidates `only` (indices; default all) can be judged: fewer columns are quicker.
    """

    def __init__(
        self,
        traces: Traces,
        pairs: Sequence[tuple[FloatArray, FloatArray]],
        kept: np.ndarray,
        only: Sequence[int] | None = None,
    ) -> None:
        size = traces.first.base
        used = (
            list(range(len(traces.first.total)))
            if only is None
            else [*range(size + 1), *(size + 1 + i for i in only)]
        )
        self._place = None if only is None else {1 + index: 1 + place for place, index in enumerate(only)}
        pick = np.ix_(used, used)
        self.parts = [
            reduce_to_traces(fit[pick], judge[pick], size, traces.ridge, kept, traces.weights) for fit, judge in pairs
        ]
        self.bare = self.loss([], [])

    def loss(self, chosen: Sequence[int], signed: Sequence[bool]) -> float:
        places = self._places(chosen)
        return sum(part.judged(places, part.amounts(places, signed)) for part in self.parts)

    def amount(self, one: int, signed: bool) -> float:
        """Amount of one column as the first pair would have it."""
        return float(self.parts[0].amounts(self._places([one]), [signed])[0])

    def _places(self, chosen: Sequence[int]) -> Sequence[int]:
        return chosen if self._place is None else [self._place[index] for index in chosen]


@dataclass(frozen=True)
class _Judges:
    """Folds across recordings, and within each for what belongs to one recording."""

    across: _Folds
    within: _Folds


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


def _form_score(traces: Traces, idea: str, members: list[int], folds: _Folds, bare: float) -> Score:
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
    part = _Columns(fitted_model, parameters, calibration)
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
    traces = _on_itself(part, kept, parameters, calibration)
    folds = _Folds(traces, [(traces.first.total, traces.first.total)], np.ones(len(parameters), bool))
    return [_best_point(effect, traces, folds) for effect in effects]


def _best_point(effect: Effect, traces: Traces, folds: _Folds) -> Effect:
    members = [index for index, candidate in enumerate(traces.candidates) if candidate.form == effect.name]
    if not members:
        return effect
    score = _form_score(traces, effect.name, members, folds, folds.bare)
    return score.best.at(score.coefficient)


def _on_itself(
    part: _Columns, kept: Sequence[Candidate], parameters: Sequence[FreeParameter], calibration: Measurement
) -> Traces:
    """Traces to be fitted and judged on the same recording, weighed as they are."""
    plain = {channel: np.ones(1) for channel in calibration.channels}
    scale = {c: max(robust_sd(values[calibration.counts]), 1e-300) for c, values in part.residual.items()}
    inner = grams(part.rows(), calibration, plain, scale, len(parameters), PLAIN_STRIDE)
    empty = Grams(np.zeros_like(inner.blocks), inner.samples, inner.base)
    addresses, values = tuple(p.address for p in parameters), values_of(part.model, parameters)
    return Traces(tuple(kept), inner, empty, addresses, values, prior_ridge(parameters, calibration))
