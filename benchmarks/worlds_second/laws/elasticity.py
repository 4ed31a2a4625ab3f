"""Elastic force over relative strain `e` (0..1). The chain divides by the value at 1, so scales are free."""

from __future__ import annotations

from typing import Any

import numpy as np

from worlds_second.draws import lin, log
from worlds_second.laws.registry import law


@law("elasticity", toe=lin(0.15, 0.55), toe_slope=lin(0.08, 0.4), width=lin(0.03, 0.12))
def toe_linear(e: Any, toe: float, toe_slope: float, width: float) -> Any:
    """Crimp is drawn out along a soft toe, then the yarns pull: two slopes with a rounded corner."""
    corner = width * (np.logaddexp(0.0, (e - toe) / width) - np.logaddexp(0.0, -toe / width))
    return toe_slope * e + (1.0 - toe_slope) * corner


@law("elasticity", quadratic=lin(-0.8, 1.0), cubic_term=lin(0.4, 2.0))
def cubic(e: Any, quadratic: float, cubic_term: float) -> Any:
    """A polynomial of third degree."""
    return e + quadratic * e**2 + cubic_term * e**3


@law("elasticity", exponent=lin(0.8, 3.5))
def fung(e: Any, exponent: float) -> Any:
    """Exponential stiffening of soft tissue (Fung 1967)."""
    return np.expm1(exponent * e)


@law("elasticity", step=lin(0.15, 0.7), width=lin(0.1, 0.35))
def tanh_linear(e: Any, step: float, width: float) -> Any:
    """Stiff at first while friction holds the loops, then a constant slope."""
    return step * np.tanh(e / width) + e


@law("elasticity", stretch=lin(0.4, 1.3), alpha=lin(1.6, 5.0))
def ogden(e: Any, stretch: float, alpha: float) -> Any:
    """One term of Ogden (1972) in uniaxial tension, incompressible."""
    length = 1.0 + stretch * e
    return length ** (alpha - 1.0) - length ** (-0.5 * alpha - 1.0)


@law("elasticity", knee=lin(0.3, 0.7), second_slope=log(0.35, 4.0), width=lin(0.04, 0.15))
def smooth_bilinear(e: Any, knee: float, second_slope: float, width: float) -> Any:
    """Two straight lines joined by a hyperbola, stiffer or softer after the knee."""
    bend = e - knee + np.sqrt((e - knee) ** 2 + width**2) - (np.sqrt(knee**2 + width**2) - knee)
    return e + 0.5 * (second_slope - 1.0) * bend


@law("elasticity", lock=lin(1.25, 2.2))
def limited_chain(e: Any, lock: float) -> Any:
    """Chains of finite length that grow stiff towards the strain where they are straight."""
    share = np.minimum(e / lock, 0.98)
    return e * (3.0 - share**2) / (1.0 - share**2)
