"""Which samples of a measurement say something new, and how many of them are independent."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from testbench.fitting import constants
from testbench.knit.kernels import moves
from testbench.measurements.coarser import coarser
from testbench.measurements.measurement import Measurement

MOTION_STEP, HOLD_STEP = 1e-4, 0.02  # of the range of the strain, from where it stood; of the time since it moved


def on_the_grid(measurement: Measurement, finer: int = 1) -> Measurement:
    """Thinned to the grid of the comparison, or to one of `finer` times as many points."""
    return coarser(measurement, constants.GRID_HZ, finer * constants.GRID_POINTS)


def telling(measurement: Measurement) -> Measurement:
    """The measurement in which only samples that say something new count: in a long hold they repeat each other.

    All are kept while the knit moves, however slowly; in a hold one after each `HOLD_STEP` of the time since it moved
    last. A ramp of seconds before a hold of hours would weigh nothing otherwise.
    """
    strain, dt_s = measurement.signals["strain"], measurement.dt_s
    moving = moves(strain, MOTION_STEP * max(float(np.ptp(strain)), 1e-9))
    index = np.arange(len(strain))
    still_s = (index - np.maximum.accumulate(np.where(moving, index, 0))) * dt_s
    passed = np.cumsum(dt_s / np.maximum(dt_s, HOLD_STEP * still_s))
    counting = np.flatnonzero(measurement.counts)
    new = np.diff(np.floor(passed[counting] + 1e-9), prepend=-1) > 0
    counts = np.zeros_like(measurement.counts)
    counts[counting[new]] = True
    return replace(measurement, counts=counts)


def independent_share(measurement: Measurement) -> float:
    """Independent samples per sample of the grid: a finer grid adds samples, not knowledge."""
    return min(measurement.dt_s / constants.ALIKE_S, 1.0)


def news_of(measurement: Measurement, most: float = np.inf) -> float:
    """How many independent samples those that count are worth, at most so many; a short motion has few."""
    return min(int(measurement.counts.sum()) * independent_share(measurement), most)


def in_last_fit(measurement: Measurement, pieces: float) -> float:
    """`news_of` for the last fit of a model; `pieces`: independent samples that the comparison counts at most."""
    return news_of(measurement, constants.IN_LAST_FIT * pieces / constants.INDEPENDENT)
