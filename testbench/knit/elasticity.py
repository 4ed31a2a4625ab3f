"""How force follows strain, without history."""

from __future__ import annotations

import numpy as np

from testbench.knit.effect import Effect, FloatArray, Signals, Stage, parameter


class Elasticity(Effect):
    """J-curve of a knit: loops straighten at low strain, yarn stretches at high strain.

    F(e) = offset + stiffness * (exp(curvature e) - 1) / curvature

    `stiffness` is the slope at zero strain [N per unit strain]; `curvature` = 0 is a straight line.

    Source: Fung, Am. J. Physiol. 213 (1967) 1532, Eq. 6 (exponential law of soft fibrous tissue).
    Valid: monotonic loading below yarn damage, about 0 <= e <= 0.6.
    """

    name = "elasticity"
    stage = Stage.MECHANICS
    reads, writes = ("strain",), ("force_N",)
    look = "force rises with strain, the steeper the further the knit is stretched"

    stiffness_N: float = parameter(
        8.0, unit="N", low=1e-3, high=1e4, scale="log", doc="slope of force over strain at zero strain"
    )
    curvature: float = parameter(3.0, unit="1", low=-10, high=30, doc="how fast the slope grows with strain")
    offset_N: float = parameter(0.0, unit="N", low=-100, high=100, doc="force at zero strain (not tared)")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        e = signals["strain"]
        c = self.curvature
        shape = np.expm1(c * e) / c if abs(c) > 1e-6 else e
        return {"force_N": self.offset_N + self.stiffness_N * shape}
