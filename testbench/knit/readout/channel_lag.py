"""One channel of the reading comes later than the other."""

from __future__ import annotations

import numpy as np

from testbench.knit.effect import Effect, FloatArray, Signals, Stage, parameter
from testbench.knit.filters import lowpass


class ChannelLagLaw(Effect):
    """Base of the laws of a reading that comes late."""

    mechanism = "channel_lag"
    stage = Stage.READOUT
    reads, writes = ("conductance_S",), ("conductance_S",)
    strength = "tau_s"
    nonlinear = True


class ChannelLag(ChannelLagLaw):
    """The resistance channel is slower than the force channel: a filter in its way.

    tau y' = G - y,   the reading is y

    Source: first-order filter (RC input, averaging converter).
    Valid: the conductance channel lags; see `channel_lag_force` for the other one.
    """

    name = "channel_lag"
    look = "conductance comes later than force, so their loop widens with speed"

    tau_s: float = parameter(0.2, unit="s", low=0, high=10, typical=0.1, doc="time constant of the filter")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        return {"conductance_S": lowpass(signals["conductance_S"], self.tau_s, dt_s)}


class ChannelLagResistance(ChannelLagLaw):
    """The reading of the resistance, not of the conductance, is filtered: steps up and steps down differ.

    tau y' = R - y,   the reading is 1 / y

    Source: as `channel_lag`, for an ohmmeter that averages.
    Valid: the resistance channel lags; told from `channel_lag` where the resistance changes a lot within tau.
    """

    name = "channel_lag_resistance"
    look = "conductance comes later than force, and later when it rises than when it falls"

    tau_s: float = parameter(0.2, unit="s", low=0, high=10, typical=0.1, doc="time constant of the filter")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        return {"conductance_S": 1 / lowpass(1 / signals["conductance_S"], self.tau_s, dt_s)}


class ChannelLagForce(ChannelLagLaw):
    """The force channel is slower than the resistance channel.

    tau y' = F - y,   the reading is y

    Source: as `channel_lag`.
    Valid: load-cell amplifiers average for 12.5 to 100 ms and more.
    """

    name = "channel_lag_force"
    reads, writes = ("force_N",), ("force_N",)
    look = "force comes later than displacement and conductance"

    tau_s: float = parameter(0.2, unit="s", low=0, high=10, typical=0.1, doc="time constant of the filter")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        return {"force_N": lowpass(signals["force_N"], self.tau_s, dt_s)}


class ChannelLagDelay(ChannelLagLaw):
    """The resistance channel is late by a fixed time.

    reading(t) = G(t - delay)

    Source: transport delay (buffers, another clock).
    Valid: constant delay.
    """

    name = "channel_lag_delay"
    strength = "delay_s"
    look = "conductance is the same curve, later"

    delay_s: float = parameter(0.2, unit="s", low=0, high=10, typical=0.1, doc="delay")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        conductance = signals["conductance_S"]
        now = np.arange(len(conductance)) - self.delay_s / dt_s
        return {"conductance_S": np.interp(now, np.arange(len(conductance)), conductance)}
