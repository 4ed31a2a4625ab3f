"""How well the data know a parameter at which a law jumps, and no derivative tells it: the cost to both sides."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from testbench.fitting.evidence.evidence import NormalEquations
from testbench.knit.effect import FloatArray

Cost = Callable[[FloatArray], float]
STEPS = 1e-4 * 4.0 ** np.arange(8)  # in the fit's coordinate: from far below a sample of the grid to a factor of five
LEAST = 1e-9  # width where the model is not finite at the nearest point, so that no cost is known there
WORSE = 0.5  # nats by which the cost rises one standard deviation away from its least


def beside(x: FloatArray, index: int) -> FloatArray:
    """The points to both sides of one parameter, shape (2, steps, p)."""
    return x + np.multiply.outer(np.vstack((-STEPS, STEPS)), np.eye(len(x))[index])


def costs_along(cost_at: Cost, x: FloatArray, index: int) -> FloatArray:
    """The cost at each point `beside` one parameter, shape (2, steps)."""
    return np.array([[cost_at(point) for point in side] for side in beside(x, index)])


def lower_beside(cost_at: Cost, x: FloatArray, index: int, below: float) -> FloatArray | None:
    """The best point `beside` one parameter, if its cost is lower than `below`."""
    costs = costs_along(cost_at, x, index)
    best = costs.argmin()
    return beside(x, index).reshape(-1, len(x))[best] if costs.flat[best] < below else None


def width(costs: FloatArray, here: float) -> float:
    """How far the parameter may go until the cost has risen by `WORSE`: the mean of both sides of `costs_along`."""
    return float(np.mean([_one_side(side - here) for side in costs]))


def _one_side(rise: FloatArray) -> float:
    beyond = np.flatnonzero(rise >= WORSE)
    if not len(beyond):
        return float(STEPS[-1])
    first = int(beyond[0])
    nearer = float(STEPS[first - 1]) if first else 0.0
    return max(float(STEPS[first]) * WORSE / float(rise[first]), nearer, LEAST)


def with_widths(normal: NormalEquations, widths: Mapping[int, float], sigma: Mapping[str, float]) -> NormalEquations:
    """The normal equations with what the widths tell of these coefficients, whose own columns are zero."""
    first, information = next(iter(normal.information(sigma).items()))
    gram = normal.products[first].copy()
    for index, known in widths.items():
        gram[index + 1, index + 1] = known**-2.0 / information
    return replace(normal, products={**normal.products, first: gram})
