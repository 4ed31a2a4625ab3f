"""A model fitted by maximum evidence, and its log evidence there (Laplace's approximation)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from threadpoolctl import threadpool_limits

from testbench.fitting import constants
from testbench.fitting.downhill import UP, downhill, within
from testbench.fitting.evidence.directions import Directions
from testbench.fitting.evidence.evidence import LogEvidence, NormalEquations, maximised, opened, scaled
from testbench.fitting.evidence.hypothesis import Hypothesis, laws_still, pinned, rms, tail
from testbench.fitting.evidence.likelihood import Likelihood
from testbench.fitting.evidence.moved import costs_along, lower_beside, width, with_widths
from testbench.fitting.evidence.priors import priors_of
from testbench.fitting.evidence.products import ProductsOfShapes, gram
from testbench.fitting.parameters import HELD
from testbench.fitting.sensitivity import derivatives
from testbench.knit.cache import SimulationCache
from testbench.knit.effect import FloatArray
from testbench.knit.model import KnitModel
from testbench.measurements.noise_level import trimmed_rms

FINAL_WEIGHTS = 3
AGREED = 0.02  # relative change of the noise from one of these to the next, below which they agree
PARTS = (1.0, 0.3)  # shares of a promised step, tried in turn
NARROWEST = 1e3  # largest factor on a group's precision when directions are chosen: a wider prior may show them
AT_REST = 0.05  # nats: a search whose step gains less is at rest; along a valley steps gain little


def fitted(
    model: KnitModel,
    likelihood: Likelihood,
    reference: KnitModel,
    like: Hypothesis | None = None,
    iterations: int = constants.ITERATIONS,
    quick: bool = False,
    believed: Mapping[str, tuple[float, float]] | None = None,
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
    believed : mapping of address to (mean, standard deviation), optional
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
        problem = _PosteriorFit(model, likelihood, reference, like, quick, believed or {}, free)
        return problem.run(iterations, progress or (lambda _text: None))


class _PosteriorFit:
    """One fit on its way: the point, the sensitivities there, and the scales of noise and weights so far."""

    def __init__(
        self,
        model: KnitModel,
        likelihood: Likelihood,
        reference: KnitModel,
        like: Hypothesis | None,
        quick: bool,
        believed: Mapping[str, tuple[float, float]],
        free: Callable[[str], bool],
    ) -> None:
        self.likelihood, self.cache = likelihood, SimulationCache()
        known = {**(like.priors.believed if like else {}), **believed}
        self.priors = priors_of(model, likelihood.measurement, reference, known, free)
        self.parameters, self.base = self.priors.parameters, frozenset(reference)
        self.model, self.x = model, self.parameters.point_of(model)
        scales = like.scales if like else {}
        self.scale = opened(np.array([scales.get(name, 1.0) for name in self.priors.groups]))
        self.columns = {c: np.zeros((len(self.x) + 1, len(likelihood.rows))) for c in likelihood.measurement.channels}
        place = {p.address: i + 1 for i, p in enumerate(like.priors.parameters)} if like else {}
        new = []
        for index, p in enumerate(self.parameters):
            if like is not None and self.priors.group[index] >= 0 and p.address in place:
                for c, rows in self.columns.items():
                    rows[index + 1] = like.columns[c][place[p.address]] * (likelihood.weight[c] / like.weight[c])
            else:
                new.append(index)
        self.curved = np.array(new) if quick else np.flatnonzero(self.priors.group < 0)
        self.all = self.curved if quick else np.arange(len(self.x))
        moved = like is not None and any(
            "strain" in effect.writes for name, effect in model.effects.items() if name not in like.model
        )
        self.exact = not quick or moved
        self.stale = True
        self.held = np.zeros(len(self.x), bool)  # at a bound that the data push against
        laws = model.effects
        self.jumping = [i for i, p in enumerate(self.parameters) if p.place[1] in type(laws[p.place[0]]).jumps]
        self.linearise(range(len(self.x)) if moved else new)
        left = {c: max(trimmed_rms(rows[0]), likelihood.least[c]) for c, rows in self.columns.items()}
        self.sigma = likelihood.sigma(left)

    def run(self, iterations: int, tell: Callable[[str], None]) -> Hypothesis:
        self.search(iterations, tell)
        if self.leapt():
            self.search(iterations, tell)
        # The last step may have taken a parameter off the bound that it was held at.
        at_bound = self.held & ((self.x <= self.parameters.low) | (self.x >= self.parameters.high))
        own = self.priors.group < 0
        of_base = own & np.array([p.place[0] in self.base for p in self.parameters])
        self.held = at_bound | of_base
        for _ in range(FINAL_WEIGHTS):
            if not self.settle():
                break
        self.held = at_bound
        return self.ended(at_bound | of_base, at_bound & own & ~of_base)

    def search(self, iterations: int, tell: Callable[[str], None]) -> None:
        """Steps of all parameters until they gain nothing; the scales of the shapes follow them."""
        damping, quiet, fresh = 1.0, False, self.exact
        for number in range(1, iterations + 1):
            normal = self.normal()
            evidence = self.maximised(normal, 3, self.scale)
            if quiet:
                # What was switched off on the way may be needed where the search has come to.
                again = self.maximised(normal, 12, opened(self.scale))
                evidence = max(evidence, again, key=lambda one: one.value)
            self.scale = evidence.scale
            # The linear model promises more than the next step keeps: a promise must make no outlier of a sample.
            left = {c: max(sigma, trimmed_rms(self.columns[c][0])) for c, sigma in evidence.sigma.items()}
            self.sigma = self.likelihood.sigma(left)
            gain, damping = self.move(normal, damping)
            tell(f"iteration {number}: log evidence {evidence.value:.1f}")
            if gain is None and fresh:
                break
            if gain is None:
                self.all = np.arange(len(self.x))  # what was taken from a neighbour does not hold here
            # The columns of the shapes' weights hardly change; they are made anew where the search comes to rest.
            rest = gain is None or gain < AT_REST
            if rest and quiet and fresh:
                break
            quiet = rest
            fresh = rest
            self.linearise(self.all if rest else self.curved)
        if not fresh:
            self.linearise(self.all)

    def leapt(self) -> bool:
        """Move parameters at which a law jumps to where the cost is least; whether that helped."""
        before = self.x
        for index in self.jumping:
            while (better := lower_beside(self.cost_at, self.x, index, self.cost_here() - AT_REST)) is not None:
                self.go(self.parameters.within(better))
                self.linearise([])
        if self.x is before:
            return False
        self.linearise(self.all)
        return True

    def widths(self) -> dict[int, float]:
        """How well the data know the parameters at which a law jumps."""
        here = self.cost_here()
        return {index: width(costs_along(self.cost_at, self.x, index), here) for index in self.jumping}

    def ended(self, held: np.ndarray, at_bound: np.ndarray) -> Hypothesis:
        """The point as a hypothesis of which these parameters are held, and these of them by their bounds alone."""
        for _ in range(FINAL_WEIGHTS):  # until the weights of outliers and the noise agree
            robust = self.robust(self.columns)
            left = rms(self.columns, robust, self.likelihood.least)
            before, self.sigma = self.sigma, self.likelihood.sigma(left)
            if all(abs(np.log(self.sigma[c] / before[c])) < AGREED for c in before):
                break
        for rows in self.columns.values():
            rows[[index + 1 for index in self.jumping]] = 0.0  # a derivative says nothing there
        normal = with_widths(self.all_normal(robust), self.widths(), self.sigma)
        there = maximised(laws_still(pinned(normal, held)), self.sigma, scale=self.scale, iterations=1)
        evidence = replace(there, sigma=self.sigma, scale=self.scale)
        tails = self.tails(robust, evidence.sigma)
        weight = self.likelihood.weight
        return Hypothesis(
            self.model, self.priors, normal, held, at_bound, evidence, tails, self.columns, robust, weight
        )

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
                self.linearise(np.flatnonzero(~self.held & (self.priors.group < 0)))
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

    def go(self, x: FloatArray) -> None:
        self.model = self.parameters.model_at(self.model, x)
        self.x = self.parameters.point_of(self.model)

    def cost_at(self, x: FloatArray) -> float:
        return self.cost(self.residual(self.parameters.model_at(self.model, x)), x)

    def cost_here(self) -> float:
        return self.cost({c: rows[0] for c, rows in self.columns.items()}, self.x)

    def residual(self, model: KnitModel) -> dict[str, FloatArray]:
        left = self.likelihood.measurement.residual(model, self.cache)
        return {c: self.likelihood.picked(values, c) for c, values in left.items()}

    def linearise(self, which: Iterable[int]) -> None:
        """Residual and these sensitivities at the present point."""
        measurement, these = self.likelihood.measurement, list(which)
        for c, values in self.residual(self.model).items():
            self.columns[c][0] = values
        for indices, rows in derivatives(self.model, self.parameters, these, measurement, self.cache):
            for c, values in rows.items():
                self.columns[c][np.array(indices) + 1] = self.likelihood.picked(values, c)
        self.refresh(these)

    def refresh(self, which: Sequence[int]) -> None:
        """Bring the rows along the directions up to date; new sensitivities of a shape may open new directions."""
        if any(self.priors.group[index] >= 0 for index in which):
            self.stale = True
        if self.stale:
            return
        own = np.flatnonzero(self.priors.group < 0)
        for c, rows in self.rows.items():
            rows[0] = self.columns[c][0]
            rows[1 : 1 + len(own)] = self.columns[c][own + 1]

    def normal(self) -> NormalEquations:
        """Along the directions that the data see, weighted robustly."""
        if self.stale:
            information = {c: self.likelihood.share / self.sigma[c] ** 2 for c in self.columns}
            narrow = np.minimum(self.scale, NARROWEST)
            self.directions = Directions.seen(self.columns, information, self.priors, narrow)
            self.rows = {c: self.directions.rows(rows) for c, rows in self.columns.items()}
            own = 1 + int(np.sum(self.directions.group < 0))
            self.products = {c: ProductsOfShapes(rows[own:]) for c, rows in self.rows.items()}
            self.stale = False
        robust = self.robust(self.rows)
        products = {c: self.products[c].beside(rows, robust[c]) for c, rows in self.rows.items()}
        # A direction belongs to a whole vector: no weight of it can stay alone.
        held = self.held & (self.priors.group < 0)
        return self.equations(products, *self.directions.priors(*self.believed(held)))

    def robust(self, rows: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
        """Square roots of the Huber weights."""
        z = {c: np.abs(values[0]) / self.sigma[c] for c, values in rows.items()}
        return {c: self.likelihood.robust(one) for c, one in z.items()}

    def believed(self, held: np.ndarray) -> tuple[FloatArray, FloatArray]:
        """Mean and precision of the prior of the step from here; parameters that are held make none."""
        mean = np.where(held, 0.0, self.priors.mean - self.x)
        return mean, np.where(held, HELD, self.priors.precision_at(self.x))

    def all_normal(self, robust: Mapping[str, FloatArray]) -> NormalEquations:
        """The normal equations of all parameters, whatever directions the data see."""
        products = {c: gram(rows, robust[c]) for c, rows in self.columns.items()}
        return self.equations(products, *self.believed(self.held), self.priors.group)

    def equations(
        self, products: Mapping[str, FloatArray], mean: FloatArray, precision: FloatArray, group: np.ndarray
    ) -> NormalEquations:
        likelihood = self.likelihood
        counts, typical = (likelihood.count, likelihood.share, likelihood.least), self.priors.typical
        return NormalEquations(products, *counts, mean, precision, group, typical)

    def step(self, normal: NormalEquations, damping: float) -> FloatArray:
        """A step of all parameters, within their bounds."""
        total = normal.over_noise(self.sigma)
        precision = scaled(normal.precision, normal.group, self.scale)
        matrix, gradient = total[1:, 1:] + np.diag(precision), total[1:, 0] + precision * normal.mean
        push, low, high = self.directions.full(gradient), self.parameters.low, self.parameters.high
        self.held = ((self.x <= low) & (push < 0)) | ((self.x >= high) & (push > 0))
        # Damping is by the priors, not by the data, so that laws which resemble each other may trade much in a step.
        # The model is linear in its weights, which need none.
        own = normal.group < 0
        matrix += np.diag(np.where(own, damping * (precision + 1e-5 * np.diag(matrix)), 0.0))
        step = self.directions.full(within(matrix, gradient, *self.room()))
        return self.parameters.within(self.x + step) - self.x

    def room(self) -> tuple[FloatArray, FloatArray]:
        """How far a step may go along each direction: for a parameter to its bounds, for weights anywhere."""
        own = self.directions.group < 0
        which = self.directions.own
        low = np.where(own, (self.parameters.low - self.x)[which], -np.inf)
        high = np.where(own, (self.parameters.high - self.x)[which], np.inf)
        return np.minimum(low, 0.0), np.maximum(high, 0.0)

    def cost(self, residual: Mapping[str, FloatArray], x: FloatArray) -> float:
        total = float(np.sum(self.priors.cost(x, self.scale)))
        for c, values in residual.items():
            total += float(np.sum(self.likelihood.loss(np.abs(values) / self.sigma[c]))) * self.likelihood.share
        return total if np.isfinite(total) else np.inf

    def tails(self, robust: Mapping[str, FloatArray], sigma: Mapping[str, float]) -> float:
        if self.likelihood.is_known:
            return 0.0
        share = self.likelihood.share
        return sum(tail(rows[0] / sigma[c], robust[c], share) for c, rows in self.columns.items())
