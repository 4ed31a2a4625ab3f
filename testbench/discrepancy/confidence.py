"""How sure a fall of the held-out error is: a bootstrap over blocks, since neighbouring samples are alike."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from testbench.discrepancy.entrant import Entrant
from testbench.discrepancy.evidence import Interval, Weighing
from testbench.discrepancy.measurement import Measurement
from testbench.discrepancy.remounting import remounted
from testbench.knit.effect import FloatArray
from testbench.knit.model import KnitModel

BLOCK_S = 60.0
FEWEST_BLOCKS = 8
DRAWS = 400
CONFIDENCE = 0.95


def with_intervals(
    weighing: Weighing, entrants: Mapping[str, Entrant], base: KnitModel, held: Measurement
) -> Weighing:
    """The ranking, with what each refitted idea takes off the held-out error."""
    before = _block_energies(base, held)
    found = {
        idea: gain_interval(before, _block_energies(entrant.fit.model, held)) for idea, entrant in entrants.items()
    }
    return replace(weighing, ranking=tuple(replace(e, held_out=found.get(e.idea)) for e in weighing.ranking))


def gain_interval(before: Mapping[str, FloatArray], after: Mapping[str, FloatArray]) -> Interval:
    """ln(squared error before / after), channels averaged, and its 95 % interval.

    Parameters
    ----------
    before, after : mapping of channel to ndarray, shape (b,)
        Squared errors summed over each block.

    Returns
    -------
    value, low, high : float
        From a bootstrap over blocks (Efron & Tibshirani, An Introduction to the Bootstrap (1993), ch. 8.6).
    """
    blocks = len(next(iter(before.values())))
    draws = np.random.default_rng(0).integers(0, blocks, (DRAWS, blocks))
    tail = 100 * (1 - CONFIDENCE) / 2
    drawn = _gain(before, after, draws)
    low, high = np.percentile(drawn, [tail, 100 - tail])
    return float(_gain(before, after, np.arange(blocks))), float(low), float(high)


def _gain(before: Mapping[str, FloatArray], after: Mapping[str, FloatArray], blocks: np.ndarray) -> FloatArray:
    ratios = [np.log(before[c][blocks].sum(-1) / np.maximum(after[c][blocks].sum(-1), 1e-300)) for c in before]
    return np.mean(ratios, axis=0)


def _block_energies(model: KnitModel, held: Measurement) -> dict[str, FloatArray]:
    """Squared held-out errors summed over blocks, each channel's mean taken out first, as in `held_errors`."""
    rows = held.counts
    count = int(rows.sum())
    blocks = max(int(count * held.dt_s / BLOCK_S), min(FEWEST_BLOCKS, count))
    edges = np.linspace(0, count, blocks, endpoint=False).astype(int)
    residual = held.residual(remounted(model, held))
    centred = {channel: values[rows] - values[rows].mean() for channel, values in residual.items()}
    return {channel: np.add.reduceat(values**2, edges) for channel, values in centred.items()}
