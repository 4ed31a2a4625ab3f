"""A thin fabric bears no compression: where its force would fall below that of lying loose, it buckles."""

from __future__ import annotations

import numpy as np

from testbench.knit.effect import Effect, FloatArray, Points, Signals, Stage, parameter

PLATEAU = 0.1  # of the range of the strain, travelled at the lowest force: the fabric may lie loose
AT_REST = 0.02  # of the range of the force: how near to the lowest


class Buckling(Effect):
    """The fabric hangs through instead of pushing.

    F = F_0 + w ln(1 + exp((F - F_0) / w)),   F_0 = F at the start - pretension

    What relaxes, creeps or rubs while it is stretched would make it push on the way back.

    Source: ISO 13934-1:2013 (pretension); a strip buckles under next to no load (Euler), as in tension-field theory
    (Reissner, Proc. 5th Int. Congr. Appl. Mech. (1938) 88).
    Valid: the recording begins with the fabric taut, or just so.
    """

    name = "buckling"
    in_base = True
    stage = Stage.TENSION
    reads, writes = ("force_N",), ("force_N",)
    look = "on the way back the force ends before the travel does, and stays flat from there"

    pretension_N: float = parameter(0.0, unit="N", low=0, high=1e3, doc="force at the start, above lying loose")
    rounding_N: float = parameter(0.005, unit="N", low=1e-5, high=1e2, scale="log", doc="over which tension fades")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        force = signals["force_N"]
        loose = force[0] - self.pretension_N
        return {"force_N": loose + self.rounding_N * np.logaddexp(0.0, (force - loose) / self.rounding_N)}

    def starts(self, signals: Signals, residual: Signals) -> Points:
        """Where the force stays at its lowest over a part of the travel; no point where it does not."""
        strain, force = signals["strain"], signals["force_N"]
        level, span = float(np.min(force)), float(np.ptp(force))
        low = force <= level + AT_REST * span
        if np.ptp(strain[low]) < PLATEAU * np.ptp(strain):
            return []
        return [{"pretension_N": float(force[0]) - level, "rounding_N": AT_REST * span}]
