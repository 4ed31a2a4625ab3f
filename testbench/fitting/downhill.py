"""Levenberg-Marquardt: the step of a linear model, shortened until the cost falls; and Huber's measure of a misfit.

Levenberg, Q. Appl. Math. 2 (1944) 164; Marquardt, J. SIAM 11 (1963) 431; Huber, Robust Statistics (1981), ch. 7.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Protocol

import numpy as np

from testbench.knit.effect import FloatArray

HUBER = 3.0  # standard deviations beyond which a sample counts linearly, not squared
FIRST_DAMPING, LEAST_DAMPING, MOST_DAMPING = 1e-3, 1e-8, 1e6
UP, DOWN = 8.0, 5.0


@dataclass(frozen=True)
class Downhill:
    """A step that lowers the cost.

    Attributes
    ----------
    step : ndarray, shape (p,)
    cost : float
        After the step.
    damping : float
        With which it was found.
    tries : int
        Steps tried, this one counted.
    """

    step: FloatArray
    cost: float
    damping: float
    tries: int


def downhill(
    step: Callable[[float], FloatArray],
    cost_of: Callable[[FloatArray], float],
    cost: float,
    damping: float,
    tries: int = 100,
    up: float = UP,
    most: float = MOST_DAMPING,
) -> Downhill | None:
    """Shorten a step until the cost falls.

    Parameters
    ----------
    step : callable
        From a damping to a step, shape (p,).
    cost_of : callable
        From a step to the cost after it.
    cost : float
        Without a step.
    damping : float
        The first to try; each further one is `up` times larger, up to `most`.
    tries : int

    Returns
    -------
    Downhill or None
        None where no step lowers the cost.
    """
    for count in range(1, tries + 1):
        move = step(damping)
        then = cost_of(move)
        if then < cost:
            return Downhill(move, then, damping, count)
        damping *= up
        if damping > most:
            break
    return None


@dataclass(frozen=True)
class Linearised:
    """Normal equations at a point, their priors included, and the cost there."""

    matrix: FloatArray
    gradient: FloatArray
    cost: float


class LeastSquares(Protocol):
    """What a search needs to know of its problem; points have shape (p,)."""

    low: FloatArray
    high: FloatArray

    def cost(self, x: FloatArray) -> float:
        """Cost, by the weights of the last `linearised`."""
        ...

    def linearised(self, x: FloatArray) -> Linearised:
        """Normal equations at `x`, by weights found anew there."""
        ...


def minimised(
    problem: LeastSquares, x: FloatArray, iterations: int, small_gain: float, quiet: int = 1
) -> tuple[FloatArray, Linearised, int]:
    """The point of least cost within the bounds.

    Parameters
    ----------
    problem : LeastSquares
    x : ndarray, shape (p,)
        Where the search starts.
    iterations : int
        Steps tried at most.
    small_gain : float
        Share of the cost; the search ends after `quiet` steps in a row that gain less.

    Returns
    -------
    x : ndarray, shape (p,)
    linearised : Linearised
        There.
    iterations : int
        Steps tried.
    """
    here, damping, used, still = problem.linearised(x), FIRST_DAMPING, 0, 0
    while used < iterations:
        step, cost_of = partial(_projected, problem, here, x), partial(_cost_after, problem, x)
        found = downhill(step, cost_of, here.cost, damping, iterations - used)
        if found is None:
            break
        used += found.tries
        still = still + 1 if here.cost - found.cost < small_gain * here.cost else 0
        x, damping = x + found.step, max(found.damping / DOWN, LEAST_DAMPING)
        here = problem.linearised(x)
        if still == quiet:
            break
    return x, here, used


def _cost_after(problem: LeastSquares, x: FloatArray, step: FloatArray) -> float:
    return problem.cost(x + step)


def _projected(problem: LeastSquares, here: Linearised, x: FloatArray, damping: float) -> FloatArray:
    """Damped step within the bounds; what pushes against one stays there."""
    held = ((x <= problem.low) & (here.gradient < 0)) | ((x >= problem.high) & (here.gradient > 0))
    free = np.flatnonzero(~held)
    matrix = here.matrix[np.ix_(free, free)]
    step = np.zeros_like(x)
    step[free] = np.linalg.solve(matrix + damping * np.diag(np.diag(matrix)), here.gradient[free])
    return np.clip(x + step, problem.low, problem.high) - x


def huber(z: FloatArray) -> FloatArray:
    """Minus the log density of noise with exponential tails, shape of `z`, which is >= 0."""
    return np.where(z < HUBER, 0.5 * z * z, HUBER * (z - 0.5 * HUBER))


def huber_weight(z: FloatArray) -> FloatArray:
    """Weight of a squared residual that does as `huber` does, shape of `z`, which is >= 0."""
    return np.minimum(1.0, HUBER / np.maximum(z, 1e-12))
