"""Whether a law is one of the whole recording or of a part of it: the choice made again on resampled blocks.

Source: Efron & Tibshirani, An Introduction to the Bootstrap (1993), ch. 8.6 (blocks, as neighbouring samples are
alike); Meinshausen & Buhlmann, J. R. Statist. Soc. B 72 (2010) 417 (selection that is stable under resampling).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from testbench.knit.effect import FloatArray
from testbench.proposing.beam import Found, price_of
from testbench.proposing.screening import Projector

BLOCK_S, FEWEST_BLOCKS, DRAWS = 30.0, 8, 200
SURE = 0.95  # of the resampled recordings in which a law must gain


def stability(projector: Projector, found: Sequence[Found]) -> tuple[FloatArray, FloatArray]:
    """How often each law gains, and how often it is the best, when the recording's blocks are drawn anew.

    Returns
    -------
    gains, wins : ndarray, shape (m,)
        Shares of the resampled recordings.
    """
    rows, channels = projector.rows, len(projector.channels)
    duration_s = (rows[-1] - rows[0]) * projector.chain.measurement.dt_s
    blocks = int(max(duration_s / BLOCK_S, FEWEST_BLOCKS))
    block = np.minimum((rows - rows[0]) * blocks // max(rows[-1] - rows[0], 1), blocks - 1)
    block = np.tile(block, channels)
    goal = np.empty((len(found), blocks))
    left = np.empty((len(found), blocks))
    for k, one in enumerate(found):
        f = projector.projected(one.law)
        goal[k] = np.bincount(block, weights=f * projector.residual, minlength=blocks)
        left[k] = np.bincount(block, weights=f * f, minlength=blocks)
    draws = np.random.default_rng(0).integers(0, blocks, (DRAWS, blocks))
    top, size = goal[:, draws].sum(-1), left[:, draws].sum(-1)
    price = np.array([[price_of(one.law.term)] for one in found])
    gain = 0.5 * top**2 / (size + 1e-12) - 0.5 * np.log1p(size) - price
    # The strength is found anew on each draw, and must keep its sign.
    sign = np.sign(goal.sum(-1, keepdims=True))
    alike = np.sign(top) == sign
    best = np.argmax(np.where(alike, gain, -np.inf), axis=0)
    return (alike & (gain > 0)).mean(-1), np.bincount(best, minlength=len(found)) / DRAWS
