"""A model about one point of its parameters: residual, sensitivities and normal equations there, and the cost."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from testbench.fitting.evidence.directions import Directions
from testbench.fitting.evidence.evidence import NormalEquations, switched_on
from testbench.fitting.evidence.hypothesis import Hypothesis
from testbench.fitting.evidence.likelihood import Likelihood
from testbench.fitting.evidence.priors import Priors
from testbench.fitting.evidence.products import ProductsOfShapes, gram
from testbench.fitting.parameters import HELD
from testbench.fitting.sensitivity import derivatives
from testbench.knit.cache import SimulationCache
from testbench.knit.effect import FloatArray
from testbench.knit.model import KnitModel
from testbench.measurements.noise_level import trimmed_rms

NARROWEST = 1e3  # largest factor on a group's precision when directions are chosen: a wider prior may show them


class Linearised:
    """A model at a point that moves; what is known of its surroundings is kept up to date there.

    Parameters
    ----------
    like : Hypothesis, optional
        A fitted neighbour, from which the scales of groups, and the sensitivities of weights, are taken at first.

    Attributes
    ----------
    x : ndarray, shape (p,)
        The point, in the fit's coordinates; `model` is the model there.
    single : ndarray of bool, shape (p,)
        Parameters that are no weights of a vector.
    new : list of int
        Those whose sensitivities were not taken from the neighbour.
    is_anew : bool
        Whether all were found anew: another law changes the strain, and the neighbour's do not hold here.
    columns : dict of channel to ndarray, shape (p + 1, k)
        As in `Hypothesis`.
    scale, sigma
        So far: factor on the precision of each group; standard deviation of the noise by channel.
    held : ndarray of bool, shape (p,)
        Parameters that stay where they are: at a bound that the data push against.
    """

    def __init__(self, model: KnitModel, likelihood: Likelihood, priors: Priors, like: Hypothesis | None) -> None:
        self.likelihood, self.priors, self.parameters = likelihood, priors, priors.parameters
        self.cache = SimulationCache()
        self.model, self.x = model, self.parameters.point_of(model)
        self.single, self.held = priors.group < 0, np.zeros(len(self.x), bool)
        scales = like.scales if like else {}
        self.scale = switched_on(np.array([scales.get(name, 1.0) for name in priors.groups]))
        self.columns = {c: np.zeros((len(self.x) + 1, len(likelihood.rows))) for c in likelihood.measurement.channels}
        self.new = self.taken_over(like) if like else list(range(len(self.x)))
        self.stale = True  # whether the directions must be found anew
        self.is_anew = like is None or any("strain" in model[name].writes for name in model if name not in like.model)
        self.linearise(range(len(self.x)) if self.is_anew else self.new)
        left = {c: max(trimmed_rms(rows[0]), likelihood.least[c]) for c, rows in self.columns.items()}
        self.sigma = likelihood.sigma(left)

    def taken_over(self, like: Hypothesis) -> list[int]:
        """Take the sensitivities of weights from a neighbour; which parameters it has none of."""
        place = {p.address: i + 1 for i, p in enumerate(like.priors.parameters)}
        new = []
        for index, p in enumerate(self.parameters):
            if self.single[index] or p.address not in place:
                new.append(index)
                continue
            for c, rows in self.columns.items():
                rows[index + 1] = like.columns[c][place[p.address]] * (self.likelihood.weight[c] / like.weight[c])
        return new

    def go(self, x: FloatArray) -> None:
        """Move to a point, or to the nearest one within the bounds; `linearise` brings the rest up to date."""
        self.model = self.parameters.model_at(self.model, x)
        self.x = self.parameters.point_of(self.model)

    def cost_at(self, x: FloatArray) -> float:
        """Minus the log posterior at a point, in nats, with the scales and the noise so far."""
        return self._cost(self.residual(self.parameters.model_at(self.model, x)), x)

    def cost_here(self) -> float:
        return self._cost({c: rows[0] for c, rows in self.columns.items()}, self.x)

    def _cost(self, residual: Mapping[str, FloatArray], x: FloatArray) -> float:
        total = float(np.sum(self.priors.cost(x, self.scale)))
        for c, values in residual.items():
            total += float(np.sum(self.likelihood.loss(np.abs(values) / self.sigma[c]))) * self.likelihood.share
        return total if np.isfinite(total) else np.inf

    def residual(self, model: KnitModel) -> dict[str, FloatArray]:
        """At the samples that count, over their relative noise, per channel, shape (k,)."""
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
        # New sensitivities of a shape may open new directions.
        self.stale = self.stale or not self.single[these].all()
        if not self.stale:
            self._refresh_rows()

    def _refresh_rows(self) -> None:
        """Bring the residual and the single parameters up to date in the rows along the directions."""
        single = np.flatnonzero(self.single)
        for c, rows in self.rows.items():
            rows[0] = self.columns[c][0]
            rows[1 : 1 + len(single)] = self.columns[c][single + 1]

    def normal(self) -> NormalEquations:
        """Along the directions that the data see, weighted robustly."""
        if self.stale:
            information = {c: self.likelihood.share / self.sigma[c] ** 2 for c in self.columns}
            narrow = np.minimum(self.scale, NARROWEST)
            self.directions = Directions.seen(self.columns, information, self.priors, narrow)
            self.rows = {c: self.directions.rows(rows) for c, rows in self.columns.items()}
            first = 1 + int(np.sum(self.single))
            self.products = {c: ProductsOfShapes(rows[first:]) for c, rows in self.rows.items()}
            self.stale = False
        robust = self.robust(self.rows)
        products = {c: self.products[c].beside(rows, robust[c]) for c, rows in self.rows.items()}
        # A direction belongs to a whole vector: no weight of it can stay alone.
        held = self.held & self.single
        return self._equations(products, *self.directions.priors(*self._prior_of_step(held)))

    def robust(self, rows: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
        """Square roots of the Huber weights."""
        z = {c: np.abs(values[0]) / self.sigma[c] for c, values in rows.items()}
        return {c: self.likelihood.robust(one) for c, one in z.items()}

    def _prior_of_step(self, held: np.ndarray) -> tuple[FloatArray, FloatArray]:
        """Mean and precision of the prior of the step from here; parameters that are held make none."""
        mean = np.where(held, 0.0, self.priors.mean - self.x)
        return mean, np.where(held, HELD, self.priors.precision_at(self.x))

    def all_normal(self, robust: Mapping[str, FloatArray]) -> NormalEquations:
        """The normal equations of all parameters, whatever directions the data see."""
        products = {c: gram(rows, robust[c]) for c, rows in self.columns.items()}
        return self._equations(products, *self._prior_of_step(self.held), self.priors.group)

    def _equations(
        self, products: Mapping[str, FloatArray], mean: FloatArray, precision: FloatArray, group: np.ndarray
    ) -> NormalEquations:
        likelihood = self.likelihood
        counts, typical_groups = (likelihood.count, likelihood.share, likelihood.least), self.priors.typical_groups
        return NormalEquations(products, *counts, mean, precision, group, typical_groups)
