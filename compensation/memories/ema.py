"""The exponential-smoothing bank: seven memories of different length of one signal.

Aigner and Stoeckl, "Machine Learning Based Compensation for Inconsistencies in Knitted Force Sensors" (2023,
arXiv:2306.12129): ``y(t) = alpha x(t) + (1 - alpha) y(t - 1)`` with ``alpha_i = a^-i``, and ``y(0)`` the mean of the
first ``M_i = ceil(1 / (f alpha_i))`` samples.

Which reading of ``M``: ``1 / (f alpha)`` is the filter's time constant in *seconds*, yet the paper uses it as a
*number of samples*. We take the formula as printed (1, 1, 1, 2, 5, 13, 31 samples for a = 2.5, N = 7, f = 20 Hz):
it is what the authors ran, and reading it as seconds changes held-out scores by less than their spread over seeds.
Below 1 Hz, which the paper does not go to, the formula would average over more samples than the filter remembers
(1 / alpha): f counts as 1 there.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gcode.support.arrays import FloatArray
from gcode.support.errors import UserError

PAPER_FACTOR, PAPER_COUNT, PAPER_RATE_HZ = 2.5, 7, 20.0
# At 20 Hz a memory of 14 h: a slower filter never leaves its initial value.
SMALLEST_ALPHA = 1e-6
MOST_FILTERS = 1000


def smoothing_factors(factor: float = PAPER_FACTOR, count: int = PAPER_COUNT) -> FloatArray:
    """Smoothing factors ``alpha_i = a^-i``, i = 1..N (dimensionless, per sample at the bank's rate).

    Raises
    ------
    UserError
        Unless ``a > 1``, ``N >= 1`` and ``a^-N >= 1e-6``.
    """
    if not (np.isfinite(factor) and factor > 1):
        raise UserError(f"the smoothing factor a must be a number above 1 (the paper: 2.5), got {factor}")
    if count < 1:
        raise UserError(f"the bank needs at least 1 filter (the paper: 7), got {count}")
    if count > MOST_FILTERS or count * np.log(factor) > -np.log(SMALLEST_ALPHA):
        raise UserError(
            f"the slowest filter a^-N must be at least {SMALLEST_ALPHA:g}, got {factor:g}^-{count}; "
            "take a smaller a or fewer filters"
        )
    return np.asarray([float(factor) ** -i for i in range(1, int(count) + 1)])


def given_factors(alphas: Sequence[float]) -> FloatArray:
    """Smoothing factors set by hand.

    Raises
    ------
    UserError
        Unless there is at least one and each is from 1e-6 to 1.
    """
    found = np.asarray(alphas, dtype=np.float64)
    if not len(found) or not ((found >= SMALLEST_ALPHA) & (found <= 1)).all():
        raise UserError(f"smoothing factors must be numbers from {SMALLEST_ALPHA:g} to 1, got {list(alphas)}")
    return found


def start_samples(alphas: Sequence[float] | FloatArray, rate_hz: float) -> NDArray[np.int64]:
    """Samples averaged for each filter's initial value: ``M_i = ceil(1 / (f alpha_i))``, below 1 Hz with f = 1."""
    exact = 1.0 / (max(rate_hz, 1.0) * np.asarray(alphas, dtype=np.float64))
    # 1 / (20 * 0.05) must be 1, not 2 because of the last bit.
    return np.ceil(exact * (1 - 1e-12)).astype(np.int64)


def start_steps(alphas: Sequence[float] | FloatArray, rate_hz: float) -> FloatArray:
    """Steps of the bank within which those samples lie; at no usual rate does one lie just there."""
    return start_samples(alphas, rate_hz) - 0.495


def slowest_memory_s(alphas: Sequence[float] | FloatArray, rate_hz: float) -> float:
    """Time constant (s) of the slowest filter of a bank."""
    return 1.0 / (rate_hz * float(min(alphas)))


def log_retention(alphas: FloatArray) -> FloatArray:
    """``ln(1 - alpha)``: what one step keeps of the past; finite where alpha is 1, which keeps nothing."""
    return np.log1p(-np.minimum(alphas, 1 - 1e-16))


def smooth(
    x: FloatArray,
    alphas: FloatArray,
    rate_hz: float,
    start: str = "paper",
    affine: tuple[FloatArray, FloatArray] | None = None,
    step_s: FloatArray | None = None,
) -> FloatArray:
    """Smooth a signal with every factor, on a uniform grid or at the times it was sampled.

    A step of ``dt`` seconds counts as ``f dt`` steps of the bank: ``alpha_eff = 1 - (1 - alpha)^(f dt)``.

    Parameters
    ----------
    x : ndarray, shape (n,)
    alphas : ndarray, shape (k,)
    rate_hz : float
        Rate that `alphas` refer to.
    start : {"paper", "causal"}
        ``paper``: ``y(0)`` is the mean of the first M samples, which looks M - 1 samples ahead. ``causal``: the mean
        of those seen so far, as a stream must; both agree from sample M - 1 on.
    affine : tuple of two ndarrays, each shape (k,), optional
        Gain and offset of each filter: ``y(0)`` is ``offset + gain * mean``.
    step_s : ndarray, shape (n - 1,), optional
        Time from each sample to the next; a uniform grid at `rate_hz` where it is not given.

    Returns
    -------
    ndarray, shape (n, k)
    """
    from compensation.memories.compiled_filters import smooth_steps

    x = np.ascontiguousarray(x, dtype=np.float64)
    steps = np.ones(len(x) - 1) if step_s is None else step_s * rate_hz
    elapsed = np.concatenate([[0.0], np.cumsum(steps)])
    gain, offset = affine or (np.ones(len(alphas)), np.zeros(len(alphas)))
    out = np.empty((len(x), len(alphas)))
    for column, (alpha, long) in enumerate(zip(alphas, start_steps(alphas, rate_hz), strict=True)):
        within = int(np.searchsorted(elapsed, long))
        initial = offset[column] + gain[column] * _initial_values(x, within, start)
        retention = np.exp(log_retention(alpha) * steps)
        weight = np.concatenate([[1.0], np.cumprod(retention)])
        out[:, column] = smooth_steps(x, retention) + weight * initial
    return out


def _initial_values(x: FloatArray, count: int, start: str) -> FloatArray | float:
    """The value(s) of y(0) that each sample's output is based on."""
    head = x[:count]
    if start == "paper":
        return float(head.mean())
    seen = np.cumsum(head) / np.arange(1, len(head) + 1)
    return np.concatenate([seen, np.full(len(x) - len(head), seen[-1])])
