"""Relaxation kernels as sums of exponentials.

Each gives (times, weights) with ``kernel(t) = 1 - sum_k weight_k (1 - exp(-t / time_k))``.
"""

from __future__ import annotations

import numpy as np

from testbench.knit.effect import FloatArray

# The trapezoid rule in ln(s) is exponentially accurate here: a step of 0.7 is good to about 1e-5
# (6e-4 for a power law).
STEP = 0.7
# Times beyond this hardly move in any recording, so leaving them out changes nothing that can be seen.
LONGEST_S = 1e7
Spectrum = tuple[FloatArray, FloatArray]


def box(shortest_s: float, longest_s: float, terms: int = 12) -> Spectrum:
    """Equal weight for every ln(tau) between two times: decay like ln(t) in between; total weight 1.

    Source: Fung, Biomechanics (1993), section 7.6 (reduced relaxation function with a box spectrum).
    """
    longest_s = max(longest_s, shortest_s)
    middles = (np.arange(terms) + 0.5) / terms
    return shortest_s * (longest_s / shortest_s) ** middles, np.full(terms, 1.0 / terms)


def _log_grid(tau_s: float) -> FloatArray:
    return np.arange(np.log(tau_s / LONGEST_S), np.log(25.0) + STEP, STEP)


def logarithm(tau_s: float) -> Spectrum:
    """ln(1 + t / tau) = integral of (1 - exp(-s t / tau)) exp(-s) / s ds (Frullani)."""
    s = np.exp(_log_grid(tau_s))
    return tau_s / s, np.exp(-s) * STEP


def power(tau_s: float, exponent: float) -> Spectrum:
    """1 - (1 + t / tau)^-exponent, from the integral of the Gamma function: weights s^n exp(-s) / Gamma(n)."""
    from scipy.special import rgamma

    s = np.exp(_log_grid(tau_s))
    return tau_s / s, s**exponent * np.exp(-s) * rgamma(exponent) * STEP
