"""Operators on whole signals of shape (n,): filters, smooth ramps, and what a specimen has been through."""

from __future__ import annotations

from typing import Any

import numpy as np

from worlds_fourth.kernels.followers import follow
from worlds_fourth.kernels.friction import play as play_of
from worlds_fourth.signals import Array


def lowpass(x: Array, time_s: Array, tau_s: float, start: float | None = None) -> Array:
    """First-order filter, exact for an input that is constant between samples, at the mean of both."""
    share = 1 - np.exp(-np.diff(time_s) / tau_s)
    return follow(0.5 * (x[1:] + x[:-1]), share, float(x[0] if start is None else start))


def highpass(x: Array, time_s: Array, tau_s: float) -> Array:
    """What the first-order filter leaves."""
    return x - lowpass(x, time_s, tau_s)


def play(x: Array, half_width: float, start: float) -> Array:
    """Lost motion of one half-width."""
    return play_of(x, np.full(len(x), half_width), start)


def softplus(x: Any) -> Any:
    """Smooth ramp: 0 far below 0, x far above."""
    return np.logaddexp(0, x)


def largest_so_far(x: Array) -> Array:
    """Running maximum."""
    return np.maximum.accumulate(x)


def summed(steps: Array) -> Array:
    """Cumulative sum of n - 1 steps, 0 at first: shape (n,)."""
    return np.r_[0, np.cumsum(steps)]


def travel(strain: Array) -> Array:
    """Way in both directions since the start."""
    return summed(np.abs(np.diff(strain)))
