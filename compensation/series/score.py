"""How well a prediction follows the truth: the paper's figures, and fairer ones beside them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gcode.support.arrays import FloatArray
from testbench.recordings.recording import recorded_time_s

# Errors APART_S (`compensation.training.recalibration`) apart are about independent: a block lasts a few times that.
BLOCK_S, SHORTEST_BLOCK_S, FEWEST_BLOCKS = 60.0, 20.0, 5
DRAWS = 1000
TINY = 1e-12  # of the variance


def r2(truth: FloatArray, prediction: FloatArray) -> float:
    """Coefficient of determination as the paper writes it.

    ``1 - sum((X - Y)^2) / sum((X - mean(Y))^2)`` with X the truth and Y the prediction. The mean is that of Y, so the
    value is never below `sklearn.metrics.r2_score` and equals it when both means agree.
    """
    truth, prediction = np.asarray(truth), np.asarray(prediction)
    error = float(np.sum((truth - prediction) ** 2))
    spread = float(np.sum((truth - prediction.mean()) ** 2))
    return 1.0 - error / spread


def r2_ordinary(truth: FloatArray, prediction: FloatArray) -> float:
    """The usual coefficient of determination, as `sklearn.metrics.r2_score`: an error in level counts in full."""
    truth, prediction = np.asarray(truth), np.asarray(prediction)
    return 1.0 - float(np.sum((truth - prediction) ** 2)) / float(np.sum((truth - truth.mean()) ** 2))


def standardised(values: FloatArray) -> FloatArray:
    """Zero mean, unit variance (population), as scikit-learn's StandardScaler; a constant becomes zero."""
    return (values - values.mean()) / (values.std() or 1.0)


def r2_before(truth: FloatArray, conductance_S: FloatArray, sign: float = 1.0) -> float:
    """The paper's score of the raw signal: both standardised over the recording; equals ``2 rho - 1``.

    `sign` is -1 for a sensor whose conductance falls with stretch.
    """
    return r2(standardised(truth), sign * standardised(conductance_S))


def rho_squared(truth: FloatArray, conductance_S: FloatArray) -> float:
    """What the best straight line through the raw signal would score: the fairer baseline."""
    return float(np.corrcoef(truth, conductance_S)[0, 1] ** 2)


def interval_text(interval: Sequence[float] | None) -> str:
    """An interval as it is printed, or that the recording is too short for one."""
    return "too short" if interval is None else "{:.3f}..{:.3f}".format(*interval)


def error_of_two(r2_a: float, r2_b: float) -> float:
    """The paper's selection criterion ``E = ((1 - r2_A)^2 + (1 - r2_B)^2) / 2`` over two test recordings."""
    return ((1.0 - r2_a) ** 2 + (1.0 - r2_b) ** 2) / 2.0


def jackknife_interval(whole: float, without: Sequence[float]) -> list[float]:
    """95 % interval of r2 over a few recordings, from the same r2 without each of them.

    Few recordings drawn again look too alike; Student's t knows that their spread is an estimate, too. It is the
    logarithm of 1 - r2 that is thought to be normal: errors differ by factors.

    Source: Efron & Tibshirani, An Introduction to the Bootstrap (1993), ch. 11 (jackknife).
    """
    from scipy.special import stdtrit

    count = len(without)
    unexplained, *others = np.log(np.maximum(1.0 - np.array([whole, *without]), TINY))
    reach = stdtrit(count - 1, 0.975) * np.sqrt((count - 1) * np.var(others))
    return [float(1.0 - np.exp(unexplained + reach)), float(1.0 - np.exp(unexplained - reach))]


def block_interval(truth: FloatArray, prediction: FloatArray, time_s: FloatArray) -> list[float] | None:
    """95 % interval of r2 from a bootstrap over blocks of 60 s, of a recording below 5 min over fifths.

    Neighbouring samples are alike, so a bootstrap over single samples gives intervals several times too narrow; so
    do few blocks. Below `FEWEST_BLOCKS` blocks of `SHORTEST_BLOCK_S` there is none. Gaps do not count.
    """
    elapsed_s = recorded_time_s(time_s)
    duration_s = elapsed_s[-1]
    if duration_s < FEWEST_BLOCKS * SHORTEST_BLOCK_S:
        return None
    block_s = min(BLOCK_S, duration_s / FEWEST_BLOCKS)
    blocks = np.minimum(elapsed_s / block_s, np.ceil(duration_s / block_s) - 1).astype(int)
    starts = np.flatnonzero(np.diff(blocks, prepend=-1))
    if len(starts) < FEWEST_BLOCKS:
        return None
    # Centred first: the sums of squares below would cancel badly far from zero.
    truth, prediction = truth - truth.mean(), prediction - truth.mean()
    sums = np.add.reduceat(
        np.column_stack([np.ones_like(truth), truth, truth**2, prediction, (truth - prediction) ** 2]), starts
    )
    picks = np.random.default_rng(0).integers(len(sums), size=(DRAWS, len(sums)))
    n, t, t2, p, e = np.moveaxis(sums[picks].sum(axis=1), 1, 0)
    mean = p / n
    return np.quantile(1.0 - e / (t2 - 2 * mean * t + n * mean**2), [0.025, 0.975]).tolist()
