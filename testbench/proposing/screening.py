"""Log evidence of a law to first order: what its trace explains of the residual that no change of the base can."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_solve, cholesky, solve_triangular

from testbench.fitting.evidence.hypothesis import Hypothesis
from testbench.fitting.evidence.likelihood import Likelihood
from testbench.fitting.parameters import shape_scales
from testbench.knit.effect import FloatArray, Stage
from testbench.measurements.responses import FORCE_CHANNEL
from testbench.proposing.laws.law import Law
from testbench.proposing.laws.places import Place
from testbench.proposing.open_chain import OpenChain

MOST_ROWS = 1800  # samples of a channel that the search looks at; a refit looks at all
MOST = 3.0  # typical corrections: what is larger than that is no effect beside a base law, but the base law itself
ABSORBED = 1e-3  # of a trace's squares: a base that can do all but this of a law cannot be told from it
SLIGHT = 1.0  # nats: so little is the same with the noise as it was
IDLE = 1e-3  # share of a direction's variance that the base knows: below, it takes nothing off


@dataclass(frozen=True)
class Part:
    """What a law at one place is scored on: the samples of the channels that it reaches, one channel after the other.

    Attributes
    ----------
    base : ndarray, shape (d, k)
        Directions in which the base may give way.
    residual : ndarray, shape (k,)
        Over the noise as it was.
    squares, least : ndarray, shape (channels,)
        Of the residual; the least that can be expected of it.
    """

    base: FloatArray
    residual: FloatArray
    squares: FloatArray
    least: FloatArray

    def gains(self, changes: FloatArray, explained: FloatArray, count: float) -> FloatArray:
        """Gain in ln Z of laws that take `changes`, shape (m, k), off the residual; the noise of each channel anew.

        The noise of the channels together would hide a law of one of them behind the other, which is noise already.
        """
        left = _squares(self.residual - changes, len(self.squares))
        prior_cost = explained - (self.squares.sum() - left.sum(-1))  # what the base pays for where it goes
        return 0.5 * (count * np.log(self.squares / np.maximum(left, self.least)).sum(-1) + prior_cost)


class Projector:
    """Scores laws to first order beside one fitted model.

    A trace f that is added with an amount a to a model whose other coefficients are free again gains
    ``(f.r)^2 / 2 (f.f - f.J C J'.f + 1/s^2)`` less half the logarithm of what the data know of a; r is the residual,
    J the sensitivities, C their covariance and s the typical amount. That is at the noise as it was. With the noise
    of each channel found anew, the count of its samples times half the logarithm of what its squares fall by takes
    their place; what the base pays for where it goes stays.
    """

    def __init__(self, hypothesis: Hypothesis, likelihood: Likelihood, chain: OpenChain) -> None:
        """Linearise a fitted model, or its base alone.

        Parameters
        ----------
        chain : OpenChain
            Of the fitted model, or of the same without laws whose numbers are sought anew: the base stays where it
            was fitted with them.
        """
        self.hypothesis, self.chain, measurement = hypothesis, chain, likelihood.measurement
        self.channels = list(hypothesis.columns)
        present = np.array([p.place[0] in chain.model for p in hypothesis.priors.parameters])
        left = measurement.residual(chain.model)
        every = max(1, len(likelihood.rows) // MOST_ROWS)
        self.rows = likelihood.rows[::every]
        evidence, base = hypothesis.evidence, []
        self.weight: dict[str, FloatArray] = {}
        for c in self.channels:
            unit = np.sqrt(hypothesis.normal.share * every) / evidence.sigma[c]
            self.weight[c] = (likelihood.weight[c] * hypothesis.robust[c] * unit)[::every]
            columns = np.vstack([likelihood.picked(left[c], c), hypothesis.columns[c][1:][present]])
            base.append((columns * hypothesis.robust[c] * unit)[:, ::every])
        stacked = np.hstack(base)
        # The optimum anew on these rows: of another one the residual would not be free of what the base can do.
        prior = hypothesis.priors.scaled(evidence.scale)[present]
        jacobian = np.where(at_bounds(hypothesis)[present, None], 0.0, stacked[1:])
        half = cholesky(jacobian @ jacobian.T + np.diag(prior), lower=True)
        goal = jacobian @ stacked[0] + prior * hypothesis.normal.mean[present]
        self.residual = stacked[0] - cho_solve((half, True), goal) @ jacobian
        spread = solve_triangular(half, jacobian, lower=True)
        known, directions = np.linalg.eigh(spread @ spread.T)
        kept = known > IDLE
        self.base = directions[:, kept].T @ spread
        scales = shape_scales(measurement)
        self.typical_correction = {c: scales["N" if c == FORCE_CHANNEL else "1"] for c in self.channels}
        self.slopes = {p.name: {c: s[self.rows] for c, s in chain.slopes(p).items()} for p in chain.places}
        self.count = len(self.rows) * every * hypothesis.normal.share
        least = {c: self.count * (likelihood.least[c] / evidence.sigma[c]) ** 2 for c in self.channels}
        self.parts = {place.name: self._part(self.slopes[place.name], least) for place in chain.places}

    def _part(self, slopes: Mapping[str, FloatArray], least: Mapping[str, float]) -> Part:
        """The residual and the directions of the base, on the channels that `slopes` reaches."""
        own = [c for c in self.channels if c in slopes]
        count = len(self.rows)
        at = [self.channels.index(c) for c in own]
        picked = np.concatenate([np.arange(k * count, (k + 1) * count) for k in at])
        residual = self.residual[picked]
        squares = _squares(residual, len(own))
        floors = np.minimum([least[c] for c in own], squares)
        return Part(np.ascontiguousarray(self.base[:, picked]), residual, squares, floors)

    def traces(self, place: Place, z: FloatArray) -> FloatArray:
        """What each `z`, shape (m, rows), changes at a place, over the noise: its channels one after the other."""
        slopes = self.slopes[place.name]
        return np.hstack([z * (slopes[c] * self.weight[c]) for c in self.channels if c in slopes])

    def prior_sds(self, place: Place, z: FloatArray) -> FloatArray:
        """Typical strengths, shape (m,): they change a channel by its typical correction, offsets not counted."""
        sizes = [
            np.std(z * slope, axis=-1) / self.typical_correction[c] for c, slope in self.slopes[place.name].items()
        ]
        return 1 / np.maximum(np.max(sizes, axis=0), 1e-12)

    def scores(self, place: Place, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Gains and strengths, each of shape (m,), of laws with these `z`, shape (m, n), at one place.

        Many at once: what costs is to read the directions of the base from memory.
        """
        picked = z[:, self.rows]
        # What stands still is an offset, which every base has.
        picked = picked - picked.mean(-1, keepdims=True) if place.stage >= Stage.CONTACT else picked
        alive = np.isfinite(picked).all(-1) & picked.any(-1)
        gains, strengths = np.full(len(z), -np.inf), np.zeros(len(z))
        if alive.any():
            gains[alive], strengths[alive] = self._scores(place, picked[alive])
        return gains, strengths

    def _scores(self, place: Place, picked: FloatArray) -> tuple[FloatArray, FloatArray]:
        part, f, sd = self.parts[place.name], self.traces(place, picked), self.prior_sds(place, picked)
        size = np.einsum("ij,ij->i", f, f)
        absorbed = f @ part.base.T
        left = np.maximum(size - np.einsum("ij,ij->i", absorbed, absorbed), ABSORBED * size) + sd**-2
        goal = f @ part.residual
        amount = np.clip(goal / left, -MOST * sd, MOST * sd)
        explained = 2 * goal * amount - left * amount**2
        gain = 0.5 * explained
        good = gain > SLIGHT
        changes = amount[good, None] * (f[good] - absorbed[good] @ part.base)
        gain[good] = part.gains(changes, explained[good], self.count)
        return gain - 0.5 * np.log(left * sd**2), amount

    def of_law(self, law: Law) -> tuple[float, float]:
        """First-order gain in ln Z of a law with the parameters that it has, and the strength that reaches it."""
        (gain,), (strength,) = self.scores(law.place, self.z(law)[None])
        return float(gain), float(strength)

    def z(self, law: Law) -> FloatArray:
        """z of a law on the whole grid, shape (n,)."""
        return law.term.evaluated(self.chain.readable(law.place), law.values, self.chain.measurement.dt_s)

    def law_prior_sd(self, law: Law) -> float:
        """Typical strength of a law."""
        return float(self.prior_sds(law.place, self.z(law)[None, self.rows])[0])


def at_bounds(h: Hypothesis) -> np.ndarray:
    """Parameters that lie at a bound, shape (p,): the base cannot give way there, whatever its tangents promise."""
    return (h.vector <= h.priors.parameters.low) | (h.vector >= h.priors.parameters.high)


def _squares(rows: FloatArray, channels: int) -> FloatArray:
    """Sums of squares of each channel, shape (..., channels), of rows that hold one channel after the other."""
    parts = rows.reshape(*rows.shape[:-1], channels, rows.shape[-1] // channels)
    return np.einsum("...ij,...ij->...i", parts, parts)
