"""Whether a law is one of the whole recording or of a part of it: its gain again on resampled blocks.

Source: Efron & Tibshirani, An Introduction to the Bootstrap (1993), ch. 8.6 (blocks, as neighbouring samples are
alike); Meinshausen & Buhlmann, J. R. Statist. Soc. B 72 (2010) 417 (selection that is stable under resampling).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from testbench.fitting.evidence.hypothesis import Hypothesis
from testbench.fitting.evidence.likelihood import Likelihood
from testbench.knit.effect import FloatArray

REDRAWN_S, FEWEST_BLOCKS, DRAWS = 30.0, 8, 200
SURE = 0.95  # of the resampled recordings in which a law must gain


def stability(
    current: Hypothesis, refitted: Sequence[Hypothesis], likelihood: Likelihood
) -> tuple[FloatArray, FloatArray]:
    """How often each law gains, and how often it is the best, when the recording's blocks are drawn anew.

    The models stay as they were refitted, and so does what the evidence takes off for their freedom; the noise is
    found anew on each draw. What the linear model promises is not asked: it lets the base do what it cannot.

    Parameters
    ----------
    current : Hypothesis
        Without any of the laws.
    refitted : sequence of Hypothesis
        With each.

    Returns
    -------
    gains, wins : ndarray, shape (m,)
        Shares of the resampled recordings.
    """
    rows = likelihood.rows
    duration_s = (rows[-1] - rows[0]) * likelihood.measurement.dt_s
    blocks = int(max(duration_s / REDRAWN_S, FEWEST_BLOCKS))
    block = np.minimum((rows - rows[0]) * blocks // max(rows[-1] - rows[0], 1), blocks - 1)
    drawn = np.random.default_rng(0).integers(0, blocks, (DRAWS, blocks))
    whole = np.arange(blocks)[None, :]
    size = np.bincount(block, minlength=blocks)

    def said(h: Hypothesis, draws: np.ndarray) -> FloatArray:
        """Log likelihood of each draw, the noise at its best, shape (draws,)."""
        count, total = size[draws].sum(-1), np.zeros(len(draws))
        for c, columns in h.columns.items():
            squares = np.bincount(block, weights=(columns[0] * h.robust[c]) ** 2, minlength=blocks)
            noise = np.maximum(squares[draws].sum(-1) / count, likelihood.least[c] ** 2)
            total -= 0.5 * likelihood.share * count * np.log(noise)
        return total

    def gain(h: Hypothesis) -> FloatArray:
        free = h.log_z - current.log_z - (said(h, whole) - said(current, whole))
        return said(h, drawn) - said(current, drawn) + free

    gains = np.array([gain(h) for h in refitted])
    best = np.argmax(gains, axis=0)
    return (gains > 0).mean(-1), np.bincount(best, minlength=len(gains)) / DRAWS
