"""Effects that multiply the conductance: each law says by how much ln G changes."""

from __future__ import annotations

from typing import ClassVar

from testbench.knit.effect import Effect, FloatArray, Signals, Stage
from testbench.knit.filters import shifted


class ConductanceLaw(Effect):
    """Base of the laws of the form ``ln G += change``; a subclass gives the change."""

    stage = Stage.ELECTRICAL
    reads: ClassVar[tuple[str, ...]] = ("strain", "conductance_S")
    writes = ("conductance_S",)
    strength = "gain"

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        """Change of ln G, shape (n,); arguments as `apply`."""
        raise NotImplementedError

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        return {"conductance_S": shifted(signals["conductance_S"], self.log_change(signals, dt_s))}
