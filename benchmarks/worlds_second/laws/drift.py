"""Drift of ln G after switching on, over the time in seconds, and where it acts."""

from __future__ import annotations

import numpy as np

from worlds_second.draws import log, pick
from worlds_second.kernels import Array
from worlds_second.laws.registry import law

SIGN = pick(-1.0, 1.0)


@law("drift", per_decade=log(0.002, 0.03), onset_s=log(2.0, 60.0), sign=SIGN)
def logarithmic(t: Array, per_decade: float, onset_s: float, sign: float) -> Array:
    """The same amount in each decade of time."""
    return sign * per_decade * np.log10(1.0 + t / onset_s)


@law("drift", after_1000_s=log(0.005, 0.06), exponent=log(0.15, 0.6), sign=SIGN)
def power(t: Array, after_1000_s: float, exponent: float, sign: float) -> Array:
    """On and on, ever more slowly."""
    return sign * after_1000_s * (t / 1000.0 + 1e-6) ** exponent


@law(
    "drift", fast=log(0.002, 0.02), fast_s=log(10.0, 60.0), slow=log(0.005, 0.05), slow_s=log(150.0, 900.0), sign=SIGN
)
def two_exponentials(t: Array, fast: float, fast_s: float, slow: float, slow_s: float, sign: float) -> Array:
    """A quick part and a slow part, both of which come to an end."""
    return -sign * (fast * np.expm1(-t / fast_s) + slow * np.expm1(-t / slow_s))


@law("drift", height=log(0.005, 0.06), time_s=log(40.0, 600.0), sign=SIGN)
def one_exponential(t: Array, height: float, time_s: float, sign: float) -> Array:
    """One approach to an end."""
    return -sign * height * np.expm1(-t / time_s)


@law("drift")
def none(t: Array) -> Array:
    """No drift."""
    return np.zeros_like(t)


@law("drift_place")
def contacts() -> None:
    """Drift acts on the contacts alone, before floats and yarn."""


@law("drift_place")
def whole() -> None:
    """Drift acts on the whole sensor."""
