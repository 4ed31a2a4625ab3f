"""The motion behind a noisy reading of the displacement.

Friction remembers every turn of the strain, so a model that is driven by the noise of the reading relaxes in a hold
where the fabric did not, as if somebody shook it. Where the reading stands still, many samples are averaged; where it
turns by more than its noise, nearly every sample is kept.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.optimize import isotonic_regression
from scipy.signal import savgol_coeffs
from scipy.special import softmax

from testbench.knit.effect import FloatArray
from testbench.knit.kernels import play
from testbench.measurements.noise_level import robust_sd

NEIGHBOURS = (-3, -2, -1, 1, 2, 3)
WINDOWS = {0: (1, 2, 4, 8, 16, 32), 2: (2, 4, 8, 16, 32), 4: (4, 8, 16, 32, 64)}  # order: samples on either side
AROUND, FARTHER = 17, 65  # samples over which the risk of a window is averaged, and that of their weighted mean
SLOWEST = 0.2  # share of the samples
TURN = 6.0  # standard deviations of the reading that a turn has at least


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
    """Polynomials through windows around each sample, weighted by how near they are thought to come to the motion.

    Parameters
    ----------
    values : ndarray, shape (n,)
        A reading on a uniform grid.
    noise : float
        Standard deviation of its white noise.

    Returns
    -------
    found : ndarray, shape (n,)
        The same where the reading has no noise.
    error : ndarray, shape (n,)
        Standard deviation of what it is off the motion, bends that were cut off included.

    Notes
    -----
    The polynomials are of order 0, 2 and 4 (Savitzky & Golay, Anal. Chem. 36 (1964) 1627); the narrowest window is
    the sample alone. Stein's unbiased estimate says from the reading how far each is off, noise and bias together.
    The weights are exp(-sum of risks / (4 noise^2)). Sources: Stein, Ann. Statist. 9 (1981) 1135; Leung & Barron,
    IEEE Trans. Inf. Theory 52 (2006) 3396.
    """
    if noise <= 0:
        return values.copy(), np.zeros(len(values))
    windows = list(_windows(values))
    risks = np.stack([_risk(values, *one, noise) for one in windows])
    weights = softmax(risks * (-AROUND / (4 * noise**2)), axis=0)
    averaged = noise**2 * np.array([middle for _, middle in windows]) @ weights
    risk = uniform_filter1d(np.einsum("ij,ij->j", weights, risks), FARTHER, mode="nearest")
    found = np.einsum("ij,ij->j", weights, [fit for fit, _ in windows])
    return found, np.sqrt(np.maximum(risk, averaged))  # an estimate may be negative; what an average leaves is not


def _windows(values: FloatArray) -> Iterator[tuple[FloatArray, float]]:
    """Each window's polynomial in its middle, shape (n,), and the weight of the middle sample in it.

    Near the ends, where there is no whole window, the values as they are.
    """
    yield values, 1.0
    for order, halves in WINDOWS.items():
        for half in (one for one in halves if len(values) > 2 * one):
            weights, fit = savgol_coeffs(2 * half + 1, order), values.copy()
            fit[half : len(values) - half] = np.convolve(values, weights, mode="valid")
            yield fit, float(weights[half])


def _risk(values: FloatArray, fit: FloatArray, middle: float, noise: float) -> FloatArray:
    """Stein's estimate of the squared error of a fit, averaged over neighbours, shape (n,)."""
    off = (values - fit) ** 2
    return uniform_filter1d(off, AROUND, mode="nearest") + noise**2 * (2 * middle - 1)


def without_small_turns(values: FloatArray, error: FloatArray, noise: float) -> tuple[FloatArray, FloatArray]:
    """The nearest motion that goes one way between turns of more than `TURN` standard deviations of the noise.

    What is left of the noise in a hold is small, but it turns all the time, and narrow loops of friction can be made
    to say anything with it.

    Parameters
    ----------
    values, error : ndarray, shape (n,)
        A motion, and the standard deviation of its error, from `without_reading_noise`.
    noise : float
        Standard deviation of the noise of its reading.

    Returns
    -------
    found, error : ndarray, shape (n,)
        Where k values became one, of their error a share is left, as of a mean of k readings; what they differed by
        beyond it was a small turn of the motion.
    """
    if noise <= 0:
        return values.copy(), error.copy()
    at, upwards = _turns(values, TURN * noise)
    parts = zip(np.split(values, at), upwards, strict=True)
    found = np.concatenate([isotonic_regression(part, increasing=bool(up)).x for part, up in parts])
    block = np.cumsum(np.diff(found, prepend=found[:1]) != 0)
    count = np.bincount(block)
    turned = np.bincount(block, (values - found) ** 2 - error**2) / count
    averaged = np.minimum(error**2, (noise**2 / count)[block])
    return found, np.sqrt(averaged + np.maximum(turned, 0.0)[block])


def _turns(values: FloatArray, least: float) -> tuple[list[int], list[bool]]:
    """Where a motion turns by more than `least`, and whether it goes up in each part between."""
    behind = play(values, np.array([0.5 * least]))[0]
    step = np.diff(behind, prepend=behind[:1])
    moves = np.flatnonzero(step)
    if len(moves) == 0:
        return [], [True]
    up = step[moves] > 0
    last = np.flatnonzero(np.diff(up.astype(int)))  # moves before a turn
    at = []
    for k in last:
        between = values[moves[k] : moves[k + 1]]
        at.append(int(moves[k] + (between.argmax() if up[k] else between.argmin())))
    return at, [bool(up[0]), *(bool(one) for one in up[last + 1])]
