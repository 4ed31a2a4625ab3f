"""Slip of a specimen in a jaw, in mm, from where the carriage is and how long the specimen is."""

from __future__ import annotations

import numpy as np
from numba import njit

from worlds_fourth.signals import Array


@njit(cache=True)
def slip_in_jumps(position: Array, time_s: Array, length: float, limits: Array, jumps: Array, rest_s: float) -> Array:
    """Jumps by the next of `jumps` where the strain passes the next of `limits`, `rest_s` apart at least."""
    out = np.empty(len(position))
    s, count, last_s = 0.0, 0, -9.0
    for k in range(len(position)):
        strain = (position[k] - s) / (length + s)
        if strain > limits[count] and time_s[k] - last_s > rest_s and count < len(jumps) - 1:
            s += jumps[count]
            count += 1
            last_s = time_s[k]
        out[k] = s
    return out


@njit(cache=True)
def slip_creeping(position: Array, step_s: Array, length: float, first: float, step: float, speeds: Array) -> Array:
    """Slips at a speed that a table gives over the strain, from `first` in steps of `step`."""
    out = np.empty(len(position))
    s = 0.0
    for k in range(len(position)):
        place = int(((position[k] - s) / (length + s) - first) / step)
        s += step_s[k] * speeds[min(max(place, 0), len(speeds) - 1)]
        out[k] = s
    return out


@njit(cache=True)
def slip_above(position: Array, length: float, limit: float) -> Array:
    """Slips as far as it must for the strain to stay at or below a limit."""
    out = np.empty(len(position))
    s = 0.0
    for k in range(len(position)):
        if position[k] > 0 and (position[k] - s) / (length + s) > limit:
            s = (position[k] - limit * length) / (1 + limit)
        out[k] = s
    return out
