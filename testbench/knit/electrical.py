"""What happens to the conductance after the contacts made it."""

from __future__ import annotations

import numpy as np

from testbench.knit.effect import Effect, FloatArray, Signals, Stage, parameter


class Drift(Effect):
    """Logarithmic drift of the conductance as contacts settle.

    ln G += ln(10) * per_decade * log10(1 + t / tau)

    Source: Greenwood & Williamson, Proc. R. Soc. A 295 (1966) 300 (creep of asperities grows like log time).
    Valid: times from a fraction of tau to days.
    """

    name = "drift"
    stage = Stage.ELECTRICAL
    reads, writes = ("time_s", "conductance_S"), ("conductance_S",)
    strength = "per_decade"
    look = "conductance creeps in one direction, quickly at first, ever more slowly"

    per_decade: float = parameter(0.03, unit="1", low=-1, high=1, doc="log10 change of G per decade of time")
    tau_s: float = parameter(10.0, unit="s", low=0.1, high=1e5, scale="log", doc="when the drift sets in")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        decades = np.log1p(signals["time_s"] / self.tau_s) / np.log(10)
        return {"conductance_S": signals["conductance_S"] * 10 ** (self.per_decade * decades)}
