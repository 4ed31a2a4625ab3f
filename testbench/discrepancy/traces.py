"""What every candidate effect would change in the recordings, and the inner products of these traces."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import repeat

import numpy as np

from testbench.discrepancy.candidates import Candidate, candidate_ideas, expand, trace
from testbench.discrepancy.fit import Fit, prior_ridge
from testbench.discrepancy.freeform import features
from testbench.discrepancy.grams import Grams, Rows, Weighting, grams
from testbench.discrepancy.measurement import Measurement
from testbench.discrepancy.noise import autoregression, robust_sd, whitened
from testbench.discrepancy.parameters import FreeParameter, values_of
from testbench.discrepancy.remounting import remounted
from testbench.discrepancy.sensitivity import sensitivities
from testbench.discrepancy.telling import Progress, silent
from testbench.knit.catalogue import Catalogue
from testbench.knit.effect import Effect, FloatArray
from testbench.knit.model import KnitModel, SimulationCache


@dataclass(frozen=True)
class FreeForm:
    """A free-form map of the residual over its coordinates, as inner products.

    Attributes
    ----------
    first, second : Grams
        Of the calibration and the held-out recording. Columns: residual, sensitivities, features.
    names : tuple of (str, str)
        Channel and group of coordinates of each feature.
    """

    first: Grams
    second: Grams
    names: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Traces:
    """Everything one weighing of the evidence works on.

    Attributes
    ----------
    candidates : tuple of Candidate
    first, second : Grams
        Of the calibration and the held-out recording. Columns: residual, sensitivities, traces.
    addresses : tuple of str
        Parameters whose sensitivities make the base.
    weights, ridge : ndarray, shape (base,)
        Their present values (fit coordinates) and prior precisions.
    free : FreeForm, optional
        What any effect could explain.
    """

    candidates: tuple[Candidate, ...]
    first: Grams
    second: Grams
    addresses: tuple[str, ...]
    weights: FloatArray
    ridge: FloatArray
    free: FreeForm | None = None


WHITE_STRIDE, PLAIN_STRIDE, WHITENING_STRIDE = 2, 4, 5


def collect(
    fitted: Fit,
    unbent: KnitModel,
    calibration: Measurement,
    held: Measurement,
    catalogue: Catalogue,
    progress: Progress | None = None,
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
    parts = [
        Columns(fitted.model, fitted.parameters, calibration, unbent),
        Columns(remounted(fitted.model, held), fitted.parameters, held, remounted(unbent, held)),
    ]
    kept = _screened(parts, candidate_ideas(catalogue, fitted.model), progress or silent)
    addresses = tuple(p.address for p in fitted.parameters)
    ridge = prior_ridge(fitted.parameters, calibration)
    left = _unexplained(parts[0])
    maps = [features(part.measurement) for part in parts]
    names = _feature_names(maps[0], calibration.channels)
    of_traces = [part.rows() for part in parts]
    of_features = [part.with_features(groups) for part, groups in zip(parts, maps, strict=True)]
    weighed = {}
    for name, white in (("white", True), ("plain", False)):
        weighting = _weighting(left, calibration, white)
        first, second, free_first, free_second = (
            grams(rows, part.measurement, weighting, len(addresses))
            for both in (of_traces, of_features)
            for rows, part in zip(both, parts, strict=True)
        )
        free = FreeForm(free_first, free_second, names)
        weighed[name] = Traces(tuple(kept), first, second, addresses, fitted.vector, ridge, free)
    return weighed


def _screened(
    parts: Sequence[Columns], ideas: Mapping[str, Sequence[type[Effect]]], tell: Progress
) -> list[Candidate]:
    """Candidates that change anything; their traces go into `parts`."""
    kept: list[Candidate] = []
    first = parts[0]
    with ThreadPoolExecutor(len(parts)) as pool:
        for idea, forms in ideas.items():
            tell(f"screening {idea}")
            tried = list(expand(forms, idea, first.model, first.measurement, first.state, first.residual))
            # One recording a thread: what effects have in common is simulated once for each recording.
            made = pool.map(Columns.trace_all, parts, repeat(tried))
            for candidate, *found in zip(tried, *made, strict=True):
                if _counts(candidate, found):
                    kept.append(candidate)
                    for part, item in zip(parts, found, strict=True):
                        part.traces.append(item or dict.fromkeys(part.measurement.channels))
    return kept


def _counts(candidate: Candidate, found: Sequence[Mapping[str, FloatArray | None] | None]) -> bool:
    """Whether a candidate changes anything: in both recordings, or in one if what it does belongs to one."""
    if candidate.effect.per_recording:
        return any(item is not None for item in found)
    return all(item is not None for item in found)


def _feature_names(groups: Mapping[str, FloatArray], channels: Sequence[str]) -> tuple[tuple[str, str], ...]:
    """Channel and group of coordinates of each column that `Columns.with_features` adds."""
    return tuple((channel, group) for channel in channels for group, rows in groups.items() for _ in rows)


class Columns:
    """Residual, sensitivities and traces of one measurement."""

    def __init__(
        self,
        model: KnitModel,
        parameters: Sequence[FreeParameter],
        measurement: Measurement,
        unbent: KnitModel | None = None,
    ) -> None:
        self.model, self.unbent = model, unbent or model
        self.parameters, self.measurement = parameters, measurement
        self.caches = {False: SimulationCache(), True: SimulationCache()}
        self.plain = measurement.modelled(self.unbent)
        self.modelled, self.jacobian = sensitivities(model, parameters, measurement, SimulationCache())
        self.state = model.simulate(measurement.signals, measurement.dt_s)
        self.residual = {c: measurement.measured[c] - self.modelled[c] for c in measurement.channels}
        self.traces: list[Mapping[str, FloatArray | None]] = []

    def trace(self, candidate: Candidate) -> dict[str, FloatArray | None] | None:
        if candidate.effect.per_recording:
            effect = candidate.effect
            here = effect.for_recording(self.state, self.residual, self.measurement.dt_s)
            same_size = {effect.strength: getattr(effect, effect.strength)}
            candidate = replace(candidate, effect=here.replaced(**same_size))
        alone = candidate.effect.imitable
        model, base = (self.unbent, self.plain) if alone else (self.model, self.modelled)
        return trace(candidate, model, self.measurement, base, self.caches[alone])

    def trace_all(self, candidates: Sequence[Candidate]) -> list[dict[str, FloatArray | None] | None]:
        """`trace` of each."""
        return [self.trace(candidate) for candidate in candidates]

    def base_rows(self) -> dict[str, list[FloatArray | None]]:
        """Residual and sensitivities of each channel."""
        return {c: [self.residual[c], *self.jacobian[c]] for c in self.measurement.channels}

    def with_features(self, groups: Mapping[str, FloatArray]) -> dict[str, Rows]:
        """Residual, sensitivities, and every feature once for each channel."""
        values = [row for rows in groups.values() for row in rows]
        channels = self.measurement.channels
        return {
            channel: [*rows, *(row if other == channel else None for other in channels for row in values)]
            for channel, rows in self.base_rows().items()
        }

    def rows(self) -> dict[str, Rows]:
        """Residual, sensitivities and traces of each channel."""
        return {c: [*rows, *(item[c] for item in self.traces)] for c, rows in self.base_rows().items()}


def _unexplained(part: Columns) -> dict[str, FloatArray]:
    """What is left of each channel's residual when everything may explain it, shape (n,)."""
    found = {}
    for channel, rows in part.rows().items():
        columns = [row for row in rows if row is not None]
        picked = np.stack([row[part.measurement.counts][::WHITENING_STRIDE] for row in columns])
        picked -= picked.mean(axis=1, keepdims=True)
        norms = np.linalg.norm(picked[1:], axis=1)
        norms[norms == 0] = 1.0
        gram = (picked[1:] @ picked[1:].T) / np.outer(norms, norms)
        gram[np.diag_indices_from(gram)] += 1e-4
        amounts = np.linalg.solve(gram, (picked[1:] @ picked[0]) / norms) / norms
        found[channel] = columns[0] - sum(amount * row for amount, row in zip(amounts, columns[1:], strict=True))
    return found


def _weighting(left: Mapping[str, FloatArray], measurement: Measurement, white: bool) -> Weighting:
    """How samples count, from what nothing explains."""
    counts = measurement.counts
    filters = {c: autoregression(values[counts]) if white else np.ones(1) for c, values in left.items()}
    spreads = {c: robust_sd(whitened(values, filters[c])[counts]) for c, values in left.items()}
    scale = {c: max(value, 1e-300) for c, value in spreads.items()}
    return Weighting(filters, scale, WHITE_STRIDE if white else PLAIN_STRIDE)


def traces_of_one(part: Columns, kept: Sequence[Candidate]) -> Traces:
    """Traces to be fitted and judged on the same recording, weighed as they are."""
    here, parameters = part.measurement, part.parameters
    weighting = _weighting(part.residual, here, white=False)
    inner = grams(part.rows(), here, weighting, len(parameters))
    addresses, values = tuple(p.address for p in parameters), values_of(part.model, parameters)
    return Traces(tuple(kept), inner, inner, addresses, values, prior_ridge(parameters, here))
