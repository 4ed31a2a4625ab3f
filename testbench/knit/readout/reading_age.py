"""Readings are a little older than the displacement beside them: a part of the base, for every rig has it."""

from __future__ import annotations

import numpy as np

from testbench.knit.effect import FloatArray, parameter
from testbench.knit.readout.linear_reading import LinearReading


class ReadingAge(LinearReading):
    """Base of the two: a reading is that of a few milliseconds ago."""

    in_base = True

    age_s: float = parameter(0.0, unit="s", low=-0.015, high=0.015, typical=0.01, doc="mean age of the reading")

    def read(self, values: FloatArray, time_s: FloatArray) -> FloatArray:
        """The values a little earlier: less their slope, from the neighbours of each sample, times the age."""
        if values.shape[-1] < 3:
            return values.copy()
        earlier = np.empty_like(values)
        np.subtract(values[..., 2:], values[..., :-2], out=earlier[..., 1:-1])
        earlier[..., 1:-1] *= -self.age_s / (time_s[2:] - time_s[:-2])
        earlier[..., 0], earlier[..., -1] = earlier[..., 1], earlier[..., -2]
        earlier += values
        return earlier


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
