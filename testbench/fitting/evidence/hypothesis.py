"""A model at the maximum of its posterior, and its log evidence there."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import cho_factor, cho_solve, solve_triangular
from scipy.special import log_ndtr

from testbench.fitting.baseline import SHAPES, without_laws
from testbench.fitting.downhill import huber
from testbench.fitting.evidence.evidence import LogEvidence, NormalEquations, maximised
from testbench.fitting.evidence.likelihood import Likelihood
from testbench.fitting.evidence.priors import Priors
from testbench.fitting.parameters import HELD
from testbench.fitting.sensitivity import sensitivities
from testbench.knit.cache import SimulationCache
from testbench.knit.effect import FloatArray
from testbench.knit.model import KnitModel
from testbench.measurements.noise_level import trimmed_rms

UNSEEN = 0.1  # of the noise: a shape that changes less,
UNDETERMINED = 0.5  # and of whose weights the data determine less than so many, is switched off


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """A model at the maximum of its posterior.

    Attributes
    ----------
    model : KnitModel
    priors : Priors
    normal : NormalEquations
        At `model`; residual and sensitivities.
    held : ndarray of bool, shape (p,)
        Parameters that stay where they are as models are compared: what is at its bound, and those of the base laws,
        which bend less far than their tangents and are covered by their shapes.
    at_bound : ndarray of bool, shape (p,)
        Those of them that only their bounds hold.
    evidence : LogEvidence
    tails : float
        What the tails of the noise say more of outliers than its squares, in nats; in `log_z` they count.
    columns : dict of channel to ndarray, shape (p + 1, k)
        Residual and sensitivities at the samples that count, over their relative noise.
    robust : dict of channel to ndarray, shape (k,)
        Square roots of the Huber weights.
    weight : mapping of channel to ndarray, shape (k,)
        Typical noise over the noise at these samples.
    """

    model: KnitModel
    priors: Priors
    normal: NormalEquations
    held: np.ndarray
    at_bound: np.ndarray
    evidence: LogEvidence
    tails: float
    columns: Mapping[str, FloatArray]
    robust: Mapping[str, FloatArray]
    weight: Mapping[str, FloatArray]

    @property
    def log_z(self) -> float:
        return self.evidence.value + self.tails + self.bounds - self.prior_cost

    @cached_property
    def prior_cost(self) -> float:
        """What the priors say against the point, in nats, beyond the Gaussians in the evidence."""
        held = self.priors.cost(self.vector, self.evidence.scale)
        return float(np.sum(np.where(self.held, held, -self.priors.of_tails(self.vector))))

    @cached_property
    def bounds(self) -> float:
        """What the bounds add to the evidence where the data push a parameter against its own, in nats.

        Each may lie anywhere on the near side: the integral over t > 0 of exp(-slope t - precision t^2 / 2).
        """
        if not self.at_bound.any():
            return 0.0
        total, prior, found = self.normal.over_noise(self.evidence.sigma), self.priors.precision_at(self.vector), 0.0
        for index in np.flatnonzero(self.at_bound):
            beside = np.array(total[1:, 1 + index])
            beside[index] = 0.0
            taken = solve_triangular(self.evidence.cholesky, beside, lower=True)
            told = total[1 + index, 1 + index] - taken @ taken  # by the data, whatever the others are
            precision = prior[index] + max(told, 0.0)
            slope = total[1 + index, 0] + prior[index] * (self.priors.mean[index] - self.vector[index])
            push = abs(slope) / np.sqrt(precision)
            found += 0.5 * push**2 + float(log_ndtr(-push)) + 0.5 * np.log(prior[index] / precision)
        return float(found + np.sum(self.priors.over_gaussians(self.vector)[self.at_bound]))

    @property
    def as_before_data(self) -> Hypothesis:
        """The same with every scale as it is without data."""
        return replace(self, evidence=replace(self.evidence, scale=np.ones_like(self.evidence.scale)))

    @property
    def lean(self) -> Hypothesis:
        """The same without its sensitivities, most of its memory: it is told of, and no fit begins there."""
        return replace(self, columns={}, robust={}, weight={})

    def counts_as(self, likelihood: Likelihood) -> bool:
        """Whether its samples count as in a likelihood."""
        same = self.normal.count == likelihood.count and self.normal.share == likelihood.share
        return same and all(np.array_equal(own, likelihood.weight[c]) for c, own in self.weight.items())

    @property
    def pinned(self) -> NormalEquations:
        """The normal equations by which the model is compared with others."""
        return pinned(self.normal, self.held)

    @property
    def covariance(self) -> FloatArray:
        """Of all parameters, shape (p, p): those of the base laws stay where they are only as models are compared.

        What is at a bound moves no other; its own variance is that on the near side, as if there were no bound.
        """
        found = self._covariance(self.normal)
        held = np.flatnonzero(self.normal.precision == HELD)
        if len(held):
            precision = self.normal.precision.copy()
            precision[held] = self.priors.precision_at(self.vector)[held]
            free = self._covariance(replace(self.normal, precision=precision))
            found[held, held] = free[held, held]
        return found

    def _covariance(self, normal: NormalEquations) -> FloatArray:
        return maximised(normal, self.evidence.sigma, scale=self.evidence.scale, iterations=1).covariance

    @property
    def weighted(self) -> dict[str, FloatArray]:
        """`columns`, weighted robustly."""
        return {c: rows * self.robust[c] for c, rows in self.columns.items()}

    @property
    def vector(self) -> FloatArray:
        """The point in the fit's coordinates, shape (p,)."""
        return self.priors.parameters.point_of(self.model)

    @property
    def model_in_use(self) -> KnitModel:
        """Without the shapes that the evidence has switched off."""
        return without_laws(self.model, [name for name in self.model if name in SHAPES and self.idle(name)])

    def idle(self, name: str) -> bool:
        """Whether the evidence has switched a shape off: no weight of it is determined, none changes anything."""
        mine = [i for i, p in enumerate(self.priors.parameters) if p.place[0] == name]
        weights = [i for i in mine if self.priors.group[i] >= 0]
        if not weights:
            return False
        shrunk = self.priors.scaled(self.evidence.scale)[weights] * np.diag(self.evidence.covariance)[weights]
        held = self.vector[mine]
        changed = {c: held @ rows[np.array(mine) + 1] for c, rows in self.columns.items()}
        below = all(np.sqrt(np.mean(v**2)) < UNSEEN * self.evidence.sigma[c] for c, v in changed.items())
        return below and float(np.sum(1 - shrunk)) < UNDETERMINED

    @property
    def scales(self) -> dict[str, float]:
        """Factor on the precision of each group of weights."""
        return dict(zip(self.priors.groups, self.evidence.scale, strict=True))


def under(h: Hypothesis, likelihood: Likelihood) -> Hypothesis:
    """The same point judged with samples that count otherwise; the linear model finds the new maximum."""
    normal = replace(h.normal, count=likelihood.count, share=likelihood.share)
    # A shape that only fits what no law is asked to reach is switched off.
    left = rms(h.columns, h.robust, normal.least)
    least = {c: max(sigma, likelihood.misfit[c]) for c, sigma in left.items()}
    known = replace(laws_still(pinned(normal, h.held)), least=least)
    evidence = maximised(known, scale=h.evidence.scale, iterations=15)
    tails = sum(tail(rows[0] / evidence.sigma[c], h.robust[c], likelihood.share) for c, rows in h.columns.items())
    return replace(h, normal=normal, evidence=evidence, tails=tails)


def own_part(h: Hypothesis, name: str, likelihood: Likelihood) -> tuple[dict[str, float], dict[str, float]]:
    """What an effect of a model changes as far as the rest of the model could not do it, and all that it changes.

    The parameters of the base laws are asked for all that they can, the shapes for what is believed of them here:
    those that are switched off do nothing. Both are standard deviations over the relative noise of the samples that
    count, per channel, in N and ln S.
    """
    measurement, bare = likelihood.measurement, h.model.without(name)
    base = [p for p in itertools.compress(h.priors.parameters, h.held) if p.place[0] in bare]
    without, columns = sensitivities(bare, base, measurement, SimulationCache())
    weights = np.flatnonzero([p.place[0] in SHAPES for p in h.priors.parameters])
    per_prior_sd = np.sqrt(h.priors.scaled(h.evidence.scale)[weights])
    own, whole = {}, {}
    for channel, here in measurement.modelled(h.model).items():
        change = likelihood.picked(here - without[channel], channel)
        laws = likelihood.picked(columns[channel], channel)
        shapes = h.columns[channel][weights + 1]
        noise = h.evidence.sigma[channel] / np.sqrt(likelihood.share)
        own[channel] = trimmed_rms(change - imitated(change, laws, shapes, noise * per_prior_sd))
        whole[channel] = trimmed_rms(change - np.median(change))
    return own, whole


def imitated(change: FloatArray, laws: FloatArray, shapes: FloatArray, noise_over_prior: FloatArray) -> FloatArray:
    """A change as far as it can be followed, shape (k,): by any step of `laws`, by likely weights of `shapes`.

    Parameters
    ----------
    laws, shapes : ndarray, shape (p, k) and (q, k)
        Sensitivities.
    noise_over_prior : ndarray, shape (q,)
        Noise of a sample over the standard deviation that is believed of a weight.
    """
    laws, answers = laws[laws.any(axis=1)], shapes.any(axis=1)  # those of the other channel say nothing here
    laws = laws / np.sqrt(np.mean(laws**2, axis=1, keepdims=True))
    left = np.vstack((change, laws))
    if answers.any():
        weights = shapes[answers] / noise_over_prior[answers, None]
        factor = cho_factor(np.eye(len(weights)) + weights @ weights.T)
        left = left - cho_solve(factor, weights @ left.T).T @ weights  # what likely weights do not follow
    steps = np.linalg.lstsq(left[1:] @ laws.T, left[1:] @ change, rcond=1e-12)[0]
    return change - (left[0] - steps @ left[1:])


def tail(z: FloatArray, robust: FloatArray, share: float) -> float:
    """What a Huber density says more of outliers than the weighted squares in ln Z."""
    z = np.abs(z)
    return -float(np.sum(huber(z) - 0.5 * (robust * z) ** 2)) * share


def pinned(normal: NormalEquations, held: np.ndarray) -> NormalEquations:
    """The same with some coefficients kept where they are."""
    mean, precision = np.where(held, 0.0, normal.mean), np.where(held, HELD, normal.precision)
    return replace(normal, mean=mean, precision=precision)


def laws_still(normal: NormalEquations) -> NormalEquations:
    """The same without further steps of the parameters of laws, whose search has ended.

    Where a law jumps, the linear model promises steps that no search can find.
    """
    return replace(normal, still=np.flatnonzero(normal.group < 0))


def rms(
    columns: Mapping[str, FloatArray], robust: Mapping[str, FloatArray], least: Mapping[str, float]
) -> dict[str, float]:
    """Noise that the point itself leaves, not a step not taken; `columns` and `robust` as in `Hypothesis`."""
    left = {c: float(np.mean((rows[0] * robust[c]) ** 2)) ** 0.5 for c, rows in columns.items()}
    return {c: max(one, least[c]) for c, one in left.items()}
