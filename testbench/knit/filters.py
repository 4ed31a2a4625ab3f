"""Linear memory, solved exactly for signals that run straight between their samples.

Because the solution between two samples is exact, the result does not depend on the sampling rate beyond how well
straight lines follow the signal. All filters have rested at the first sample for ever, unless told otherwise.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from testbench.knit import spectra
from testbench.knit.effect import FloatArray

# A strain rate is a slope over so long to either side: a lag is late, which shows in a force that follows its sign.
RATE_HALF_SPAN_S = 0.04
RATE_LAG_S = 0.1
# Wiggles of strain below this are encoder noise: they neither wear nor tire a knit.
DEAD_BAND_STRAIN = 0.002


def hold_coefficients(tau_s: FloatArray, dt_s: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Coefficients of ``tau y' = x - y`` for x linear between samples: ``y1 = a y0 + b0 x1 + b1 x0``.

    Parameters
    ----------
    tau_s : ndarray, shape (k,)
        Time constants; 0 gives ``y = x``.
    dt_s : float

    Returns
    -------
    a, b0, b1 : ndarray, each shape (k,)
    """
    tau_s = np.atleast_1d(np.asarray(tau_s, dtype=np.float64))
    forgetful = tau_s < 1e-12 * dt_s
    ratio = dt_s / np.where(forgetful, dt_s, tau_s)
    a = np.exp(-ratio)
    mean = -np.expm1(-ratio) / ratio
    slow = ratio < 1e-3  # series instead of a difference of nearly equal numbers
    b0 = np.where(slow, ratio * (1 / 2 - ratio * (1 / 6 - ratio * (1 / 24 - ratio / 120))), 1 - mean)
    b1 = np.where(slow, mean * ratio - b0, mean - a)  # together they are 1 - a
    return np.where(forgetful, 0.0, a), np.where(forgetful, 1.0, b0), np.where(forgetful, 0.0, b1)


def lowpass(x: FloatArray, tau_s: float, dt_s: float, start: float | None = None) -> FloatArray:
    """First-order low-pass ``tau y' = x - y``.

    Parameters
    ----------
    x : ndarray, shape (n,)
    tau_s, dt_s : float
    start : float, optional
        ``y`` at the first sample; the rest value ``x[0]`` when not given.
    """
    from testbench.knit.lags import first_order

    return first_order(np.ascontiguousarray(x), *_of_one(tau_s, dt_s), float(x[0]) if start is None else start)


@lru_cache(maxsize=1000)
def _of_one(tau_s: float, dt_s: float) -> tuple[float, float, float]:
    """`hold_coefficients` of one time, which many signals are filtered with."""
    a, b0, b1 = hold_coefficients(np.array([tau_s]), dt_s)
    return float(a[0]), float(b0[0]), float(b1[0])


def highpass(x: FloatArray, tau_s: float, dt_s: float) -> FloatArray:
    """What is sudden in `x`: what a first-order low-pass has not followed yet."""
    return x - lowpass(x, tau_s, dt_s)


def rate(x: FloatArray, dt_s: float) -> FloatArray:
    """Rate of change of `x` per second: the chord over `RATE_HALF_SPAN_S` before and after, as far as `x` goes."""
    half = max(round(RATE_HALF_SPAN_S / dt_s), 1)
    at = np.arange(len(x))
    before, after = np.maximum(at - half, 0), np.minimum(at + half, len(x) - 1)
    return (x[after] - x[before]) / (np.maximum(after - before, 1) * dt_s)


def moving(x: FloatArray, dt_s: float) -> FloatArray:
    """Rate of `x` per second, zero at the start: it was at rest before."""
    speed = rate(x, dt_s)
    speed[0] = 0.0
    return speed


def lagging_rate(x: FloatArray, dt_s: float) -> FloatArray:
    """Rate of change of `x` per second through a lag of `RATE_LAG_S`, as contacts feel it; zero at the start."""
    return highpass(x, RATE_LAG_S, dt_s) / RATE_LAG_S


def memory(x: FloatArray, tau_s: FloatArray, weights: FloatArray, dt_s: float) -> FloatArray:
    """``sum_k weights_k (lowpass_k(x) - x[0])``: what a spectrum of relaxation times has forgotten so far."""
    from testbench.knit.lags import exponential_bank

    a, b0, b1 = hold_coefficients(tau_s, dt_s)
    return exponential_bank(np.ascontiguousarray(x), a, b0, b1, np.asarray(weights, dtype=np.float64))


LEAST_LEFT = 1e-3  # of a conductance from which a path was taken away, or of a resistance


def beside(conductance_S: FloatArray, part: FloatArray) -> FloatArray:
    """Conductance with a path in parallel, of `part` times its first value."""
    return np.maximum(conductance_S + part * conductance_S[0], LEAST_LEFT * conductance_S)


def in_series(conductance_S: FloatArray, part: FloatArray) -> FloatArray:
    """Conductance with a resistance in series, of `part` times the first one."""
    return conductance_S / np.maximum(1 + part * (conductance_S / conductance_S[0]), LEAST_LEFT)


def memory_of_two_times(
    x: FloatArray, fraction: float, share: float, fast_s: float, slow_s: float, dt_s: float
) -> FloatArray:
    """`memory` of two times: `fraction` is forgotten in the end, `share` of it by the quick one.

    The slow one is never quicker: else two pairs of times, and shares of them, would be one law.
    """
    return memory(x, np.array([fast_s, max(slow_s, fast_s)]), fraction * np.array([share, 1 - share]), dt_s)


def memory_of_box(x: FloatArray, fraction: float, shortest_s: float, longest_s: float, dt_s: float) -> FloatArray:
    """`memory` of a box of relaxation times between two: `fraction` is forgotten in the end.

    The longest is never shorter than the shortest: else two orders of them would be one law.
    """
    times_s, weights = spectra.box(shortest_s, longest_s)
    return memory(x, times_s, fraction * weights, dt_s)


def memory_of_decades(x: FloatArray, per_decade: float, tau_s: float, dt_s: float) -> FloatArray:
    """`memory` that goes on with the logarithm of time: `per_decade` in every tenfold of it beyond `tau_s`."""
    times_s, weights = spectra.logarithm(tau_s)
    return memory(x, times_s, per_decade / np.log(10) * weights, dt_s)


def activated_memory(x: FloatArray, load: FloatArray, tau_s: float, activation: float, dt_s: float) -> FloatArray:
    """What of `x` is forgotten so far, the sooner the larger a load is: tau exp(-activation load) y' = x - x(0) - y.

    Source: Eyring, J. Chem. Phys. 4 (1936) 283 (a load lowers the barrier, and the time falls exponentially).
    """
    from testbench.knit.lags import varying_lowpass

    per_s = np.exp(activation * np.clip(load, 0.0, 1.0)) / tau_s
    mean_per_s = 0.5 * (per_s + np.r_[per_s[0], per_s[:-1]])  # over the step that ends at each sample
    return varying_lowpass(x, np.exp(-dt_s * mean_per_s)) - x[0]


def log_conductance(conductance_S: FloatArray) -> FloatArray:
    """Natural logarithm of the conductance, finite where a wild fit has none left."""
    return np.log(np.maximum(conductance_S, 1e-300))


def log_ratio(conductance_S: FloatArray, before_S: FloatArray) -> FloatArray:
    """Change of the natural logarithm of the conductance, finite where a wild fit has none left."""
    ratio = np.maximum(conductance_S, 1e-300)
    ratio /= np.maximum(before_S, 1e-300)
    return np.log(ratio, out=ratio)


def shifted(conductance_S: FloatArray, log_change: FloatArray) -> FloatArray:
    """Conductance with `log_change` added to its natural logarithm."""
    return conductance_S * factor_of(log_change)


LARGEST_LOG_CHANGE = 30.0  # keeps a wild fit finite


def factor_of(log_change: FloatArray) -> FloatArray:
    """Factor on the conductance that a change of its natural logarithm is, up to `LARGEST_LOG_CHANGE` either way."""
    capped = np.clip(log_change, -LARGEST_LOG_CHANGE, LARGEST_LOG_CHANGE, dtype=float)
    return np.exp(capped, out=capped if capped.ndim else None)
