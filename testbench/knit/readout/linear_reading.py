"""Instruments that are linear: they read a small change as they read the whole."""

from __future__ import annotations

from testbench.knit.effect import Effect, FloatArray, Signals, Stage
from testbench.knit.filters import log_conductance, shifted


class LinearReading(Effect):
    """Base of the laws of an instrument whose reading, in N or ln S, is linear in what it reads."""

    stage = Stage.READOUT

    def read(self, values: FloatArray, time_s: FloatArray) -> FloatArray:
        """What is read of `values`, shape (..., n): force in N, conductance in ln S."""
        raise NotImplementedError

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        (signal,), time_s = self.writes, signals["time_s"]
        if signal == "conductance_S":
            log_g = log_conductance(signals[signal])
            return {signal: shifted(signals[signal], self.read(log_g, time_s) - log_g)}
        return {signal: self.read(signals[signal], time_s)}
