"""Proposals: what each law of the catalogue would change in a model, and its evidence to first order."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from testbench.diagnosis.judging.entries import Proposal
from testbench.diagnosis.searching.candidates import Candidate, candidate_mechanisms, expand, is_vector, two_signed
from testbench.fitting.evidence.directions import Directions
from testbench.fitting.evidence.evidence import LogEvidence, Rows, is_on, maximised, switched_on
from testbench.fitting.evidence.hypothesis import Hypothesis
from testbench.fitting.evidence.likelihood import Likelihood
from testbench.fitting.evidence.priors import declared_size, tail_evidence, typical_strength, with_tails
from testbench.fitting.parameters import shape_scales
from testbench.knit.cache import SimulationCache
from testbench.knit.catalogue import Catalogue
from testbench.knit.effect import FloatArray

POINTS = 2  # points of a law's grid, the best to first order, that may be looked at with all scales free
WORTH_IT = 0.5  # nats to first order: what gains less is not looked at again
OFF_THRESHOLD = 0.3  # of a strength that was tried: how far from there it is, where a trace does not scale with it
ANY_WEIGHT = 1e-4  # precision, in weights that were tried, where no effect declares a size: the evidence finds it


@dataclass(frozen=True, eq=False)
class Law:
    """One law of a mechanism over its grid of shape parameters.

    Attributes
    ----------
    candidates : tuple of Candidate
    traces : mapping of channel to ndarray, shape (m, k)
        What each candidate changes at the samples that count, over their relative noise.
    """

    mechanism: str
    candidates: tuple[Candidate, ...]
    traces: Rows

    @property
    def is_of_strain(self) -> bool:
        """Whether it changes what the base laws see."""
        return "strain" in self.candidates[0].effect.writes


def laws_of(hypothesis: Hypothesis, likelihood: Likelihood, catalogue: Catalogue) -> list[Law]:
    """Simulate every law of the catalogue beside the model, over a coarse grid of its shape parameters."""
    measurement, model = likelihood.measurement, hypothesis.model
    plain = measurement.modelled(model)
    residual = {c: measurement.measured[c] - values for c, values in plain.items()}
    state = model.simulate(measurement.signals, measurement.dt_s)
    found = []
    for mechanism, laws in candidate_mechanisms(catalogue, model).items():
        cache = SimulationCache()
        for law in laws:
            tried, rows = [], []
            for candidate in expand(law, model, measurement, state, residual):
                changed = measurement.modelled(model.plus(candidate.effect), cache)
                row = {c: likelihood.picked(changed[c] - plain[c], c) for c in plain}
                acts = is_vector(law, law.strength) or any(np.any(values) for values in row.values())
                if acts and all(np.all(np.isfinite(values)) for values in row.values()):
                    tried.append(candidate)
                    rows.append(row)
            if any(np.any(values) for row in rows for values in row.values()):
                found.append(Law(mechanism, tuple(tried), {c: np.stack([row[c] for row in rows]) for c in plain}))
    return found


class Screen:
    """First-order evidence of laws beside a fitted model, all of whose parameters may move to make room.

    Of weights that share a prior, those combinations that the data see.
    """

    def __init__(self, hypothesis: Hypothesis, likelihood: Likelihood) -> None:
        scale, sigma, weighted = hypothesis.evidence.scale, hypothesis.evidence.sigma, hypothesis.weighted
        information = hypothesis.normal.information(sigma)
        self.directions = Directions.seen(weighted, information, hypothesis.priors, switched_on(scale))
        self.base = {c: self.directions.rows(rows) for c, rows in weighted.items()}
        self.normal, self.robust = self.directions.normal(hypothesis.normal), hypothesis.robust
        self.plain = maximised(self.normal, scale=scale, sigma=sigma)
        self.scales = shape_scales(likelihood.measurement)

    def proposals(self, laws: Sequence[Law]) -> list[Proposal]:
        """Every law at its best point, best first."""
        return sorted((self.best_point(law) for law in laws), key=lambda p: -p.gain)

    def best_point(self, law: Law) -> Proposal:
        rows = {c: values * self.robust[c] for c, values in law.traces.items()}
        first = law.candidates[0]
        if is_vector(type(first.effect), first.effect.strength):
            return self._vector(law, rows)
        gains, amounts = self._first_order(law.candidates, rows)
        tried = [self._beside(law, rows, int(i), gains[i], amounts[i]) for i in np.argsort(-gains)[:POINTS]]
        return max(tried, key=lambda p: p.gain)

    def _first_order(self, tried: Sequence[Candidate], rows: Rows) -> tuple[FloatArray, FloatArray]:
        """Gains at the scales of the model as it is, and coefficients of the traces, both of shape (m,)."""
        evidence, normal = self.plain, self.normal
        information = normal.information(evidence.sigma)
        with_base = np.sum([(rows[c] @ self.base[c].T) * information[c] for c in rows], axis=0)
        size = sum(np.einsum("ij,ij->i", rows[c], rows[c]) * information[c] for c in rows)
        inner = with_base[:, 1:]
        goal = with_base[:, 0] - inner @ evidence.coefficients
        on = np.flatnonzero(is_on(normal.group, evidence.scale))
        makes_room, covariance = inner[:, on], evidence.covariance[np.ix_(on, on)]
        left = size - np.einsum("ij,ij->i", makes_room @ covariance, makes_room)
        left = np.maximum(left, 1e-9 * size)
        mean, precision = np.array([amplitude_prior(one, self.scales) for one in tried]).T
        declared, tails = precision, mean == 0
        precision = np.where(tails, with_tails(declared, goal / left), precision)
        coefficient = (goal + precision * mean) / (left + precision)
        gain = 0.5 * (left + precision) * coefficient**2 - 0.5 * precision * mean**2
        gain -= 0.5 * np.log((left + precision) / precision)
        gain += np.where(tails, tail_evidence(declared, coefficient), 0.0)
        one_way = np.array([not two_signed(type(one.effect)) for one in tried])
        return np.where(one_way & (coefficient <= 0), np.minimum(gain, 0.0) - 1.0, gain), coefficient

    def _beside(self, law: Law, rows: Rows, index: int, gain: float, amount: float) -> Proposal:
        """One point of a law, with the scales of all groups found anew."""
        candidate, step = law.candidates[index], np.zeros(len(self.directions.member))
        if gain > WORTH_IT:
            mean, declared = amplitude_prior(candidate, self.scales)
            typically, off, has_tails = np.asarray(declared), np.asarray(amount), mean == 0
            precision = float(with_tails(typically, off)) if has_tails else declared
            found = self.evidence({c: values[index : index + 1] for c, values in rows.items()}, mean, precision, -1)
            amount, gain = float(found.coefficients[-1]), found.value - self.plain.value
            gain += float(tail_evidence(typically, off)) if has_tails else 0.0
            step = self.room_made(found, 1)
            if amount <= 0 and not two_signed(type(candidate.effect)):
                gain = -1.0
        else:
            amount = 1.0
        # The best of many points looks good by chance alone.
        gain = float(gain) - np.log(len(law.candidates))
        return Proposal(law.mechanism, candidate.law, candidate.at(amount), gain, step)

    def _vector(self, law: Law, rows: Rows) -> Proposal:
        """A law with a vector of weights: all its columns at once, their scale found by evidence."""
        first, count = law.candidates[0], len(law.candidates)
        said = declared_size(type(first.effect), first.effect.strength)
        precision = (first.strength / said) ** 2 if said else ANY_WEIGHT
        found = self.evidence(rows, 0.0, precision, 0, iterations=12, is_typical=bool(said))
        weights = tuple(float(a) * first.strength for a in found.coefficients[-count:])
        effect = first.effect.near(**{first.effect.strength: weights})
        gain = found.value - self.plain.value
        return Proposal(law.mechanism, first.law, effect, gain, self.room_made(found, count))

    def evidence(
        self,
        rows: Rows,
        mean: float,
        precision: float,
        group: int,
        iterations: int = 6,
        is_typical: bool = False,
    ) -> LogEvidence:
        """Evidence of the model with more columns, all with one prior.

        Parameters
        ----------
        group : int
            0: the scale of the new columns is found by evidence; -1: it is as declared.
        is_typical : bool
            `precision` is that of their typical size, and the scale has Cauchy's prior around it.

        Returns
        -------
        LogEvidence
            Its coefficients are along `directions`, the new columns last; see `room_made`.
        """
        count, start = len(next(iter(rows.values()))), self.plain
        number = -1 if group < 0 else len(start.scale)
        priors = [mean] * count, [precision] * count, [number] * count
        bigger = self.normal.extended(self.base, rows, *priors)
        if is_typical:
            bigger = replace(bigger, typical_groups=bigger.typical_groups | {number})
        scale = start.scale if group < 0 else np.r_[switched_on(start.scale), 1.0]
        return maximised(bigger, scale=scale, iterations=iterations, sigma=start.sigma)

    def room_made(self, found: LogEvidence, count: int) -> FloatArray:
        """By which the model's own parameters move where so many columns were added, shape (p,)."""
        return self.directions.full(found.coefficients[:-count])


def amplitude_prior(candidate: Candidate, scales: Mapping[str, float]) -> tuple[float, float]:
    """Prior mean and precision of a trace's coefficient."""
    law = type(candidate.effect)
    if candidate.from_data or law.nonlinear:
        return 1.0, 1 / OFF_THRESHOLD**2
    return 0.0, (candidate.strength / typical_strength(law, scales)) ** 2
