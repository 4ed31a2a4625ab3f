"""Makes fits quick: a measurement at every so many points of its grid, with the turns of the motion kept."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from testbench.knit.effect import FloatArray
from testbench.measurements.measurement import Measurement
from testbench.measurements.motion import TURN

UNREAD = (
    4  # points at most, for each that counts, where rests and gaps lie between: only simulations pass through those
)


def coarser(measurement: Measurement, rate_hz: float, most_points: float = np.inf) -> Measurement:
    """The same measurement at every so many grid points: fits on it cost less and say the same.

    The rate is at least `rate_hz`, unless more than `most_points` would count.
    Points are left out, not averaged: where ln G bends sharply, the mean of ln G is not ln G at the mean strain. A
    turn of the strain stands for the points around it, which friction would not remember as it does the turn.
    """
    strain = measurement.signals["strain"]
    points = max(float(measurement.counts.sum()), len(strain) / UNREAD)
    every = max(int(1.0 / (measurement.dt_s * rate_hz) + 1e-9), int(np.ceil(points / most_points)))
    if every < 2:
        return measurement
    kept = _turns_kept(strain, every, float(np.median(measurement.strain_noise)))
    return replace(measurement.at(kept), dt_s=measurement.dt_s * every)


def _turns_kept(strain: FloatArray, every: int, noise: float) -> np.ndarray:
    """One sample of each `every`: the middle one, or that at which the strain turns by more than its noise."""
    cells = strain[: len(strain) // every * every].reshape(-1, every)
    before, after = np.r_[cells[0, 0], cells[:-1, -1]], np.r_[cells[1:, 0], cells[-1, -1]]
    above = cells.max(1) - np.maximum(before, after)
    below = np.minimum(before, after) - cells.min(1)
    inside = np.where(above >= below, cells.argmax(1), cells.argmin(1))
    inside[np.maximum(above, below) <= TURN * noise] = every // 2
    inside[:1] = 0  # memories begin at rest there
    return np.arange(len(cells)) * every + inside
