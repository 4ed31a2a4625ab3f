"""The motion behind a noisy reading of the displacement.

Friction remembers every turn of the strain, so a model that is driven by the noise of the reading relaxes in a hold
where the fabric did not, as if somebody shook it. Where the reading stands still, many samples are averaged; where it
moves by more than its noise, every sample is kept.
"""

from __future__ import annotations

import numpy as np
from scipy.signal import savgol_coeffs

from testbench.fitting.noise import robust_sd
from testbench.knit.effect import FloatArray
from testbench.knit.kernels import play

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


def without_reading_noise(values: FloatArray, noise: float) -> tuple[FloatArray, FloatArray]:
    """Each sample replaced by the widest mean, or the widest parabola, around it that the reading agrees with.

    Parameters
    ----------
    values : ndarray, shape (n,)
        A reading on a uniform grid.
    noise : float
        Standard deviation of its white noise.

    Returns
    -------
    found : ndarray, shape (n,)
        No further from the reading than a few standard deviations of its noise; the same where it has none.
    error : ndarray, shape (n,)
        Standard deviation of the noise that is left; where the motion bends, the error may be twice that.

    Notes
    -----
    A window has to agree with all narrower ones (Lepski's rule; Katkovnik, IEEE Trans. Signal Process. 47 (1999)
    2567): what is found in it and in a part of it differ by the difference of their variances. A mean is for a motion
    that stands still, or nearly: the halves of its window have to lie within `STILL` sigma of each other, since it
    would cut turns off. A parabola (Savitzky & Golay, Anal. Chem. 36 (1964) 1627) is for the motion.
    """
    found, variance = values.copy(), np.ones(len(values))
    means = ((half, *_window_mean(values, half)) for half in HALF_WIDTHS)
    parabolas = ((half, *_parabola(values, half)) for half in HALF_WIDTHS[1:])
    for fits, is_mean in ((means, True), (parabolas, False)):
        narrower, good = [(values, np.ones(len(values)))], np.ones(len(values), bool)
        for half, fit, left in fits:
            if is_mean:
                good &= _moved(narrower[-1][0], (half + 1) // 2) <= STILL * noise
            for part, more in narrower:
                good &= np.abs(fit - part) <= AGREE * noise * np.sqrt(np.maximum(more - left, 0.0))
            better = good & (left < variance)
            found[better], variance[better] = fit[better], left[better]
            narrower.append((fit, left))
    return found, noise * np.sqrt(variance)


def without_small_turns(values: FloatArray, noise: float) -> FloatArray:
    """The motion without turns of less than `AGREE` standard deviations of the noise: it stands at the last turn.

    What is left of the noise in a hold is small, but it turns all the time, and narrow loops of friction can be made
    to say anything with it.

    Parameters
    ----------
    values : ndarray, shape (n,)
        A motion, after `without_reading_noise`.
    noise : float
        Standard deviation of the noise of its reading.
    """
    half = 0.5 * AGREE * noise
    behind = play(values, np.array([half]))[0]
    way = np.sign(np.diff(behind, prepend=behind[:1]))
    newest = np.maximum.accumulate(np.where(way != 0, np.arange(len(way)), 0))
    return behind + half * way[newest]


def _moved(values: FloatArray, reach: int) -> FloatArray:
    """How far apart the values so many samples before and after lie, shape (n,)."""
    index, last = np.arange(len(values)), len(values) - 1
    return np.abs(values[np.minimum(index + reach, last)] - values[np.maximum(index - reach, 0)])


def _window_mean(values: FloatArray, half_width: int) -> tuple[FloatArray, FloatArray]:
    """Mean over symmetric windows, narrower near the ends, and its variance over the noise's; each shape (n,)."""
    index = np.arange(len(values))
    half = np.minimum(half_width, np.minimum(index, index[::-1]))
    sums = np.concatenate([[0.0], np.cumsum(values - values[0])])
    count = 2.0 * half + 1.0
    return values[0] + (sums[index + half + 1] - sums[index - half]) / count, 1 / count


def _parabola(values: FloatArray, half_width: int) -> tuple[FloatArray, FloatArray]:
    """Middle of the parabola through symmetric windows, and its variance over the noise's; each shape (n,).

    Near the ends, where there is no whole window, the values as they are.
    """
    found, left = values.copy(), np.ones(len(values))
    if len(values) > 2 * half_width:
        weights = savgol_coeffs(2 * half_width + 1, 2)
        whole = slice(half_width, len(values) - half_width)
        found[whole], left[whole] = np.convolve(values, weights, mode="valid"), float(weights @ weights)
    return found, left
