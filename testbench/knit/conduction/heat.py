"""Temperature: the sensor's own heat and the room's."""

from __future__ import annotations

import numpy as np

from testbench.knit.additive import ConductanceLaw, ForceFactor
from testbench.knit.effect import Effect, FloatArray, Points, Signals, Vector, parameter, zeros
from testbench.knit.filters import lowpass

WANDER_STEPS = 21
ROOM_S = 60.0  # in which the air of a room, and a yarn in it, can follow a door or a heater
HEATING_S = (3.0, 10.0, 30.0, 100.0, 300.0, 1000.0)


def _coefficient(power: str) -> float:
    return parameter(
        -0.02, unit="1", low=-2, high=2, doc=f"change of ln G in the end at the {power} power; < 0 for metals"
    )


class SelfHeatingLaw(ConductanceLaw):
    """Base of the laws of a sensor that its measuring current warms."""

    mechanism = "self_heating"
    reads = ("conductance_S",)
    strength = "coefficient"


class OneMass(SelfHeatingLaw):
    """Base of the laws of a sensor that warms as one mass: ln G += coefficient * y,   tau y' = power - y."""

    coefficient: float = _coefficient("starting")
    tau_s: float = parameter(60.0, unit="s", low=1, high=3000, scale="log", doc="thermal time constant")

    def power(self, conductance_S: FloatArray) -> FloatArray:
        """Heat in the sensor, over that at the coefficient, shape (n,)."""
        raise NotImplementedError

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        return self.coefficient * lowpass(self.power(signals["conductance_S"]), self.tau_s, dt_s, start=0.0)


class SelfHeating(OneMass):
    """The measuring current warms the sensor; at constant voltage the more, the better it conducts.

    ln G += coefficient * y,   tau y' = G / G(0) - y,   y(0) = 0: cold when switched on

    Source: Joule's law with one thermal mass; Holm, Electric Contacts (1967) (temperature of heated contacts).
    Valid: small temperature rise (the feedback of the heat on the power is left out).
    """

    name = "self_heating"
    look = "conductance drifts after switching on and after each change of the mean stretch"

    def power(self, conductance_S: FloatArray) -> FloatArray:
        return conductance_S / conductance_S[0]


class SelfHeatingTwoMasses(SelfHeatingLaw):
    """The measuring current warms the yarn at once and the fabric around it slowly.

    ln G += coefficient * (share * y_1 + (1 - share) * y_2),   tau_k y_k' = G / G(0) - y_k,   y_k(0) = 0
    tau_1 = fast,   tau_2 = max(slow, fast)

    Source: as `self_heating`, with two thermal masses.
    Valid: small temperature rise; constant voltage.
    """

    name = "self_heating_two_masses"
    look = "conductance comes back within seconds after each change of the stretch, and drifts for minutes besides"

    coefficient: float = _coefficient("starting")
    fast_s: float = parameter(12.0, unit="s", low=1, high=100, scale="log", doc="thermal time constant of the yarn")
    slow_s: float = parameter(300.0, unit="s", low=30, high=3000, scale="log", doc="that of the fabric")
    share: float = parameter(0.5, unit="1", low=0, high=1, doc="share of the yarn")

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        power = signals["conductance_S"] / signals["conductance_S"][0]
        taus_s = self.fast_s, max(self.slow_s, self.fast_s)  # in the other order two points would be one law
        yarn, fabric = (lowpass(power, tau_s, dt_s, start=0.0) for tau_s in taus_s)
        return self.coefficient * (self.share * yarn + (1 - self.share) * fabric)

    def starts(self, signals: Signals, residual: Signals) -> Points:
        return [{"fast_s": fast_s, "slow_s": slow_s} for fast_s in (4.0, 12.0, 30.0) for slow_s in (150.0, 500.0)]


class SelfHeatingProny(SelfHeatingLaw):
    """The measuring current warms the yarn, the fabric and all around it, each in its own time.

    ln G += sum_k w_k y_k,   tau_k y_k' = G / G(0) - y_k,   y_k(0) = 0,   tau_k = 3, 10, 30, ... 1000 s

    Source: as `self_heating`, with a chain of thermal masses (Foster's form: one exponential for each).
    Valid: small temperature rise; constant voltage.
    """

    name = "self_heating_prony"
    strength = "weights"
    look = "conductance drifts after switching on and after each change of the mean stretch, over whatever times"

    weights: Vector = zeros(len(HEATING_S), unit="1", most=2, doc="change of ln G in the end, at starting power")

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        power = signals["conductance_S"] / signals["conductance_S"][0]
        warmth = (
            w * lowpass(power, tau_s, dt_s, start=0.0) for w, tau_s in zip(self.weights, HEATING_S, strict=True) if w
        )
        return sum(warmth, np.zeros_like(power))


class SelfHeatingCurrent(OneMass):
    """The measuring current warms the sensor; at constant current the more, the worse it conducts.

    ln G += coefficient * y,   tau y' = G(0) / G - y,   y(0) = 0: cold when switched on

    Source: as `self_heating`.
    Valid: a current source, as in four-wire measurement.
    """

    name = "self_heating_current"
    look = "conductance drifts after switching on and after each change of the mean stretch"

    def power(self, conductance_S: FloatArray) -> FloatArray:
        return conductance_S[0] / conductance_S


class SelfHeatingDivider(OneMass):
    """The measuring current warms the sensor of a voltage divider: most where it matches the fixed resistor.

    ln G += coefficient * y,   tau y' = 4 q / (1 + q)^2 - y,   q = match * G(0) / G,   y(0) = 0

    Source: power in one resistor of a divider, V^2 R / (R + R_d)^2, relative to its largest value, at R = R_d.
    Valid: small temperature rise (the feedback of the heat on the power is left out).
    """

    name = "self_heating_divider"
    look = "conductance drifts after switching on and after each change of the mean stretch, up or down"

    coefficient: float = _coefficient("largest")
    match: float = parameter(1.0, unit="1", low=0.02, high=50, scale="log", doc="R(0) / R_d")

    def power(self, conductance_S: FloatArray) -> FloatArray:
        ratio = self.match * conductance_S[0] / conductance_S
        return 4 * ratio / (1 + ratio) ** 2

    def starts(self, signals: Signals, residual: Signals) -> Points:
        conductance, end_s = signals["conductance_S"], float(signals["time_s"][-1])
        # matched at the middle, the top and the bottom of what the sensor shows
        matches = [float(np.quantile(conductance, q) / conductance[0]) for q in (0.1, 0.5, 0.9)]
        taus_s = [share * end_s for share in (0.01, 0.05, 0.2)]
        return [{"match": match, "tau_s": tau_s} for match in matches for tau_s in taus_s]


class FollowsRoom(Effect):
    """Base of the laws that follow the room: as a thermometer says, with a lag, or by a swing of 1 K where none does.

    When a room swings, how far and how fast is another matter on each day; how the sensor follows it is not.
    """

    optional_reads = ("temperature_C",)
    per_recording = ("phase_rad",)

    lag_s: float = parameter(1.0, unit="s", low=0.1, high=3000, scale="log", doc="lag behind the thermometer")
    period_s: float = parameter(
        1500.0, unit="s", low=300, high=2e5, scale="log", doc="period of the swing where nothing was measured"
    )
    phase_rad: float = parameter(0.0, unit="rad", low=-6.3, high=6.3, doc="phase of the swing at the start")

    def of_one_recording(self, signals: Signals) -> tuple[str, ...]:
        return () if "temperature_C" in signals else (*self.per_recording, self.strength, "period_s")

    def warmer_K(self, signals: Signals, dt_s: float) -> FloatArray:
        """How much warmer it is than at the start, shape (n,)."""
        measured = signals.get("temperature_C")
        if measured is not None:
            return lowpass(measured, self.lag_s, dt_s) - measured[0]
        angle = 2 * np.pi * signals["time_s"] / self.period_s + self.phase_rad
        return np.sin(angle) - np.sin(self.phase_rad)


class RoomLaw(ConductanceLaw):
    """Base of the laws of a conductance that follows the temperature of the room."""

    mechanism = "temperature_drift"
    reads = ("time_s", "conductance_S")


class TemperatureDrift(FollowsRoom, RoomLaw):
    """The conductance follows the temperature of the room.

    ln G += coefficient * (T - T(0))        T: measured `temperature_C`, followed with the lag `lag_s`
    ln G += coefficient * swing(t)          without: swing = 1 K * sin(2 pi t / period + phase)

    Source: definition of the temperature coefficient (IEC 60115-1); the sine stands for a room's thermostat or day.
    Valid: a few kelvin. Without a channel it can imitate any slow drift: measure the temperature.
    """

    name = "temperature_drift"
    strength = "coefficient_per_K"
    look = "conductance wanders slowly, with the room and not with the motion"

    coefficient_per_K: float = parameter(0.01, unit="1/K", low=-0.3, high=0.3, doc="change of ln G per kelvin")

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        return self.coefficient_per_K * self.warmer_K(signals, dt_s)


class TemperatureDriftTrend(RoomLaw):
    """An unmeasured room that warms (or cools) steadily.

    ln G += coefficient * t / 1 h        (1 K per hour)

    Source: as `temperature_drift`.
    Valid: recordings shorter than the room's own rhythm.
    """

    name = "temperature_drift_trend"
    strength = "coefficient_per_h"
    look = "conductance drifts at a steady pace from the first to the last minute"

    coefficient_per_h: float = parameter(0.02, unit="1/h", low=-2, high=2, doc="change of ln G per hour")

    def of_one_recording(self, signals: Signals) -> tuple[str, ...]:
        return (self.strength,)

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        return self.coefficient_per_h * signals["time_s"] / 3600


class TemperatureDriftWander(RoomLaw):
    """An unmeasured room whose temperature wanders slowly, in its own way in each recording.

    ln G += sum_j (w_1 + ... + w_j) B_j(t / duration)

    A random walk: the room goes on from where it is, by steps of one size. They are as far apart as the recording
    allows, but never closer than a minute: air and yarn warm no faster.

    Source: as `temperature_drift`; penalised splines, Eilers & Marx, Statist. Sci. 11 (1996) 89.
    Valid: wandering over minutes. It can imitate any slow drift: measure the temperature.
    """

    name = "temperature_drift_wander"
    strength = "weights"
    per_recording = ("weights",)
    look = "conductance wanders slowly, differently in every recording, whatever the motion"

    weights: Vector = zeros(WANDER_STEPS, unit="1", most=5, typical=0.01, doc="change of ln G in each step of time")

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        return _wander(signals["time_s"], self.weights, dt_s)


class SofteningLaw(ForceFactor):
    """Base of the laws of a force that follows the temperature of the room."""

    mechanism = "temperature_drift"
    reads = ("time_s", "force_N")


class ThermalSoftening(FollowsRoom, SofteningLaw):
    """Warm yarn is softer: the force follows the temperature of the room.

    F *= max(1 - softening * (T - T(0)), 0)        T: measured `temperature_C`, followed with the lag `lag_s`
    F *= max(1 - softening * swing(t), 0)          without: swing = 1 K * sin(2 pi t / period + phase)

    Source: Ferry, Viscoelastic Properties of Polymers (1980), ch. 11; linearised. The sine as in `temperature_drift`.
    Valid: a few kelvin. Without a channel it can imitate any slow change of stiffness: measure the temperature.
    """

    name = "thermal_softening"
    strength = "softening_per_K"
    look = "force sinks when the room warms"

    softening_per_K: float = parameter(0.005, unit="1/K", low=-0.3, high=0.3, doc="relative loss of force per kelvin")

    def change(self, signals: Signals, dt_s: float) -> FloatArray:
        return np.maximum(1 - self.softening_per_K * self.warmer_K(signals, dt_s), 0.0)


class ThermalSofteningWander(SofteningLaw):
    """Warm yarn is softer, and the room's temperature wanders unmeasured, in its own way in each recording.

    F *= exp( sum_j (w_1 + ... + w_j) B_j(t / duration) )

    Source: as `thermal_softening`; splines as in `temperature_drift_wander`.
    Valid: as `temperature_drift_wander`. It can imitate any slow change of stiffness: measure the temperature.
    """

    name = "thermal_softening_wander"
    strength = "weights"
    per_recording = ("weights",)
    look = "the knit is now softer, now stiffer, differently in every recording, whatever the motion"

    weights: Vector = zeros(WANDER_STEPS, unit="1", most=2, typical=0.0025, doc="change of ln F in each step of time")

    def change(self, signals: Signals, dt_s: float) -> FloatArray:
        return np.exp(_wander(signals["time_s"], self.weights, dt_s))


def _wander(time_s: FloatArray, steps: tuple[float, ...], dt_s: float) -> FloatArray:
    """A smooth curve from zero on, shape (n,); steps closer than a room can change stay unused."""
    from testbench.knit.shapes.splines import bspline

    duration_s = max(time_s[-1], dt_s)
    used = int(np.clip(2 + duration_s / ROOM_S, 3, len(steps)))  # cubic: three more bumps than spans
    heights = np.cumsum([0.0, *steps[:used]])
    wandered = bspline(time_s / duration_s, heights)
    return wandered - wandered[0]
