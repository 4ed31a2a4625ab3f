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
