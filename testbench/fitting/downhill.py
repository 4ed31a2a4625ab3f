"""Levenberg-Marquardt: the step of a linear model, shortened until the cost falls; and Huber's measure of a misfit.

Levenberg, Q. Appl. Math. 2 (1944) 164; Marquardt, J. SIAM 11 (1963) 431; Huber, Robust Statistics (1981), ch. 7.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Protocol

import numpy as np
from scipy.linalg import cho_factor, cho_solve, solve_triangular
from scipy.optimize import lsq_linear

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
        # A sum may round to beyond a bound.
        x = np.clip(x + found.step, problem.low, problem.high)
        damping = max(found.damping / DOWN, LEAST_DAMPING)
        here = problem.linearised(x)
        if still == quiet:
            break
    return x, here, used


def _cost_after(problem: LeastSquares, x: FloatArray, step: FloatArray) -> float:
    return problem.cost(x + step)


def _projected(problem: LeastSquares, here: Linearised, x: FloatArray, damping: float) -> FloatArray:
    """Damped step within the bounds."""
    damped = here.matrix + damping * np.diag(np.diag(here.matrix))
    return within(damped, here.gradient, problem.low - x, problem.high - x)


def within(matrix: FloatArray, gradient: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """The step d of least d' matrix d / 2 - gradient' d with low <= d <= high, shape (p,).

    A step must not be cut off at a bound afterwards: other parameters would still make up for the part cut off.
    Source: Stark & Parker, Comput. Stat. 10 (1995) 129 (bounded-variable least squares).
    """
    tied = np.flatnonzero(np.isfinite(low) | np.isfinite(high))
    free = np.setdiff1d(np.arange(len(gradient)), tied)
    # What has no bounds is eliminated first: its step follows from that of the others.
    inner = cho_factor(matrix[np.ix_(free, free)]) if len(free) else None
    cross = matrix[np.ix_(free, tied)]
    bare, follow = (cho_solve(inner, part) if inner else part for part in (gradient[free], cross))
    step = np.zeros(len(gradient))
    step[tied] = _in_box(
        matrix[np.ix_(tied, tied)] - cross.T @ follow, gradient[tied] - cross.T @ bare, low[tied], high[tied]
    )
    step[free] = bare - follow @ step[tied]
    return step


def _in_box(matrix: FloatArray, gradient: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    size = np.diag(matrix) ** -0.5
    scaled = matrix * np.outer(size, size)
    step = size * np.linalg.solve(scaled, size * gradient)
    if np.all((step >= low) & (step <= high)):
        return step
    factor = np.linalg.cholesky(scaled)
    goal = solve_triangular(factor, size * gradient, lower=True)
    return size * lsq_linear(factor.T, goal, (low / size, high / size), method="bvls").x


def huber(z: FloatArray) -> FloatArray:
    """Minus the log density of noise with exponential tails, shape of `z`, which is >= 0."""
    return np.where(z < HUBER, 0.5 * z * z, HUBER * (z - 0.5 * HUBER))


def huber_weight(z: FloatArray) -> FloatArray:
    """Weight with which a squared residual has the slope of `huber`, shape of `z`, which is >= 0."""
    return np.minimum(1.0, HUBER / np.maximum(z, 1e-12))
