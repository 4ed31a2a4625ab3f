"""Sequential loops that NumPy cannot vectorise, compiled by numba."""

from __future__ import annotations

import numba
import numpy as np

jit = numba.njit(cache=True, nogil=True)


@jit
def smooth_steps(x: np.ndarray, retention: np.ndarray) -> np.ndarray:
    """Exponential smoothing from a zero state; ``retention[k]`` is what step k + 1 keeps of the past."""
    out = np.zeros(len(x))
    for k in range(1, len(x)):
        out[k] = x[k] + retention[k - 1] * (out[k - 1] - x[k])
    return out


@jit
def remember(
    x: np.ndarray, dt_s: np.ndarray, settle_s: float, taus_s: np.ndarray, radii: np.ndarray, held: np.ndarray
) -> np.ndarray:
    """Smoothed speeds, then play operators, of the lightly smoothed `x`; see `compensation.memories.history`."""
    motions = len(taus_s)
    out = np.zeros((len(x), motions + len(radii)))
    settled = x[0]
    out[0] = held
    for i in range(len(radii)):
        out[0, motions + i] = max(settled - radii[i], min(settled + radii[i], held[motions + i]))
    for k in range(1, len(x)):
        step, speed = 0.0, 0.0
        if dt_s[k - 1] > 0.0:
            step = -np.expm1(-dt_s[k - 1] / settle_s) * (x[k] - settled)
            speed = abs(step) / dt_s[k - 1]
        settled += step
        for i in range(motions):
            out[k, i] = out[k - 1, i] - np.expm1(-dt_s[k - 1] / taus_s[i]) * (speed - out[k - 1, i])
        for i in range(len(radii)):
            out[k, motions + i] = max(settled - radii[i], min(settled + radii[i], out[k - 1, motions + i]))
    return out
