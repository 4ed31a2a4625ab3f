"""Levenberg-Marquardt: the step of a linear model, shortened until the cost falls; and Huber's measure of a misfit.

Levenberg, Q. Appl. Math. 2 (1944) 164; Marquardt, J. SIAM 11 (1963) 431; Huber, Robust Statistics (1981), ch. 7.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve, solve_triangular
from scipy.optimize import lsq_linear

from testbench.knit.effect import FloatArray

HUBER = 3.0  # standard deviations beyond which a sample counts linearly, not squared
UP, MOST_DAMPING = 10.0, 1e8


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
    """

    step: FloatArray
    cost: float
    damping: float


def downhill(
    step: Callable[[float], FloatArray], cost_of: Callable[[FloatArray], float], cost: float, damping: float
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
        The first to try; each further one is `UP` times larger, up to `MOST_DAMPING`.

    Returns
    -------
    Downhill or None
        None where no step lowers the cost.
    """
    while damping <= MOST_DAMPING:
        move = step(damping)
        then = cost_of(move)
        if then < cost:
            return Downhill(move, then, damping)
        damping *= UP
    return None


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
