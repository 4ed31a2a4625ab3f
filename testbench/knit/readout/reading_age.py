"""Readings are a little older than the displacement beside them: a part of the base, for every rig has it."""

from __future__ import annotations

import numpy as np

from testbench.knit.effect import Effect, FloatArray, Signals, Stage, parameter
from testbench.knit.filters import log_conductance, shifted


class ReadingAge(Effect):
    """Base of the two: a reading, in N or ln S, is that of a few milliseconds ago, and linear in what is read."""

    in_base = True
    stage = Stage.READOUT

    age_s: float = parameter(0.0, unit="s", low=-0.015, high=0.015, typical=0.01, doc="mean age of the reading")

    def read(self, values: FloatArray, time_s: FloatArray) -> FloatArray:
        """`values`, shape (..., n), a little earlier: less their slope, from both neighbours, times the age."""
        if values.shape[-1] < 3:
            return values.copy()
        earlier = np.empty_like(values)
        np.subtract(values[..., 2:], values[..., :-2], out=earlier[..., 1:-1])
        earlier[..., 1:-1] *= -self.age_s / (time_s[2:] - time_s[:-2])
        earlier[..., 0], earlier[..., -1] = earlier[..., 1], earlier[..., -2]
        earlier += values
        return earlier

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        (signal,), time_s = self.writes, signals["time_s"]
        if signal == "conductance_S":
            log_g = log_conductance(signals[signal])
            return {signal: shifted(signals[signal], self.read(log_g, time_s) - log_g)}
        return {signal: self.read(signals[signal], time_s)}


class ForceAge(ReadingAge):
    """The force in a row of the recording is a few milliseconds older than the displacement in it.

    reading(t) = F(t) - age * dF/dt

    Source: Texas Instruments ADS1231 data sheet (SBAS414): at 80 SPS the last finished conversion is 6 ms old on
    average. A displacement that comes from the controller may be older than the force: then the age is negative.
    Valid: short against the motion; for more see `channel_lag_force`.
    """

    name = "force_age"
    reads, writes = ("time_s", "force_N"), ("force_N",)
    look = "a loop of the force that widens with the speed, by milliseconds"


class ConductanceAge(ReadingAge):
    """The resistance in a row of the recording is a few milliseconds older than the displacement in it.

    ln reading(t) = ln G(t) - age * d(ln G)/dt

    Source: Texas Instruments ADS1115 data sheet (SBAS444): conversions that are averaged over 25 ms are 12 ms old.
    Valid: short against the motion; for more see `channel_lag`.
    """

    name = "conductance_age"
    reads, writes = ("time_s", "conductance_S"), ("conductance_S",)
    look = "a loop of the conductance that widens with the speed, by milliseconds"
