"""One channel of the reading comes later than the other."""

from __future__ import annotations

from typing import ClassVar

from testbench.knit.effect import Effect, FloatArray, Signals, Stage, parameter
from testbench.knit.filters import lowpass


class ChannelLagLaw(Effect):
    """Base of the laws of a reading that comes late: of the signal, or (`of_resistance`) of its inverse.

    What is not late at all is as it was.
    """

    mechanism = "channel_lag"
    stage = Stage.READOUT
    reads, writes = ("conductance_S",), ("conductance_S",)
    strength = "tau_s"
    nonlinear = True
    of_resistance: ClassVar[bool] = False

    def late(self, x: FloatArray, dt_s: float) -> FloatArray:
        """What is read of a signal, shape (n,)."""
        raise NotImplementedError

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        (signal,) = self.writes
        if not self.of_resistance:
            return {signal: self.late(signals[signal], dt_s)}
        ohm = 1 / signals[signal]
        return {signal: signals[signal] * (ohm / self.late(ohm, dt_s))}


class ChannelLag(ChannelLagLaw):
    """The resistance channel is slower than the force channel: a filter in its way.

    tau y' = G - y,   the reading is y

    Source: first-order filter (RC input, averaging converter).
    Valid: the conductance channel lags; see `channel_lag_force` for the other one.
    """

    name = "channel_lag"
    look = "conductance comes later than force, so their loop widens with speed"

    tau_s: float = parameter(0.2, unit="s", low=0, high=10, typical=0.1, doc="time constant of the filter")

    def late(self, x: FloatArray, dt_s: float) -> FloatArray:
        return lowpass(x, self.tau_s, dt_s)


class ChannelLagResistance(ChannelLag):
    """The reading of the resistance, not of the conductance, is filtered: steps up and steps down differ.

    tau y' = R - y,   the reading is 1 / y

    Source: as `channel_lag`, for an ohmmeter that averages.
    Valid: the resistance channel lags; told from `channel_lag` where the resistance changes a lot within tau.
    """

    name = "channel_lag_resistance"
    of_resistance = True
    look = "conductance comes later than force, and later when it rises than when it falls"


class ChannelLagTwoFilters(ChannelLagLaw):
    """The resistance channel has two filters, one after the other: it starts to follow late, and then quickly.

    tau_1 y' = R - y,   tau_2 z' = y - z,   the reading is 1 / z,   tau_1 + tau_2 = tau,   tau_2 = second * tau_1

    Source: an RC input before a converter that averages, or two equal stages of a digital filter (Oppenheim &
    Schafer, Discrete-Time Signal Processing, 2010, ch. 7).
    Valid: the resistance channel lags.
    """

    name = "channel_lag_two_filters"
    of_resistance = True
    look = "conductance comes later than force, and its turns are rounder"

    tau_s: float = parameter(0.2, unit="s", low=0, high=10, typical=0.1, doc="sum of the two time constants")
    second: float = parameter(0.5, unit="1", low=0.05, high=1, doc="second time constant over the first")

    def late(self, x: FloatArray, dt_s: float) -> FloatArray:
        first_s = self.tau_s / (1 + self.second)
        return lowpass(lowpass(x, first_s, dt_s), self.second * first_s, dt_s)


class ChannelLagForce(ChannelLag):
    """The force channel is slower than the resistance channel.

    tau y' = F - y,   the reading is y

    Source: as `channel_lag`.
    Valid: load-cell amplifiers average for 12.5 to 100 ms and more.
    """

    name = "channel_lag_force"
    reads, writes = ("force_N",), ("force_N",)
    look = "force comes later than displacement and conductance"


class ChannelLagForceTwoFilters(ChannelLagTwoFilters):
    """The force channel has two filters, one after the other: it starts to follow late, and then quickly.

    tau_1 y' = F - y,   tau_2 z' = y - z,   the reading is z,   tau_1 + tau_2 = tau,   tau_2 = second * tau_1

    Source: as `channel_lag_two_filters`.
    Valid: load-cell amplifiers with a filter of their own, before a converter that averages.
    """

    name = "channel_lag_force_two_filters"
    of_resistance = False
    reads, writes = ("force_N",), ("force_N",)
    look = "force comes later than displacement and conductance, and its turns are rounder"


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

    def late(self, x: FloatArray, dt_s: float) -> FloatArray:
        from testbench.knit.memories import delayed

        return delayed(x, self.delay_s, dt_s)


class ChannelLagForceDelay(ChannelLagDelay):
    """The force channel is late by a fixed time.

    reading(t) = F(t - delay)

    Source: as `channel_lag_delay`.
    Valid: constant delay.
    """

    name = "channel_lag_force_delay"
    reads, writes = ("force_N",), ("force_N",)
    look = "force is the same curve, later"
