"""A model fitted by maximum evidence, and its log evidence there (Laplace's approximation)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial

import numpy as np
from threadpoolctl import threadpool_limits

from testbench.fitting import constants
from testbench.fitting.downhill import UP, downhill, within
from testbench.fitting.evidence.cost_scan import costs_along, lower_beside, width, with_widths
from testbench.fitting.evidence.evidence import LogEvidence, NormalEquations, maximised, scaled, switched_on
from testbench.fitting.evidence.hypothesis import Hypothesis, laws_still, pinned, rms, tail
from testbench.fitting.evidence.likelihood import Likelihood
from testbench.fitting.evidence.linearised import Linearised
from testbench.fitting.evidence.priors import Priors, priors_of
from testbench.knit.effect import FloatArray
from testbench.knit.model import KnitModel
from testbench.measurements.noise_level import trimmed_rms

ENDINGS = 3  # rounds, at most, in which the scales of the weights, and the noise, come to rest at the end
AGREED = 0.02  # relative change of the noise from one of these to the next, below which they agree
PARTS = (1.0, 0.3)  # shares of a promised step, tried in turn
AT_REST = 0.05  # nats: a search whose step gains less is at rest; along a valley steps gain little


def fitted(
    model: KnitModel,
    likelihood: Likelihood,
    reference: KnitModel,
    like: Hypothesis | None = None,
    iterations: int = constants.ITERATIONS,
    quick: bool = False,
    known_priors: Mapping[str, tuple[float, float]] | None = None,
    free: Callable[[str], bool] = lambda address: True,
    progress: Callable[[str], None] | None = None,
) -> Hypothesis:
    """Levenberg-Marquardt on the posterior; the scales of shapes and noise follow by maximum evidence.

    Parameters
    ----------
    model : KnitModel
        Where the search starts.
    likelihood : Likelihood
    reference : KnitModel
        Base laws are believed to have parameters near those here.
    like : Hypothesis, optional
        A fitted neighbour, from which scales, and sensitivities of what both have, are taken at first.
    iterations : int
        At most; 0 keeps the point and finds the scales.
    quick : bool
        Keep the sensitivities of the shapes' weights as they are there: nearly right, and ten times cheaper.
    known_priors : mapping of address to (mean, standard deviation), optional
        Priors of some parameters, other than those declared.
    free : callable
        Whether to fit the parameter of this address.
    progress : callable, optional
        Called with a short text after each iteration.

    Returns
    -------
    Hypothesis
        The model where the search came to rest, with its log evidence.
    """
    with threadpool_limits(1, "blas"):  # matrices are small: threads wait for each other longer than they work
        known = {**(like.priors.by_address if like else {}), **(known_priors or {})}
        priors = priors_of(model, likelihood.measurement, reference, known, free)
        return _PosteriorFit(model, likelihood, priors, reference, like, quick).run(
            iterations, progress or (lambda _text: None)
        )


class _PosteriorFit(Linearised):
    """One fit on its way.

    Attributes
    ----------
    of_base : ndarray of bool, shape (p,)
        Parameters of the base laws, but for their weights.
    each_step : ndarray of int
        Parameters whose sensitivities are found anew at each step. Those of the weights hardly change.
    when_at_rest : ndarray of int
        Parameters whose sensitivities are found anew where the search comes to rest.
    """

    def __init__(
        self,
        model: KnitModel,
        likelihood: Likelihood,
        priors: Priors,
        reference: KnitModel,
        like: Hypothesis | None,
        quick: bool,
    ) -> None:
        super().__init__(model, likelihood, priors, like)
        self.of_base = self.single & np.array([p.place[0] in reference for p in self.parameters])
        self.each_step = np.array(self.new, int) if quick else np.flatnonzero(self.single)
        self.when_at_rest = self.each_step if quick else np.arange(len(self.x))
        self.is_fresh = self.is_anew or not quick
        laws = model.effects
        self.jumping = [i for i, p in enumerate(self.parameters) if p.place[1] in type(laws[p.place[0]]).jumps]

    def run(self, iterations: int, tell: Callable[[str], None]) -> Hypothesis:
        """To the most probable point; there the laws stay, and the scales of the shapes come to rest."""
        self.search(iterations, tell)
        if self.leapt():
            self.search(iterations, tell)
        # The last step may have taken a parameter off the bound that it was held at.
        at_bound = self.held & ((self.x <= self.parameters.low) | (self.x >= self.parameters.high))
        self.held = at_bound | self.of_base
        for _ in range(ENDINGS):
            if not self.settle():
                break
        self.held = at_bound
        return self.ended()

    def search(self, iterations: int, tell: Callable[[str], None]) -> None:
        """Steps of all parameters until they gain nothing; the scales of the shapes follow them."""
        damping, rested, fresh = 1.0, False, self.is_fresh
        for number in range(1, iterations + 1):
            normal = self.normal()
            evidence = self.maximised(normal, 3, self.scale)
            if rested:
                # What was switched off on the way may be needed where the search has come to.
                again = self.maximised(normal, 12, switched_on(self.scale))
                evidence = max(evidence, again, key=lambda one: one.value)
            self.scale = evidence.scale
            # The linear model promises more than the next step keeps: a promise must make no outlier of a sample.
            left = {c: max(sigma, trimmed_rms(self.columns[c][0])) for c, sigma in evidence.sigma.items()}
            self.sigma = self.likelihood.sigma(left)
            gain, damping = self.move(normal, damping)
            tell(f"iteration {number}: log evidence {evidence.value:.1f}")
            rests = gain is None or gain < AT_REST
            if fresh and (gain is None or (rests and rested)):
                break
            if gain is None:
                self.when_at_rest = np.arange(len(self.x))  # what was taken from a neighbour does not hold here
            rested = fresh = rests
            self.linearise(self.when_at_rest if rests else self.each_step)
        if not fresh:
            self.linearise(self.when_at_rest)

    def leapt(self) -> bool:
        """Move parameters at which a law jumps to where the cost is least; whether that helped."""
        before = self.x
        for index in self.jumping:
            while (better := lower_beside(self.cost_at, self.x, index, self.cost_here() - AT_REST)) is not None:
                self.go(self.parameters.within(better))
                self.linearise([])
        if self.x is before:
            return False
        self.linearise(self.when_at_rest)
        return True

    def widths(self) -> dict[int, float]:
        """How well the data know the parameters at which a law jumps."""
        here = self.cost_here()
        return {index: width(costs_along(self.cost_at, self.x, index), here) for index in self.jumping}

    def maximised(self, normal: NormalEquations, iterations: int, scale: FloatArray) -> LogEvidence:
        """The scales of shapes and noise by maximum evidence; those of the shapes alone where the noise is known."""
        likelihood = self.likelihood
        known = likelihood.floor if likelihood.is_known else None
        return maximised(normal, known, iterations, scale, sigma_is_known=likelihood.is_known)

    def settle(self) -> bool:
        """Find the scales where the parameters of laws stay, and go to the weights that are best there.

        Returns
        -------
        bool
            Whether that lowered the cost; otherwise all is as it was.
        """
        self.stale = True  # with less noise more is seen
        evidence = self.maximised(laws_still(self.normal()), 12, self.scale)
        before = self.scale, self.sigma
        self.scale, self.sigma = evidence.scale, dict(evidence.sigma)
        step = np.where(self.held, 0.0, self.directions.full(evidence.coefficients))
        now = self.cost_here()
        for part in PARTS:
            x = self.parameters.within(self.x + part * step)
            if self.cost_at(x) < now:
                self.go(x)
                self.linearise(np.flatnonzero(~self.held & self.single))
                return True
        self.scale, self.sigma = before
        return False

    def move(self, normal: NormalEquations, damping: float) -> tuple[float | None, float]:
        """One step; what it gains (None: no step gains anything), and the damping of the next."""
        cost = self.cost_here()
        found = downhill(partial(self.step, normal), lambda step: self.cost_at(self.x + step), cost, damping)
        if found is None:
            return None, 1.0
        step, then = self.as_far_as_it_falls(found.step, found.cost)
        self.go(self.x + step)
        return cost - then, max(found.damping / UP, 1e-3)

    def as_far_as_it_falls(self, step: FloatArray, cost: float) -> tuple[FloatArray, float]:
        """A step doubled while the cost falls: a simulation is cheap beside new sensitivities."""
        while True:
            longer = self.parameters.within(self.x + 2 * step) - self.x
            then = self.cost_at(self.x + longer)
            if not then < cost:
                return step, cost
            step, cost = longer, then

    def step(self, normal: NormalEquations, damping: float) -> FloatArray:
        """A step of all parameters, within their bounds."""
        total = normal.over_noise(self.sigma)
        precision = scaled(normal.precision, normal.group, self.scale)
        matrix, gradient = total[1:, 1:] + np.diag(precision), total[1:, 0] + precision * normal.mean
        push, low, high = self.directions.full(gradient), self.parameters.low, self.parameters.high
        self.held = ((self.x <= low) & (push < 0)) | ((self.x >= high) & (push > 0))
        # Damping is by the priors, not by the data, so that laws which resemble each other may trade much in a step.
        # The model is linear in its weights, which need none.
        damped = np.where(normal.group < 0, damping * (precision + 1e-5 * np.diag(matrix)), 0.0)
        matrix += np.diag(damped)
        step = self.directions.full(within(matrix, gradient, *self.room()))
        return self.parameters.within(self.x + step) - self.x

    def room(self) -> tuple[FloatArray, FloatArray]:
        """How far a step may go along each direction: for a parameter to its bounds, for weights anywhere."""
        single, which = self.directions.group < 0, self.directions.own
        low = np.where(single, (self.parameters.low - self.x)[which], -np.inf)
        high = np.where(single, (self.parameters.high - self.x)[which], np.inf)
        return np.minimum(low, 0.0), np.maximum(high, 0.0)

    def ended(self) -> Hypothesis:
        """The point as a hypothesis: parameters of the base laws are held, and what is at its bound."""
        for _ in range(ENDINGS):  # until the weights of outliers and the noise agree
            robust = self.robust(self.columns)
            left = rms(self.columns, robust, self.likelihood.least)
            before, self.sigma = self.sigma, self.likelihood.sigma(left)
            if all(abs(np.log(self.sigma[c] / before[c])) < AGREED for c in before):
                break
        for rows in self.columns.values():
            rows[[index + 1 for index in self.jumping]] = 0.0  # a derivative says nothing there
        normal, held = with_widths(self.all_normal(robust), self.widths(), self.sigma), self.held | self.of_base
        there = maximised(laws_still(pinned(normal, held)), self.sigma, scale=self.scale, iterations=1)
        return Hypothesis(
            model=self.model,
            priors=self.priors,
            normal=normal,
            held=held,
            at_bound=self.held & self.single & ~self.of_base,
            evidence=replace(there, sigma=self.sigma, scale=self.scale),
            tails=self.tails(robust),
            columns=self.columns,
            robust=robust,
            weight=self.likelihood.weight,
        )

    def tails(self, robust: Mapping[str, FloatArray]) -> float:
        """What the tails of the noise say more of outliers than its squares, in nats."""
        if self.likelihood.is_known:
            return 0.0
        share = self.likelihood.share
        return sum(tail(rows[0] / self.sigma[c], robust[c], share) for c, rows in self.columns.items())
