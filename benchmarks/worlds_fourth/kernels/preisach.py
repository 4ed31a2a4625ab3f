"""Preisach's hysteresis, by turning points that larger turns wipe out."""

from __future__ import annotations

import numpy as np
from numba import njit

from worlds_fourth.signals import Array


@njit(cache=True)
def everett(high: float, low: float, power: float, skew: float) -> float:
    """Weight of all relays that switch up below `high` and down above `low` (Everett, 1955)."""
    d = high - low
    if d <= 0:
        return 0.0
    return d**power * (1 + skew * (high + low) / 2)


@njit(cache=True)
def preisach(x: Array, power: float, skew: float) -> Array:
    """Weight of the relays that are up, all of them down at the start (Mayergoyz, 1986); shape (n,)."""
    out = np.empty(len(x))
    turn, weight = np.zeros(len(x) + 2), np.zeros(len(x) + 2)  # at the turns remembered
    turn[0] = x[0]
    depth, up, before = 1, True, x[0]
    for k in range(len(x)):
        b = x[k]
        if b > before:
            if not up:
                weight[depth] = weight[depth - 1] - everett(turn[depth - 1], before, power, skew)
                turn[depth] = before
                depth, up = depth + 1, True
            while depth >= 3 and b >= turn[depth - 2]:
                depth -= 2
        elif b < before:
            if up:
                weight[depth] = weight[depth - 1] + everett(before, turn[depth - 1], power, skew)
                turn[depth] = before
                depth, up = depth + 1, False
            while depth >= 3 and b <= turn[depth - 2]:
                depth -= 2
            if depth == 2 and b <= turn[0]:
                turn[0], weight[0] = b, 0.0
                depth, up = 1, True
        before = b
        last = turn[depth - 1]
        change = everett(b, last, power, skew) if up else -everett(last, b, power, skew)
        out[k] = weight[depth - 1] + change
    return out
