"""A load cell whose reading creeps, or whose zero drifts."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from testbench.knit.additive import ForceLaw
from testbench.knit.effect import FloatArray, Points, Signals, Stage, parameter
from testbench.knit.filters import lowpass, memory_of_decades, memory_of_two_times


class LoadCellLaw(ForceLaw):
    """Base of the laws of a load cell whose reading creeps.

    Typical sizes: a cell of class C creeps by a few parts in ten thousand of the load within 30 min (OIML R 60).
    """

    mechanism = "load_cell_creep"
    stage = Stage.READOUT
    reads: ClassVar[tuple[str, ...]] = ("force_N",)
    strength = "fraction"


class LoadCellCreep(LoadCellLaw):
    """The load cell's reading goes on changing under a constant load.

    reading(t) = F(t) + fraction * integral of (1 - exp(-(t - s) / tau)) dF(s)

    Source: OIML R 60 (creep of load cells, specified over 30 min).
    Valid: the reading alone: knit and conductance know nothing of it. Good cells: |fraction| < 0.001.
    """

    name = "load_cell_creep"
    look = "in a hold the force reading creeps while the conductance holds; after a release zero is off"

    fraction: float = parameter(0.02, unit="1", low=-1, high=1, typical=1e-3, doc="creep as a share of the load")
    tau_s: float = parameter(300.0, unit="s", low=5, high=1e4, scale="log", doc="time constant of the creep")

    def change(self, signals: Signals, dt_s: float) -> FloatArray:
        force_N = signals["force_N"]
        return self.fraction * (lowpass(force_N, self.tau_s, dt_s) - force_N[0])


class LoadCellCreepTwoTimes(LoadCellLaw):
    """The load cell's reading creeps in two steps: a quick one of the glue, a slow one of the spring.

    reading(t) = F(t) + fraction * integral of phi(t - s) dF(s)
    phi(t) = share (1 - exp(-t / fast)) + (1 - share) (1 - exp(-t / max(slow, fast)))

    Source: OIML R 60; two terms of a Prony series.
    Valid: as `load_cell_creep`.
    """

    name = "load_cell_creep_two_times"
    look = "in a hold the force reading creeps within seconds, and then on for minutes, while the conductance holds"

    fraction: float = parameter(0.02, unit="1", low=-1, high=1, typical=1e-3, doc="creep as a share of the load")
    fast_s: float = parameter(30.0, unit="s", low=2, high=300, scale="log", doc="time of the quick step")
    slow_s: float = parameter(400.0, unit="s", low=30, high=1e4, scale="log", doc="time of the slow step")
    share: float = parameter(0.5, unit="1", low=0, high=1, doc="share of the quick step")

    def starts(self, signals: Signals, residual: Signals) -> Points:
        return [{"fast_s": fast_s, "slow_s": slow_s} for fast_s in (10.0, 40.0) for slow_s in (200.0, 800.0)]

    def change(self, signals: Signals, dt_s: float) -> FloatArray:
        return memory_of_two_times(signals["force_N"], self.fraction, self.share, self.fast_s, self.slow_s, dt_s)


class LoadCellCreepLog(LoadCellLaw):
    """The load cell's reading creeps with the logarithm of time.

    reading(t) = integral of (1 + per_decade log10(1 + (t - s) / tau)) dF(s)

    Source: OIML R 60; the logarithm is the common form of anelastic after-effects.
    Valid: as `load_cell_creep`.
    """

    name = "load_cell_creep_log"
    strength = "per_decade"
    look = "in a hold the force reading creeps ever more slowly while the conductance holds"

    per_decade: float = parameter(0.01, unit="1", low=-0.5, high=0.5, typical=3e-4, doc="relative creep per decade")
    tau_s: float = parameter(3.0, unit="s", low=0.05, high=300, scale="log", doc="when the creep sets in")

    def change(self, signals: Signals, dt_s: float) -> FloatArray:
        return memory_of_decades(signals["force_N"], self.per_decade, self.tau_s, dt_s)


class LoadCellZeroDrift(LoadCellLaw):
    """The zero of the load cell drifts with time, as its bridge warms up.

    reading += drift * (1 - exp(-t / tau))

    Source: warm-up of a bridge; data sheets state zero drift per kelvin.
    Valid: in the reading alone.
    """

    name = "load_cell_zero_drift"
    reads = ("time_s", "force_N")
    strength = "drift_N"
    look = "the whole force curve is shifted, more and more, at every strain alike"

    drift_N: float = parameter(0.05, unit="N", low=-50, high=50, typical=5e-3, doc="shift in the end")
    tau_s: float = parameter(600.0, unit="s", low=5, high=1e5, scale="log", doc="time constant")

    def change(self, signals: Signals, dt_s: float) -> FloatArray:
        return -self.drift_N * np.expm1(-signals["time_s"] / self.tau_s)
