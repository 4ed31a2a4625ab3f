"""A load cell whose reading creeps, or whose zero drifts."""

from __future__ import annotations

import numpy as np

from testbench.knit.effect import Effect, FloatArray, Signals, Stage, parameter
from testbench.knit.filters import lowpass, memory_of_decades


class LoadCellCreep(Effect):
    """The load cell's reading goes on changing under a constant load.

    reading(t) = F(t) + fraction * integral of (1 - exp(-(t - s) / tau)) dF(s)

    Source: OIML R 60 (creep of load cells, specified over 30 min).
    Valid: the reading alone: knit and conductance know nothing of it. Good cells: |fraction| < 0.001.
    """

    name = "load_cell_creep"
    cost = 0.1  # data sheets promise hundredths of a per cent
    stage = Stage.READOUT
    reads, writes = ("force_N",), ("force_N",)
    strength = "fraction"
    look = "in a hold the force reading creeps while the conductance holds; after a release zero is off"

    fraction: float = parameter(0.02, unit="1", low=-0.3, high=0.3, doc="share of the load by which it creeps")
    tau_s: float = parameter(300.0, unit="s", low=5, high=1e4, scale="log", doc="time constant of the creep")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        force_N = signals["force_N"]
        return {"force_N": force_N + self.fraction * (lowpass(force_N, self.tau_s, dt_s) - force_N[0])}


class LoadCellCreepLog(Effect):
    """The load cell's reading creeps with the logarithm of time.

    reading(t) = integral of (1 + per_decade log10(1 + (t - s) / tau)) dF(s)

    Source: OIML R 60; the logarithm is the common form of anelastic after-effects.
    Valid: as `load_cell_creep`.
    """

    name = "load_cell_creep_log"
    idea = "load_cell_creep"
    cost = 0.1  # data sheets promise hundredths of a per cent
    stage = Stage.READOUT
    reads, writes = ("force_N",), ("force_N",)
    strength = "per_decade"
    look = "in a hold the force reading creeps ever more slowly while the conductance holds"

    per_decade: float = parameter(0.01, unit="1", low=-0.1, high=0.1, doc="relative creep per decade of time")
    tau_s: float = parameter(3.0, unit="s", low=0.05, high=300, scale="log", doc="when the creep sets in")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        force_N = signals["force_N"]
        return {"force_N": force_N + memory_of_decades(force_N, self.per_decade, self.tau_s, dt_s)}


class LoadCellZeroDrift(Effect):
    """The zero of the load cell drifts with time, as its bridge warms up.

    reading += drift * (1 - exp(-t / tau))

    Source: warm-up of a bridge; data sheets state zero drift per kelvin.
    Valid: in the reading alone.
    """

    name = "load_cell_zero_drift"
    idea = "load_cell_creep"
    cost = 0.1  # data sheets promise hundredths of a per cent
    stage = Stage.READOUT
    reads, writes = ("time_s", "force_N"), ("force_N",)
    strength = "drift_N"
    look = "the whole force curve is shifted, more and more, at every strain alike"

    drift_N: float = parameter(0.05, unit="N", low=-50, high=50, doc="shift in the end")
    tau_s: float = parameter(600.0, unit="s", low=5, high=1e5, scale="log", doc="time constant")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        return {"force_N": signals["force_N"] - self.drift_N * np.expm1(-signals["time_s"] / self.tau_s)}
