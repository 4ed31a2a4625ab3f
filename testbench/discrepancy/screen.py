"""Which effect would explain the residual: a cheap test for every catalogue entry.

Each candidate's trace is set against the residual after the base has had its say (a score test), fitted on one
recording and judged on the other, and the other way round. Both judgements count, block by block.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from testbench.discrepancy.candidates import Candidate, candidate_ideas, expand, is_vector, trace, two_signed
from testbench.discrepancy.fit import SAMPLES_PER_INDEPENDENT, Fit, shape_scales
from testbench.discrepancy.grams import Grams, grams, loss, solve
from testbench.discrepancy.measurement import Measurement
from testbench.discrepancy.noise import autoregression, robust_sd, whitened
from testbench.discrepancy.parameters import FreeParameter, free_parameters
from testbench.discrepancy.sensitivity import sensitivities
from testbench.knit.catalogue import Catalogue
from testbench.knit.effect import Effect, FloatArray
from testbench.knit.model import KnitModel, SimulationCache


@dataclass(frozen=True)
class Score:
    """How well one idea explains the residual.

    Attributes
    ----------
    idea : str
    gains : ndarray, shape (b,)
        Fall of the whitened squared error in each block, judged where it was not fitted, over the number of
        samples of the block.
    share : float
        Fall over all blocks as a share of the error without the idea.
    best : Candidate
        The form and shape that speaks for the idea.
    coefficient : float
        Of its trace.
    """

    idea: str
    gains: FloatArray
    share: float
    best: Candidate
    coefficient: float

    @property
    def t(self) -> float:
        """Mean gain over its standard error between blocks."""
        error = self.gains.std(ddof=1) / np.sqrt(len(self.gains))
        return float(self.gains.mean() / error) if error > 0 else 0.0


@dataclass(frozen=True)
class Traces:
    """Everything the screening works on."""

    candidates: tuple[Candidate, ...]
    first: Grams
    second: Grams
    ridge: FloatArray

    def column(self, index: int) -> int:
        """Position of a candidate among the Gram columns."""
        return 1 + self.first.base + index


def collect(
    fitted: Fit,
    calibration: Measurement,
    held: Measurement,
    catalogue: Catalogue,
    progress: Callable[[str], None] | None = None,
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
    filters, scale = _whitening(stacked, parts)
    first, second = (
        grams(columns, part.measurement, filters, scale, len(fitted.parameters))
        for columns, part in zip(stacked, parts, strict=True)
    )
    return Traces(tuple(kept), first, second, prior_ridge(fitted.parameters))


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
    stacked: Sequence[Mapping[str, FloatArray]], parts: Sequence[_Columns]
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
        filters[channel] = autoregression(left)
        scale[channel] = max(robust_sd(whitened(left, filters[channel])), 1e-300)
    return filters, scale


def score_ideas(traces: Traces) -> list[Score]:
    """Score every idea, best first."""
    ideas: dict[str, list[int]] = {}
    for index, candidate in enumerate(traces.candidates):
        ideas.setdefault(candidate.idea, []).append(index)
    bare = _cross_losses(traces, [], [])
    scores = [_score(traces, idea, members, bare) for idea, members in ideas.items()]
    return sorted(scores, key=lambda score: -score.share)


def _cross_losses(traces: Traces, columns: list[int], signed: list[bool]) -> FloatArray:
    """Fit on either recording, judge on the other; squared error a block, shape (2 b,)."""
    losses = []
    for fit_on, judge in ((traces.first, traces.second), (traces.second, traces.first)):
        solution = solve(fit_on.total, fit_on.base, columns, signed, traces.ridge)
        losses.append(loss(judge.blocks, solution))
    return np.concatenate(losses)


def _score(traces: Traces, idea: str, members: list[int], bare: FloatArray) -> Score:
    columns = [traces.column(index) for index in members]
    signed = [two_signed(type(traces.candidates[index].effect)) for index in members]
    losses = _cross_losses(traces, columns, signed)
    samples = np.concatenate([traces.second.samples, traces.first.samples])
    best, coefficient = _spokesman(traces, members, signed)
    share = float((bare.sum() - losses.sum()) / bare.sum())
    return Score(idea, (bare - losses) / samples, share, traces.candidates[best], coefficient)


def _spokesman(traces: Traces, members: list[int], signed: list[bool]) -> tuple[int, float]:
    """The one form and shape that explains most on both recordings together, and its coefficient."""
    total = traces.first.total + traces.second.total
    found = []
    for index, sign in zip(members, signed, strict=True):
        column = traces.column(index)
        solution = solve(total, traces.first.base, [column], [sign], traces.ridge)
        found.append((float(loss(total[None], solution)[0]), index, float(solution[column])))
    _, best, coefficient = min(found)
    return best, coefficient


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
    traces = Traces(tuple(kept), inner, empty, prior_ridge(parameters))
    signed = [two_signed(form)] * len(kept)
    best, coefficient = _spokesman(traces, list(range(len(kept))), signed)
    return kept[best].at(coefficient)


def prior_ridge(parameters: Sequence[FreeParameter]) -> FloatArray:
    """Precision of the base's coefficients in the units of the Gram matrices."""
    return np.array([p.width for p in parameters]) ** -2.0 * SAMPLES_PER_INDEPENDENT
