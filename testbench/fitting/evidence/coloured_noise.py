"""How large the noise at a grid point is where the noise of an instrument is coloured: a filter went over it.

Neighbours resemble each other then. From sample to sample such noise looks smaller than it is, and the mean of a few
samples is less quiet than that of white ones. From one point of the grid to the next most of that is forgotten.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from testbench.fitting import constants
from testbench.knit.effect import FloatArray
from testbench.knit.model import KnitModel
from testbench.measurements.measurement import Measurement
from testbench.measurements.noise_level import FEWEST, robust_sd, sixth_differences, within_range, without_lines

FARTHEST = 4  # points of the grid over which errors of a model have grown


def with_colour(noise: Mapping[str, float], models: Sequence[KnitModel], grid: Measurement) -> dict[str, float]:
    """The noise at a grid point, per channel: at least what all models leave from one point to the next.

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
    return {c: max(own, min(_from_point_to_point(one[c], c, grid) for one in left)) for c, own in noise.items()}


def _from_point_to_point(left: FloatArray, channel: str, grid: Measurement) -> float:
    """Standard deviation of the noise in what a model leaves.

    The errors of a model grow with the distance of the points, in their variance at least as it does; noise does not.
    A hum may be larger over one distance than over another.
    """
    values = grid.measured[channel]
    counting = grid.counts & within_range(values)
    if counting.sum() < 10 * FEWEST:
        return 0.0
    first, second, *others = (_variance(left, values, counting, apart) for apart in range(1, FARTHEST + 1))
    growth = max(*others, second) - second
    return max(min(first, second) - growth / 2, 0.0) ** 0.5


def _variance(left: FloatArray, values: FloatArray, counting: np.ndarray, apart: int) -> float:
    """Variance of the residual's differences over points this far apart.

    What the laws usually err by is taken off, and so is a hum: it can be predicted and is no noise.
    """
    inside = counting[3 * apart : -3 * apart]
    rough, of_motion = (sixth_differences(x, apart)[inside] for x in (left, values - left))
    noise = min(robust_sd(rough), robust_sd(without_lines(rough)))
    return noise**2 - (constants.LAW_ERROR * robust_sd(of_motion)) ** 2
