"""How closely one model can imitate another on a motion, when its parameters are let go."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from testbench.fitting.fit import independent_share
from testbench.fitting.measurement import CONDUCTANCE_CHANNEL, FORCE_CHANNEL, Measurement
from testbench.fitting.parameters import FreeParameter, free_parameters, values_of, with_values
from testbench.fitting.sensitivity import sensitivities
from testbench.knit.effect import FloatArray
from testbench.knit.model import KnitModel, SimulationCache

SMALL_GAIN = 1e-3
STRIDE = 2  # of the samples for the normal equations; neighbours say nearly the same


def imitate(
    model: KnitModel,
    measurement: Measurement,
    clean: Mapping[str, FloatArray],
    noise: Mapping[str, float],
    iterations: int,
) -> tuple[KnitModel, dict[str, FloatArray]]:
    """Move the parameters of `model` until it comes as near to `clean` as it can.

    Levenberg-Marquardt as in `testbench.fitting.fit`, but with the known noise for a weight and no outliers to be
    wary of: what is left is the expected misfit of a wrong hypothesis, without any noise in it.

    Parameters
    ----------
    model : KnitModel
        Where it starts; the weak priors are centred there.
    measurement : Measurement
        The motion.
    clean : mapping of channel to ndarray, shape (n,)
        What to imitate.
    noise : mapping of channel to float
        Standard deviations.
    iterations : int

    Returns
    -------
    model : KnitModel
        The closest imitation.
    left : dict of channel to ndarray
        `clean` minus imitation over the noise, at the samples that count, means taken out: force zero and conductance
        gain belong to each mounting.
    """
    problem = _Imitation(model, measurement, clean, noise)
    start = x = values_of(model, problem.parameters)
    left = problem.left(model)
    cost, damping, quiet = problem.reweighted(left, x - start), 1e-3, 0
    matrix, goal = problem.linearised(model, left)
    for _ in range(iterations):
        damped = matrix + np.diag(problem.precision) + damping * np.diag(np.diag(matrix) + problem.precision)
        move = bounded(damped, goal - problem.precision * (x - start), problem.low - x, problem.high - x)
        trial = with_values(model, problem.parameters, x + move)
        left_then = problem.left(trial)
        cost_then = problem.cost(left_then, x + move - start)
        if cost_then < cost:
            quiet = quiet + 1 if cost - cost_then < SMALL_GAIN * cost else 0
            model, x, left, damping = trial, x + move, left_then, max(damping / 10, 1e-8)
            if quiet == 2:
                break
            cost = problem.reweighted(left, x - start)
            matrix, goal = problem.linearised(model, left)
        else:
            damping = max(damping * 10, 1e-3)
            if damping > 1e6:
                break
    return model, left


class _Imitation:
    """Misfit and normal equations."""

    def __init__(
        self,
        model: KnitModel,
        measurement: Measurement,
        clean: Mapping[str, FloatArray],
        noise: Mapping[str, float],
    ) -> None:
        self.measurement, self.clean, self.noise = measurement, clean, noise
        self.parameters: Sequence[FreeParameter] = free_parameters(model, _scales(clean))
        self.low = np.array([p.to_fit(p.low) for p in self.parameters])
        self.high = np.array([p.to_fit(p.high) for p in self.parameters])
        self.precision = np.array([p.width for p in self.parameters]) ** -2.0
        self.cache = SimulationCache()
        self.weights = dict.fromkeys(noise, 1.0)
        self.share = independent_share(measurement)

    def left(self, model: KnitModel) -> dict[str, FloatArray]:
        """What the model does not imitate, in noise units."""
        modelled = self.measurement.modelled(model, self.cache)
        return {c: self._counted(self.clean[c] - modelled[c], c) for c in self.noise}

    def reweighted(self, left: Mapping[str, FloatArray], moved: FloatArray) -> float:
        """Set the weights for what is left now, and return the cost with them.

        While it is far off, a channel weighs by its misfit instead of its noise: else the priors are too weak to keep
        ill-determined parameters from running away on the first steps.
        """
        self.weights = {c: 1 / max(1.0, float(np.mean(values**2))) for c, values in left.items()}
        return self.cost(left, moved)

    def cost(self, left: Mapping[str, FloatArray], moved: FloatArray) -> float:
        """Minus the log-likelihood, autocorrelation allowed for, with the priors."""
        misfit = sum(self.weights[c] * float(np.sum(v**2)) for c, v in left.items()) * self.share
        total = 0.5 * (misfit + float(np.sum(self.precision * moved**2)))
        return total if np.isfinite(total) else np.inf

    def linearised(self, model: KnitModel, left: Mapping[str, FloatArray]) -> tuple[FloatArray, FloatArray]:
        """Normal matrix and right-hand side, priors apart."""
        _, jacobian = sensitivities(model, self.parameters, self.measurement, self.cache)
        count = len(self.parameters)
        matrix, goal = np.zeros((count, count)), np.zeros(count)
        for channel, gap in left.items():
            columns = self._counted(jacobian[channel], channel)[:, ::STRIDE]
            weight = self.weights[channel] * STRIDE * self.share
            matrix += columns @ columns.T * weight
            goal += columns @ gap[::STRIDE] * weight
        return matrix, goal

    def _counted(self, values: FloatArray, channel: str) -> FloatArray:
        picked = values[..., self.measurement.counts] / self.noise[channel]
        return picked - picked.mean(axis=-1, keepdims=True)


def _scales(clean: Mapping[str, FloatArray]) -> dict[str, float]:
    """Typical size of a correction by unit, as `testbench.fitting.fit.shape_scales` takes it from recordings."""
    scales = {"1": 0.3, "1/ks": 0.1, "N": 1.0}
    for channel, unit, least in ((FORCE_CHANNEL, "N", 1e-6), (CONDUCTANCE_CHANNEL, "1", 0.02)):
        if channel in clean:
            scales[unit] = max(0.1 * float(np.ptp(clean[channel])), least)
    return scales


def bounded(matrix: FloatArray, goal: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """Solve ``matrix x = goal`` with ``low <= x <= high``: what leaves is put on its bound, the rest solved.

    Parameters
    ----------
    matrix : ndarray, shape (p, p)
        Positive definite.
    goal, low, high : ndarray, shape (p,)
    """
    x = np.zeros(len(goal))
    free = np.ones(len(goal), bool)
    while free.any():
        rest = goal[free] - matrix[np.ix_(free, ~free)] @ x[~free]
        x[free] = np.linalg.solve(matrix[np.ix_(free, free)], rest)
        out = free & ((x < low) | (x > high))
        if not out.any():
            break
        x[out] = np.clip(x[out], low[out], high[out])
        free &= ~out
    return x
