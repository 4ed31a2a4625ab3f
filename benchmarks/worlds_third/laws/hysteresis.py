"""Friction of the force: loops over strain at any speed. Each gives a state within about -1 and 1."""

from __future__ import annotations

import numpy as np

from worlds_third import kernels
from worlds_third.laws.law import Law
from worlds_third.signals import Array

ELEMENTS = 10


def maxwell_slip(x: Array, step_s: Array, reach: float, spread: float) -> Array:
    """Generalised Maxwell-slip: springs that begin to slide one after the other, log-normally distributed."""
    steps = np.linspace(-1.6, 1.6, ELEMENTS)
    weights = np.exp(-0.5 * steps**2)
    return kernels.slip_elements(x, reach * np.exp(spread * steps), weights / weights.sum())


def lugre(x: Array, step_s: Array, reach: float, excess: float, stribeck: float) -> Array:
    """Bristles (Canudas de Wit and others, 1995), a little stronger in slow motion."""
    return kernels.bristles(x, step_s, reach, excess, stribeck)


def bouc_wen(x: Array, step_s: Array, reach: float, beta: float, power: float) -> Array:
    """Bouc (1967) and Wen (1976)."""
    return kernels.bouc_wen(x, reach, beta, power)


def endochronic(x: Array, step_s: Array, reach: float, ratio: float, share: float) -> Array:
    """Valanis (1971): stresses that fade with the length of the path; two kernels."""
    fast = kernels.direction(x, reach)
    return share * fast + (1.0 - share) * kernels.direction(x, reach * ratio)


def masing(x: Array, step_s: Array, reach: float) -> Array:
    """Closed loops by Masing's rule on a hyperbolic backbone; minor loops are wiped out by larger ones."""
    return kernels.masing(x, reach)


HYSTERESIS = {
    "maxwell_slip": Law(maxwell_slip, {"reach": (0.03, 0.1), "spread": (0.4, 1.0)}),
    "lugre": Law(lugre, {"reach": (0.02, 0.09), "excess": (0.0, 0.06), "stribeck": (0.01, 0.05)}),
    "bouc_wen": Law(bouc_wen, {"reach": (0.03, 0.12), "beta": (0.5, 0.9), "power": (0.8, 2.5)}),
    "endochronic": Law(endochronic, {"reach": (0.015, 0.06), "ratio": (3.0, 8.0), "share": (0.4, 0.8)}),
    "masing": Law(masing, {"reach": (0.02, 0.1)}),
}
