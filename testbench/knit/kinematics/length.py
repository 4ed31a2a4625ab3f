"""The knit grows longer between its clamps, by set or by slip, and hangs limp where it has become too long."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from testbench.knit.effect import Effect, FloatArray, Signals, Stage, parameter

TAUT = 0.3  # pretension of a knit that never hangs limp


class Lengthening(Effect):
    """Base of set and slip: a length is added between the clamps, and a limp fabric bears no compression.

    e = max((e - added) / (1 + renewed added), min(e, -pretension))

    `renewed` says how much of the added length stretches along: all of it where the knit itself grew longer.
    Where the force starts to rise on the next stretch tells a knit that grew longer from one that became softer.

    Source: ISO 13934-1:2013 (pretension against slack). A subclass says how much is added.
    """

    stage = Stage.KINEMATICS
    reads: ClassVar[tuple[str, ...]] = ("strain",)
    writes = ("strain",)

    pretension: float = parameter(
        0.0, unit="1", low=0, high=TAUT, doc="strain it was mounted with: so far below the start it still pulls"
    )
    renewed: float = parameter(0.0, unit="1", low=0, high=1, doc="share of the added length that stretches along")

    def added(self, signals: Signals, dt_s: float) -> FloatArray:
        """Length gained so far, as strain, shape (n,)."""
        raise NotImplementedError

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        strain = signals["strain"]
        added = self.added(signals, dt_s)
        stretched = (strain - added) / (1 + self.renewed * added)
        return {"strain": np.maximum(stretched, np.minimum(strain, -self.pretension))}


def overload_s(strain: FloatArray, limit: float, dt_s: float) -> FloatArray:
    """Time integral of the strain above `limit`, shape (n,)."""
    over = np.maximum(strain - limit, 0.0)
    return np.concatenate([[0.0], np.cumsum(0.5 * (over[1:] + over[:-1]) * dt_s)])
