"""How strong a hidden effect is: the part of it that the world's own base laws cannot absorb.

Definition
----------
Let ``y(a)`` be the two noiseless channels of the calibration recording with the effect at magnitude `a`, each
divided by its noise floor, and ``y(0)`` the same without it. `J` are the derivatives of ``y(0)`` with respect to
every parameter of the base laws (found numerically). Then

    strength(a) = RMS( (I - Q Q^T) (y(a) - y(0)) ),   Q an orthonormal basis of the columns of J,

taken over all samples of both channels together. It is what a least-squares refit of the *true* base laws would
leave, to first order, in units of the noise floor. An effect on one channel alone of strength 5 stands at
5 sqrt(2) = 7.1 noise floors in that channel.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from gcode.support.arrays import FloatArray
from testbench.worlds.base import BaseWorld

THIN = 2  # the projection is done on every second sample: the effects are slow against the sampling
TOLERANCE = 0.02

Simulate = Callable[[BaseWorld], FloatArray]


def basis(base: BaseWorld, simulate: Simulate) -> FloatArray:
    """Orthonormal basis of what the base laws can absorb, shape (samples, rank)."""
    y0 = simulate(base)
    columns = []
    for name, law in base.laws().items():
        for parameter, value in law.parameters.items():
            step = 1e-4 * (abs(value) if value != 0 else 1.0)
            columns.append((simulate(base.varied(name, parameter, value + step)) - y0) / step)
    jacobian = np.stack(columns, axis=1)
    size = np.linalg.norm(jacobian, axis=0)
    jacobian = jacobian[:, size > 0] / size[size > 0]
    # eigenvectors of the small Gram matrix: ten times quicker than an SVD of the tall one
    values, vectors = np.linalg.eigh(jacobian.T @ jacobian)
    keep = values > 1e-10 * values[-1]
    return jacobian @ (vectors[:, keep] / np.sqrt(values[keep]))


def unabsorbed(deviation: FloatArray, q: FloatArray) -> FloatArray:
    """`deviation` without what the basis `q` explains."""
    return deviation - q @ (q.T @ deviation)


def rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def magnitude_for(target: float, most: float, strength_of: Callable[[float], float]) -> float:
    """Magnitude whose strength is `target`.

    Starts small, grows geometrically until the target is passed or `most` is reached, then closes in by the
    secant in logarithms. If `most` is not enough, `most` (or the strongest seen below it) is returned.
    """
    low, reached_low = most * 1e-3, strength_of(most * 1e-3)
    while reached_low > target and low > most * 1e-9:
        low *= 0.1
        reached_low = strength_of(low)
    high, reached_high = low, reached_low
    best = (low, reached_low)
    while reached_high < target and high < most:
        low, reached_low = high, reached_high
        factor = np.clip(1.1 * target / max(reached_high, 1e-12), 1.3, 30)
        high = min(high * factor, most)
        reached_high = strength_of(high)
        best = max(best, (high, reached_high), key=lambda pair: pair[1])
    if reached_high < target:
        return best[0]
    return _close_in(target, (low, reached_low), (high, reached_high), strength_of)


def _close_in(
    target: float, low: tuple[float, float], high: tuple[float, float], strength_of: Callable[[float], float]
) -> float:
    best = min(low, high, key=lambda pair: abs(pair[1] - target))
    for k in range(12):
        if abs(best[1] / target - 1) < TOLERANCE:
            break
        slope = np.log(high[1] / max(low[1], 1e-12)) / np.log(high[0] / low[0])
        share = np.log(target / max(low[1], 1e-12)) / max(slope, 1e-6) / np.log(high[0] / low[0])
        # every third step is a bisection, so that a kinked law cannot stall the secant
        share = 0.5 if k % 3 == 2 else float(np.clip(share, 0.02, 0.98))
        middle = low[0] * (high[0] / low[0]) ** share
        found = (middle, strength_of(middle))
        low, high = (found, high) if found[1] < target else (low, found)
        best = min(best, found, key=lambda pair: abs(pair[1] - target))
    return best[0]
