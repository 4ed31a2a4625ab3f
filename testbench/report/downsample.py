"""What is drawn of many samples: a stretch of them, the one that is worth a look, means in bins."""

from __future__ import annotations

import numpy as np

from gcode.support.arrays import FloatArray

LEAST = 200  # samples that a look at a stretch needs
BINS = 24


def liveliest(time_s: FloatArray, energy: FloatArray, length_s: float) -> tuple[float, float]:
    """The stretch of `length_s`, of at least `LEAST` samples, that holds most of `energy`, shape (n,); the first."""
    width = min(len(time_s), max(round(length_s / float(np.median(np.diff(time_s)))), LEAST))
    sums = np.concatenate([[0.0], np.cumsum(energy)])
    start = int(np.argmax(sums[width:] - sums[:-width]))
    return float(time_s[start]), float(time_s[start + width - 1])


def window(time_s: FloatArray, start_s: float | None, end_s: float | None) -> slice:
    """The rows between two times, with one sample on either side so that lines reach the edge."""
    first = 0 if start_s is None else max(0, int(np.searchsorted(time_s, start_s)) - 1)
    last = len(time_s) if end_s is None else min(len(time_s), int(np.searchsorted(time_s, end_s)) + 1)
    return slice(first, max(last, first + 2))


def binned(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Mean of `x` and `y`, and the standard error of that of `y`, in bins with about as many samples each."""
    import pandas as pd

    edges = np.unique(np.quantile(x, np.linspace(0, 1, BINS + 1)))
    inner = edges[1:-1] if len(edges) > 2 else [edges.mean()]
    bins = pd.DataFrame({"x": x, "y": y}).groupby(np.searchsorted(inner, x, side="right"))
    mean, error = bins.mean(), bins["y"].sem(ddof=0)
    return mean["x"].to_numpy(), mean["y"].to_numpy(), error.to_numpy()
