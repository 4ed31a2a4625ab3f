"""How large the noise at a grid point is where the noise of an instrument is coloured: a filter went over it.

Neighbours resemble each other then. From sample to sample such noise looks smaller than it is, and the mean of a few
samples is less quiet than that of white ones. From one point of the grid to the next but one it is white again.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from testbench.fitting import constants
from testbench.knit.effect import FloatArray
from testbench.knit.model import KnitModel
from testbench.measurements.measurement import Measurement
from testbench.measurements.noise_level import FEWEST, robust_sd, sixth_differences, within_range, without_lines

APART = 2  # points of the grid: quicker than motion, slower than the filters of instruments


def with_colour(noise: Mapping[str, float], models: Sequence[KnitModel], grid: Measurement) -> dict[str, float]:
    """The noise at a grid point, per channel: at least what all models leave over `APART` points.

    Parameters
    ----------
    noise : mapping of channel to float
        As if it were white, standard deviation: force in N, conductance in ln S.
    models : sequence of KnitModel
        What one of them leaves may be an error of its own that is as quick.
    grid : Measurement
        On the grid of the comparison.
    """
    left = [grid.residual(model) for model in models]
    return {c: max(own, min(_over_some_points(one[c], c, grid) for one in left)) for c, own in noise.items()}


def _over_some_points(left: FloatArray, channel: str, grid: Measurement) -> float:
    """Standard deviation of what a model leaves, but for motion, errors of its laws, and a hum, which is foretold."""
    values = grid.measured[channel]
    inside = (grid.counts & within_range(values))[3 * APART : -3 * APART]
    if inside.sum() < FEWEST:
        return 0.0
    rough, of_motion = (sixth_differences(x, APART)[inside] for x in (left, values - left))
    noise = min(robust_sd(rough), robust_sd(without_lines(rough)))
    by_law = constants.LAW_ERROR * robust_sd(of_motion)
    return max(noise**2 - by_law**2, 0.0) ** 0.5
