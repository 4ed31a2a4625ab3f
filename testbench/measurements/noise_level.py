"""How large the noise is, and what colour it has."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import convolve1d, median_filter

from testbench.knit.effect import FloatArray
from testbench.knit.kinematics.jumps import MAD_TO_SD

OUTLIER = 10.0
RAIL = 1e-4  # of the range: so near to its end nothing of a reading is left but what a filter has not forgotten
FEWEST = 50  # values that say how large the noise is
PIECE, NEIGHBOURS, LEAK = 1024, 64, 8  # samples; frequencies that a line is compared with, and that it leaks into
LINE = 30.0
MOST_STEPS = 20  # between two values, for which rounding of the values themselves does not hide an even step


def robust_sd(values: FloatArray) -> float:
    """Standard deviation from the median absolute deviation; outliers do not count."""
    return float(MAD_TO_SD * np.median(np.abs(values - np.median(values))))


def spread(values: FloatArray) -> float:
    """Root mean square about the median, outliers pulled in to `OUTLIER` robust standard deviations.

    What is rare but there counts (the ramps between long holds), a glitch hardly.
    """
    off = values - np.median(values)
    limit = OUTLIER * robust_sd(values) or np.inf  # where most values are one, the others are all that spreads
    return float(np.sqrt(np.mean(np.clip(off, -limit, limit) ** 2)))


def trimmed_rms(values: FloatArray) -> float:
    """RMS in which the largest 2 % count as the largest of the others."""
    squares = values**2
    return float(np.sqrt(np.mean(np.minimum(squares, np.quantile(squares, 0.98)))))


def glitches(values: FloatArray, noise: float | FloatArray) -> FloatArray:
    """How far single readings, or two in a row, jump out of their neighbours, shape (n,); 0 where they do not.

    They jump where noise and motion explain it no more: by more than `OUTLIER` standard deviations beyond twice what
    the neighbours differ by among themselves on the quieter side. A step is no glitch, nor is the turn of a motion.

    Parameters
    ----------
    values : ndarray, shape (n,)
    noise : float or ndarray, shape (n,)
        Standard deviation.
    """
    off = np.abs(values - median_filter(values, 5, mode="nearest"))
    steps = np.abs(np.diff(values, prepend=values[:1], append=values[-1:]))  # before each value, and after the last
    before, after = np.r_[0.0, steps[:-2]], np.r_[steps[2:], 0.0]  # of the two before, of the two after
    jump = off - 2 * np.minimum(before, after)
    return np.where(jump > OUTLIER * noise, jump, 0.0)


def within_range(values: FloatArray) -> np.ndarray:
    """Which values are neither the least nor the greatest, shape (n,): at its rail a converter shows no noise.

    Nor does a filter that has come to rest on zero, as the force of a thread that hangs loose. All of them where
    hardly any other is left.
    """
    low, high = np.min(values), np.max(values)
    edge = RAIL * (high - low)
    inside = (values > low + edge) & (values < high - edge)
    return inside if inside.sum() >= FEWEST else np.ones(len(values), bool)


def noise_floor(values: FloatArray) -> float:
    """Standard deviation of the sample-to-sample noise of a smooth signal.

    Second differences cancel the motion and leave noise: for white noise their variance is 6 sigma^2. Noise with a
    longer memory than a few samples is not seen. A hum is no noise: it can be foretold. Where times jitter, the
    motion between them is not cancelled: its speed times the jitter is in here, too.
    Values that come in steps are not known better than a step over the square root of 12.

    Parameters
    ----------
    values : ndarray, shape (n,), n >= 3
    """
    whole, values = values, values[within_range(values)]
    # Robust, because steps and reversals are rare but large in second differences.
    second = np.diff(values, 2)
    least = rounding(values) or rounding(whole)  # of three steps only one is no end of the range
    # Steps of a motion that repeats itself are lines too, and without them spread out: the smaller is meant.
    noise = min(sd_of_steps(each, least) for each in (second, without_lines(second))) / np.sqrt(6)
    return max(noise, least)


def sd_of_steps(second: FloatArray, least: float) -> float:
    """Standard deviation of second differences of readings, as `robust_sd` finds it, and nearer where they are steps.

    Differences of readings that come in steps are whole steps, and so is their median, whatever the noise. It is read
    within its step, as if the differences filled each step evenly (the median of grouped data, less Sheppard's
    correction for their width).

    Parameters
    ----------
    second : ndarray, shape (m,)
    least : float
        Standard deviation of the rounding of a reading; 0: they do not come in steps. See `rounding`.
    """
    if not least:
        return robust_sd(second)
    step = least * np.sqrt(12)
    off = np.round(np.abs(second - np.median(second)) / step)
    middle = float(np.quantile(off, 0.5, method="lower"))
    low, high = max(middle - 0.5, 0.0), middle + 0.5
    median = low + (high - low) * (0.5 - float(np.mean(off < middle))) / float(np.mean(off == middle))
    return step * float(np.sqrt(max((MAD_TO_SD * median) ** 2 - 1 / 12, 0.0)))


def sixth_differences(x: FloatArray, lag: int) -> FloatArray:
    """Over samples that are `lag` apart, shape (n - 6 lag,): no motion is left; white noise keeps its size."""
    for _ in range(6):
        x = x[lag:] - x[:-lag]
    return x / np.sqrt(924)  # the squares of the weights, summed


def without_lines(values: FloatArray) -> FloatArray:
    """Values whose frequencies do not stick out of their neighbourhood: without hums, and with all of the noise.

    The power of noise at one frequency is exponentially distributed: `LINE` medians are reached once in 10^9. It goes
    piece by piece, since a clock that wanders smears a line over a whole recording.

    Parameters
    ----------
    values : ndarray, shape (n,)

    Returns
    -------
    ndarray, shape (m,), m <= n
        What does not fill a piece is left out.
    """
    size = min(PIECE, len(values))
    if size < 4 * NEIGHBOURS:
        return values
    pieces = values[: len(values) // size * size].reshape(-1, size)
    spectra = np.fft.rfft(pieces, axis=1)
    power = np.abs(spectra) ** 2
    bands = power[:, : power.shape[1] // NEIGHBOURS * NEIGHBOURS].reshape(len(pieces), -1, NEIGHBOURS)
    around = np.repeat(np.median(bands, axis=2), NEIGHBOURS, axis=1)
    around = np.pad(around, ((0, 0), (0, power.shape[1] - around.shape[1])), mode="edge")
    # A line that falls between two frequencies leaks into its neighbours.
    sticks_out = (
        convolve1d((power > LINE * around).astype(float), np.ones(2 * LEAK + 1), axis=1, mode="constant") > 0.5
    )
    # Down to what is around them, not to nothing: a motion that repeats itself has lines nearly everywhere.
    spectra[sticks_out] *= np.sqrt(around / np.log(2) / np.maximum(power, 1e-300))[sticks_out]
    return np.fft.irfft(spectra, size, axis=1).ravel()


def rounding(values: FloatArray) -> float:
    """Standard deviation of the rounding of a coarse converter; 0 where most values occur once only."""
    distinct = np.unique(values)
    if not 1 < len(distinct) < 0.5 * len(values):
        return 0.0
    step = even_step(distinct) or float(np.median(np.diff(distinct)))  # a quick motion passes over most of the steps
    return step / 12**0.5


def even_step(values: FloatArray) -> float:
    """Step of a reading all of whose values lie on one even grid; 0 where they do not.

    Values that stand far apart because the reading moved quickly are no wider a step.
    """
    distinct = np.unique(values)
    apart = np.diff(distinct)
    apart = apart[apart > 1e-9 * max(float(np.ptp(distinct)), 1e-300)]
    if len(apart) < FEWEST // 2:
        return 0.0
    step = float(apart.min())
    near = apart[apart < MOST_STEPS * step] / step
    return step if np.all(np.abs(near - np.round(near)) < 0.05) else 0.0
