"""The motion behind a noisy reading of the displacement.

Friction remembers every turn of the strain, so a model that is driven by the noise of the reading relaxes in a hold
where the fabric did not, as if somebody shook it. Where the reading stands still, many samples are averaged; where it
moves by more than its noise, every sample is kept.
"""

from __future__ import annotations

import numpy as np

from testbench.fitting.noise import robust_sd
from testbench.knit.effect import FloatArray

NEIGHBOURS = (-3, -2, -1, 1, 2, 3)
HALF_WIDTHS = (1, 2, 4, 8, 16, 32)  # samples on either side
SLOWEST = 0.2  # share of the samples
AGREE = 3.5  # standard errors
STILL = 6.0  # standard deviations


def reading_noise(time_s: FloatArray, values: FloatArray) -> float:
    """Standard deviation of the white noise in a reading of a smooth motion.

    From how far each sample lies off the polynomial through its six neighbours, at whatever times they were taken;
    where the motion is slowest, if that is less. A clock that jitters looks like noise in proportion to the speed,
    but is none, for force and resistance were read at the same wrong time.

    Parameters
    ----------
    time_s, values : ndarray, shape (n,)
        Times must increase.
    """
    reach = NEIGHBOURS[-1]
    if len(values) <= 2 * reach:
        return 0.0
    middle = slice(reach, len(values) - reach)
    off, gain = values[middle].copy(), np.ones(len(values) - 2 * reach)
    at = {k: time_s[reach + k : len(values) - reach + k] - time_s[middle] for k in NEIGHBOURS}
    for k in NEIGHBOURS:
        share = np.prod([at[j] / (at[j] - at[k]) for j in NEIGHBOURS if j != k], axis=0)
        off -= share * values[reach + k : len(values) - reach + k]
        gain += share**2
    speed = np.abs((values[2 * reach :] - values[: -2 * reach]) / (time_s[2 * reach :] - time_s[: -2 * reach]))
    off /= np.sqrt(gain)
    return min(robust_sd(off), robust_sd(off[speed <= np.quantile(speed, SLOWEST)]))


def without_reading_noise(values: FloatArray, noise: float) -> FloatArray:
    """Each sample replaced by the mean of the widest window around it in which the reading hardly moves.

    Parameters
    ----------
    values : ndarray, shape (n,)
        A reading on a uniform grid.
    noise : float
        Standard deviation of its white noise.

    Returns
    -------
    ndarray, shape (n,)
        No further from the reading than a few standard deviations of its noise; the same where it has none.

    Notes
    -----
    A window has to agree with all narrower ones (Lepski's rule; Katkovnik, IEEE Trans. Signal Process. 47 (1999)
    2567): its mean and that of a part of it differ by a variance of sigma^2 (1/n_part - 1/n). Its halves have to lie
    within `STILL` sigma of each other: where a motion is quicker its noise does no harm, and a mean would cut its
    turns off.
    """
    means = [(values, np.ones(len(values)))]
    best, good = values.copy(), np.ones(len(values), bool)
    for half_width in HALF_WIDTHS:
        mean, count = _window_mean(values, half_width)
        good &= _moved(means[-1][0], (half_width + 1) // 2) <= STILL * noise
        for part, fewer in means:
            good &= np.abs(mean - part) <= AGREE * noise * np.sqrt(1 / fewer - 1 / count)
        best[good] = mean[good]
        means.append((mean, count))
    return best


def _moved(values: FloatArray, reach: int) -> FloatArray:
    """How far apart the values so many samples before and after lie, shape (n,)."""
    index, last = np.arange(len(values)), len(values) - 1
    return np.abs(values[np.minimum(index + reach, last)] - values[np.maximum(index - reach, 0)])


def _window_mean(values: FloatArray, half_width: int) -> tuple[FloatArray, FloatArray]:
    """Mean over symmetric windows, narrower near the ends, and how many samples each has; each shape (n,)."""
    index = np.arange(len(values))
    half = np.minimum(half_width, np.minimum(index, index[::-1]))
    sums = np.concatenate([[0.0], np.cumsum(values - values[0])])
    count = 2.0 * half + 1.0
    return values[0] + (sums[index + half + 1] - sums[index - half]) / count, count
