"""Laws that change one signal by what they compute from others; while those stay, it is not computed again."""

from __future__ import annotations

from typing import ClassVar

from testbench.knit.effect import Effect, FloatArray, Signals, Stage
from testbench.knit.filters import factor_of


class AdditiveLaw(Effect):
    """Base of the laws whose `apply` puts a change into the signal that they write."""

    def change(self, signals: Signals, dt_s: float) -> FloatArray:
        """The change, shape (n,); arguments as `apply`."""
        raise NotImplementedError

    def put(self, signals: Signals, change: FloatArray) -> dict[str, FloatArray]:
        """The signal that is written, with the change in it."""
        raise NotImplementedError

    def terms(self, parameter: str, signals: Signals) -> FloatArray | None:
        """What each weight of a vector adds, in N or ln S, at weight 1: shape (k, n).

        None where the law is not linear in that parameter, or does not say.
        """
        return None

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        return self.put(signals, self.change(signals, dt_s))


class ForceLaw(AdditiveLaw):
    """Base of the laws of the form ``F += change`` in N."""

    stage = Stage.MECHANICS
    reads: ClassVar[tuple[str, ...]] = ("strain", "force_N")
    writes = ("force_N",)

    def put(self, signals: Signals, change: FloatArray) -> dict[str, FloatArray]:
        return {"force_N": signals["force_N"] + change}


class ForceFactor(ForceLaw):
    """Base of the laws of the form ``F *= change``."""

    def put(self, signals: Signals, change: FloatArray) -> dict[str, FloatArray]:
        return {"force_N": signals["force_N"] * change}


class ConductanceLaw(AdditiveLaw):
    """Base of the laws of the form ``ln G += change``; a subclass gives the change."""

    stage = Stage.ELECTRICAL
    reads: ClassVar[tuple[str, ...]] = ("strain", "conductance_S")
    writes = ("conductance_S",)
    strength = "gain"

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        """Change of ln G, shape (n,); arguments as `apply`."""
        raise NotImplementedError

    def change(self, signals: Signals, dt_s: float) -> FloatArray:
        """Factor on the conductance, exp(`log_change`): a law says that, and not this."""
        return factor_of(self.log_change(signals, dt_s))

    def put(self, signals: Signals, change: FloatArray) -> dict[str, FloatArray]:
        return {"conductance_S": signals["conductance_S"] * change}
