"""Which effect would explain the residual: a cheap test for every catalogue entry.

Each candidate's trace is set against the residual after the base has had its say (a score test), fitted on one
recording and judged on the other, and the other way round. Both judgements count, block by block.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from testbench.discrepancy.candidates import (
    SHAPE_IDEAS,
    Candidate,
    candidate_ideas,
    expand,
    is_vector,
    trace,
    two_signed,
)
from testbench.discrepancy.fit import SAMPLES_PER_INDEPENDENT, Fit, shape_scales
from testbench.discrepancy.grams import Grams, Reduced, grams, reduce_to_traces
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
    share : float
        Fall of the loss as a share of the loss without the idea.
    best : Candidate
        The form and shape that speaks for the idea.
    coefficient : float
        Of its trace.
    """

    idea: str
    loss: float
    share: float
    best: Candidate
    coefficient: float


@dataclass(frozen=True)
class Traces:
    """Everything the screening works on.

    Attributes
    ----------
    candidates : tuple of Candidate
    first, second : Grams
        Of the calibration and the held-out recording.
    addresses : tuple of str
        Parameters whose sensitivities make the base.
    weights, ridge : ndarray, shape (base,)
        Their present values (fit coordinates) and prior precisions.
    """

    candidates: tuple[Candidate, ...]
    first: Grams
    second: Grams
    addresses: tuple[str, ...]
    weights: FloatArray
    ridge: FloatArray


def collect(
    fitted: Fit,
    calibration: Measurement,
    held: Measurement,
    catalogue: Catalogue,
    progress: Callable[[str], None] | None = None,
    white: bool = True,
) -> Traces:
    """Simulate every candidate on both recordings and form the inner products."""
    parts = [_Columns(fitted.model, fitted.parameters, measurement) for measurement in (calibration, held)]
    kept: list[Candidate] = []
    for idea, forms in candidate_ideas(catalogue, fitted.model).items():
        if progress:
            progress(f"screening {idea}")
        for candidate in expand(forms, idea, fitted.model, calibration):
            found = [part.trace(candidate) for part in parts]
            if all(item is not None for item in found):
                kept.append(candidate)
                for part, item in zip(parts, found, strict=True):
                    part.traces.append(item)  # type: ignore[arg-type]
    stacked = [part.stacked() for part in parts]
    filters, scale = _whitening(stacked, parts, white)
    first, second = (
        grams(columns, part.measurement, filters, scale, len(fitted.parameters))
        for columns, part in zip(stacked, parts, strict=True)
    )
    addresses = tuple(p.address for p in fitted.parameters)
    return Traces(tuple(kept), first, second, addresses, fitted.vector, prior_ridge(fitted.parameters))


class _Columns:
    """Residual, sensitivities and traces of one measurement."""

    def __init__(self, model: KnitModel, parameters: Sequence[FreeParameter], measurement: Measurement) -> None:
        self.model, self.measurement = model, measurement
        self.cache = SimulationCache()
        self.modelled, self.jacobian = sensitivities(model, parameters, measurement, SimulationCache())
        self.traces: list[dict[str, FloatArray]] = []

    def trace(self, candidate: Candidate) -> dict[str, FloatArray] | None:
        return trace(candidate, self.model, self.measurement, self.modelled, self.cache)

    def stacked(self) -> dict[str, FloatArray]:
        return {
            channel: np.vstack(
                [
                    (self.measurement.measured[channel] - self.modelled[channel])[None],
                    self.jacobian[channel],
                    *(item[channel][None] for item in self.traces),
                ]
            )
            for channel in self.measurement.channels
        }


def _whitening(
    stacked: Sequence[Mapping[str, FloatArray]], parts: Sequence[_Columns], white: bool
) -> tuple[dict[str, FloatArray], dict[str, float]]:
    """Whitening filter and scale a channel, from what is left of the residual when everything may explain it."""
    filters, scale = {}, {}
    for channel in parts[0].measurement.channels:
        columns, rows = stacked[0][channel], parts[0].measurement.counts
        x = columns[:, rows] - columns[:, rows].mean(axis=1, keepdims=True)
        norms = np.maximum(np.linalg.norm(x[1:], axis=1, keepdims=True), 1e-300)
        gram = (x[1:] / norms) @ (x[1:] / norms).T
        gram[np.diag_indices_from(gram)] += 1e-4
        left = x[0] - np.linalg.solve(gram, (x[1:] / norms) @ x[0]) @ (x[1:] / norms)
        filters[channel] = autoregression(left) if white else np.ones(1)
        scale[channel] = max(robust_sd(whitened(left, filters[channel])), 1e-300)
    return filters, scale


@dataclass(frozen=True)
class Verdicts:
    """Losses of the base alone and of every idea, over the ways the base may bend.

    Attributes
    ----------
    base : dict of mode to float
        Cross-judged loss of the base without any candidate.
    ideas : dict of idea to dict of mode to float
    """

    base: Mapping[str, float]
    ideas: Mapping[str, Mapping[str, float]]


STIFF, FLEXIBLE = "stiff", "flexible"


def modes(traces: Traces) -> dict[str, np.ndarray]:
    """Ways the base may bend: stiff, flexible, and flexible but for one shape; kept sensitivities."""
    owners = np.array([address.split(".")[0] for address in traces.addresses])
    shapes = [shape for shape in SHAPE_IDEAS if shape in owners]
    found = {STIFF: ~np.isin(owners, shapes), FLEXIBLE: np.ones(len(owners), bool)}
    for shape in shapes:
        found[f"without {shape}"] = owners != shape
    return found


def judge_ideas(traces: Traces) -> tuple[Verdicts, dict[tuple[str, str], Score]]:
    """Cross-judge every idea under every mode of the base."""
    members: dict[str, list[int]] = {}
    for index, candidate in enumerate(traces.candidates):
        members.setdefault(candidate.idea, []).append(index)
    base: dict[str, float] = {}
    ideas: dict[str, dict[str, float]] = {idea: {} for idea in members}
    spokesmen: dict[tuple[str, str], Score] = {}
    for mode, kept in modes(traces).items():
        folds = _folds(traces, kept)
        base[mode] = sum(fold.judged([], np.zeros(0)) for fold in folds)
        for idea, indices in members.items():
            chosen = [1 + index for index in indices]
            signed = [two_signed(type(traces.candidates[index].effect)) for index in indices]
            ideas[idea][mode] = sum(fold.judged(chosen, fold.amounts(chosen, signed)) for fold in folds)
            spokesmen[idea, mode] = _spokesman(traces, folds, idea, indices, signed, base[mode])
    return Verdicts(base, ideas), spokesmen


def _folds(traces: Traces, kept: np.ndarray) -> list[Reduced]:
    first, second = traces.first.total, traces.second.total
    pairs = [(first, second), (second, first)] if second.any() else [(first, first)]
    size = traces.first.base
    return [reduce_to_traces(fit, judge, size, traces.ridge, kept, traces.weights) for fit, judge in pairs]


def _spokesman(
    traces: Traces, folds: Sequence[Reduced], idea: str, members: list[int], signed: list[bool], bare: float
) -> Score:
    """The one form and shape that does best where it was not fitted, and its coefficient."""
    best = (np.inf, members[0], 0.0)
    for index, sign in zip(members, signed, strict=True):
        amounts = [fold.amounts([1 + index], [sign]) for fold in folds]
        loss = sum(fold.judged([1 + index], amount) for fold, amount in zip(folds, amounts, strict=True))
        if loss < best[0]:
            best = (loss, index, float(amounts[0][0]))
    return Score(idea, best[0], (bare - best[0]) / bare, traces.candidates[best[1]], best[2])


def best_start(fitted_model: KnitModel, effect: Effect, calibration: Measurement) -> Effect:
    """`effect` at the point of its shape grid, and with the strength, that explains most of the residual.

    A fit that adds an effect starts here: from the wrong time constant it would not find the right one.
    """
    form = type(effect)
    if not effect.strength or is_vector(form, effect.strength):
        return effect
    parameters = free_parameters(fitted_model, shape_scales(calibration))
    part = _Columns(fitted_model, parameters, calibration)
    kept = []
    for candidate in expand([form], effect.idea or effect.name, fitted_model, calibration):
        found = part.trace(candidate)
        if found is not None:
            kept.append(candidate)
            part.traces.append(found)
    if not kept:
        return effect
    plain = {channel: np.ones(1) for channel in calibration.channels}
    residual = calibration.residual(fitted_model)
    scale = {channel: max(robust_sd(values[calibration.counts]), 1e-300) for channel, values in residual.items()}
    inner = grams(part.stacked(), calibration, plain, scale, len(parameters))
    empty = Grams(np.zeros_like(inner.blocks), inner.samples, inner.base)
    values = values_of(fitted_model, parameters)
    traces = Traces(tuple(kept), inner, empty, tuple(p.address for p in parameters), values, prior_ridge(parameters))
    folds = _folds(traces, np.ones(len(parameters), bool))
    score = _spokesman(traces, folds, form.name, list(range(len(kept))), [two_signed(form)] * len(kept), 1.0)
    return score.best.at(score.coefficient)


def prior_ridge(parameters: Sequence[FreeParameter]) -> FloatArray:
    """Precision of the base's coefficients in the units of the Gram matrices."""
    return np.array([p.width for p in parameters]) ** -2.0 * SAMPLES_PER_INDEPENDENT
