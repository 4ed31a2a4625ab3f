"""How sure a fall of the held-out error is: a bootstrap over blocks, since neighbouring samples are alike."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.stats import norm as normal
from scipy.stats import t as student

from testbench.comparing.remounting import brought_together
from testbench.knit.effect import FloatArray
from testbench.knit.model import KnitModel
from testbench.measurements.measurement import Measurement

BLOCK_S = 60.0
FEWEST_BLOCKS = 8
DRAWS = 400
CONFIDENCE = 0.95

Interval = tuple[float, float, float]  # value, low, high


def gain_interval(before: Mapping[str, FloatArray], after: Mapping[str, FloatArray]) -> Interval:
    """ln(squared error before / after), channels averaged, and its 95 % interval.

    Parameters
    ----------
    before, after : mapping of channel to ndarray, shape (b,)
        Squared errors summed over each block.

    Returns
    -------
    value, low, high : float
        From a bootstrap over blocks, expanded as few blocks need (Hesterberg, Am. Stat. 69 (2015) 371, sec. 5.3).
    """
    blocks = len(next(iter(before.values())))
    draws = np.random.default_rng(0).integers(0, blocks, (DRAWS, blocks))
    value = float(_gain(before, after, np.arange(blocks)))
    tail = 100 * (1 - CONFIDENCE) / 2
    ends = np.percentile(_gain(before, after, draws), [tail, 100 - tail])
    low, high = value + _expanded(blocks) * (ends - value)
    return value, float(low), float(high)


def _expanded(blocks: int) -> float:
    """By how much an interval from few blocks is wider: they vary by one less, and t distributions have tails."""
    upper = (1 + CONFIDENCE) / 2
    return float(np.sqrt(blocks / (blocks - 1)) * student.ppf(upper, blocks - 1) / normal.ppf(upper))


def _gain(before: Mapping[str, FloatArray], after: Mapping[str, FloatArray], blocks: np.ndarray) -> FloatArray:
    ratios = [np.log(before[c][blocks].sum(-1) / np.maximum(after[c][blocks].sum(-1), 1e-300)) for c in before]
    return np.mean(ratios, axis=0)


def block_energies(model: KnitModel, held: Measurement) -> dict[str, FloatArray]:
    """Squared held-out errors summed over blocks, each channel's mean taken out first, as in `held_errors`."""
    model, held = brought_together(model, held)
    rows = held.counts
    count = int(rows.sum())
    blocks = max(int(count * held.dt_s / BLOCK_S), min(FEWEST_BLOCKS, count))
    edges = np.linspace(0, count, blocks, endpoint=False).astype(int)
    residual = held.residual(model)
    centred = {channel: values[rows] - values[rows].mean() for channel, values in residual.items()}
    return {channel: np.add.reduceat(values**2, edges) for channel, values in centred.items()}
