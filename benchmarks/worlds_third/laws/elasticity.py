"""Elastic force over strain: 0 at rest, 1 at the end of the stroke, never falling.

Each takes the strain over the stroke and the strain at its end (dimensionless), as stretch matters to rubber.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from worlds_third.laws.law import Law
from worlds_third.signals import Array

SLACK = 0.02  # stiffness of what hangs limp, over the mean stiffness
TAIL = 1.15  # strain up to which a law is evaluated; beyond, its tangent goes on (a slip cannot lead there)


def _scaled(curve: Callable[[Array], Array]) -> Callable[[Array], Array]:
    """Scale to 1 at the end, and go on as straight lines outside the stroke."""
    edges = np.array([0.0, 1.0, TAIL - 1e-4, TAIL])
    at = curve(edges)
    top, slope = at[1] - at[0], (at[3] - at[2]) / 1e-4

    def scaled(x: Array) -> Array:
        inside = curve(np.clip(x, 0.0, TAIL)) - at[0]
        return (inside + slope * np.maximum(x - TAIL, 0.0)) / top + SLACK * np.minimum(x, 0.0)

    return scaled


def _softplus(x: Array, width: float) -> Array:
    return width * np.logaddexp(0.0, x / width)


def gent(x: Array, full: float, margin: float) -> Array:
    """Gent (1996): rubber whose chains end at a limit of the first invariant, `margin` beyond the stroke's."""

    def invariant(stretch: Array | float) -> Array | float:
        return stretch**2 + 2.0 / stretch - 3.0

    limit = margin * float(invariant(1.0 + full * TAIL))

    def curve(y: Array) -> Array:
        stretch = 1.0 + full * y
        return (stretch - stretch**-2.0) / (1.0 - invariant(stretch) / limit)

    return _scaled(curve)(x)


def arruda_boyce(x: Array, full: float, links: float) -> Array:
    """Eight chains (Arruda and Boyce, 1993), Padé inverse Langevin; `links`: locking over largest stretch."""
    chain_full = np.sqrt(((1 + full * TAIL) ** 2 + 2 / (1 + full * TAIL)) / 3)
    locking = chain_full * links

    def curve(y: Array) -> Array:
        stretch = 1.0 + full * y
        chain = np.sqrt((stretch**2 + 2.0 / stretch) / 3.0)
        share = chain / locking
        langevin = share * (3.0 - share**2) / (1.0 - share**2)
        return (stretch - stretch**-2.0) / chain * langevin

    return _scaled(curve)(x)


def three_branches(
    x: Array, full: float, bending_end: float, tension_start: float, straighten: float, tension: float, width: float
) -> Array:
    """Loops bend, then straighten, then the yarn itself is pulled: three slopes with rounded knees."""

    def curve(y: Array) -> Array:
        knees = straighten * _softplus(y - bending_end, width) + tension * _softplus(y - tension_start, width)
        return y + knees

    return _scaled(curve)(x)


def power_with_slack(x: Array, full: float, slack: float, exponent: float, softness: float) -> Array:
    """Nothing but a trace until the slack is out, then a power of what is left."""
    return _scaled(lambda y: _softplus(y - slack, softness) ** exponent + 0.05 * y)(x)


def crimp_exchange(x: Array, full: float, angle_rad: float, reserve: float) -> Array:
    """Crimped legs that straighten about hinges with bending springs: ever stiffer as they come into line."""
    sine = np.sin(angle_rad)

    def curve(y: Array) -> Array:
        angle = np.arcsin(sine + (1.0 - reserve - sine) * y / TAIL)
        return (angle - angle_rad) / np.cos(angle)

    return _scaled(curve)(x)


def recruited_bundle(x: Array, full: float, scale: float, shape: float, initial: float) -> Array:
    """Yarns of many lengths: each pulls as a spring from where its slack ends (lengths of a Weibull law)."""
    shares = (np.arange(16) + 0.5) / 16
    slacks = scale * (-np.log(1 - shares)) ** (1 / shape)
    grid = np.linspace(-0.1, TAIL + 0.1, 500)
    bundle = np.mean([_softplus(grid - slack, 0.03) for slack in slacks], axis=0)
    fine = np.gradient(bundle, grid)  # integrated below: the curve has a continuous slope
    whole = np.concatenate([[0.0], np.cumsum(0.5 * (fine[1:] + fine[:-1]) * np.diff(grid))])
    return _scaled(lambda y: initial * y + _cubic(y, grid, whole))(x)


def _cubic(y: Array, grid: Array, values: Array) -> Array:
    """Cubic Hermite interpolation on an even grid."""
    step = grid[1] - grid[0]
    slopes = np.gradient(values, grid)
    k = np.clip(((y - grid[0]) / step).astype(int), 0, len(grid) - 2)
    s = (y - grid[k]) / step
    left = (1 + 2 * s) * (1 - s) ** 2 * values[k] + s * (1 - s) ** 2 * step * slopes[k]
    return left + s**2 * (3 - 2 * s) * values[k + 1] + s**2 * (s - 1) * step * slopes[k + 1]


ELASTICITY = {
    "gent": Law(gent, {"margin": (1.2, 4.0)}),
    "arruda_boyce": Law(arruda_boyce, {"links": (1.05, 1.6)}),
    "three_branches": Law(
        three_branches,
        {
            "bending_end": (0.1, 0.35),
            "tension_start": (0.5, 0.8),
            "straighten": (0.3, 2.0),
            "tension": (1.0, 6.0),
            "width": (0.04, 0.12),
        },
    ),
    "power_with_slack": Law(
        power_with_slack, {"slack": (-0.1, 0.1), "exponent": (1.1, 2.2), "softness": (0.05, 0.12)}
    ),
    "crimp_exchange": Law(crimp_exchange, {"angle_rad": (0.2, 0.7), "reserve": (0.02, 0.15)}),
    "recruited_bundle": Law(recruited_bundle, {"scale": (0.4, 1.0), "shape": (1.2, 3.0), "initial": (0.1, 0.5)}),
}
