"""What the instruments make of force and conductance."""

from __future__ import annotations

from typing import Any

import numpy as np

from testbench.knit import spectra
from testbench.knit.effect import Effect, FloatArray, Signals, Stage, parameter
from testbench.knit.filters import lowpass, memory, shifted

WEAK_CLIPS = (0.97, 0.99)  # quantiles at which a read-out may clip so rarely that nothing piles up
LINES, LINE_BINS = 3, 4  # lines of a spectrum that are tried, and how wide one is
PILE = 0.04  # share of the samples that makes a pile
RAIL_SHARE, RAIL_OVER_OTHERS = 0.004, 5  # of all samples stand at a rail, and so many times more than elsewhere


class ChannelLag(Effect):
    """The resistance channel is slower than the force channel: a filter in its way.

    tau y' = G - y,   the reading is y

    Source: first-order filter (RC input, averaging converter).
    Valid: the conductance channel lags; see `channel_lag_force` for the other one.
    """

    name = "channel_lag"
    stage = Stage.READOUT
    reads, writes = ("conductance_S",), ("conductance_S",)
    strength = "tau_s"
    nonlinear = True
    look = "conductance comes later than force, so their loop widens with speed"

    tau_s: float = parameter(0.2, unit="s", low=0, high=10, doc="time constant of the filter")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        return {"conductance_S": lowpass(signals["conductance_S"], self.tau_s, dt_s)}


class ChannelLagResistance(Effect):
    """The reading of the resistance, not of the conductance, is filtered: steps up and steps down differ.

    tau y' = R - y,   the reading is 1 / y

    Source: as `channel_lag`, for an ohmmeter that averages.
    Valid: the resistance channel lags; told from `channel_lag` where the resistance changes a lot within tau.
    """

    name = "channel_lag_resistance"
    idea = "channel_lag"
    stage = Stage.READOUT
    reads, writes = ("conductance_S",), ("conductance_S",)
    strength = "tau_s"
    nonlinear = True
    look = "conductance comes later than force, and later when it rises than when it falls"

    tau_s: float = parameter(0.2, unit="s", low=0, high=10, doc="time constant of the filter")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        return {"conductance_S": 1 / lowpass(1 / signals["conductance_S"], self.tau_s, dt_s)}


class ChannelLagForce(Effect):
    """The force channel is slower than the resistance channel.

    tau y' = F - y,   the reading is y

    Source: as `channel_lag`.
    Valid: load-cell amplifiers average for 12.5 to 100 ms and more.
    """

    name = "channel_lag_force"
    idea = "channel_lag"
    stage = Stage.READOUT
    reads, writes = ("force_N",), ("force_N",)
    strength = "tau_s"
    nonlinear = True
    look = "force comes later than displacement and conductance"

    tau_s: float = parameter(0.2, unit="s", low=0, high=10, doc="time constant of the filter")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        return {"force_N": lowpass(signals["force_N"], self.tau_s, dt_s)}


class ChannelLagDelay(Effect):
    """The resistance channel is late by a fixed time.

    reading(t) = G(t - delay)

    Source: transport delay (buffers, another clock).
    Valid: constant delay.
    """

    name = "channel_lag_delay"
    idea = "channel_lag"
    stage = Stage.READOUT
    reads, writes = ("conductance_S",), ("conductance_S",)
    strength = "delay_s"
    nonlinear = True
    look = "conductance is the same curve, later"

    delay_s: float = parameter(0.2, unit="s", low=0, high=10, doc="delay")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        conductance = signals["conductance_S"]
        now = np.arange(len(conductance)) - self.delay_s / dt_s
        return {"conductance_S": np.interp(now, np.arange(len(conductance)), conductance)}


def _measured_ln(signals: Signals, residual: Signals) -> FloatArray:
    """ln of the conductance as it was measured."""
    return np.log(signals["conductance_S"]) + residual.get("conductance", 0.0)


def _levels(values: FloatArray, side: float) -> list[float]:
    """Levels at which `values` may be clipped, at the top (`side` 1) or at the bottom (-1).

    A clipped reading piles up at one value: where the values of the outer half lie closest together.
    """
    ordered = np.sort(side * values)
    outer = ordered[len(ordered) // 2 :]
    count = max(int(PILE * len(ordered)), 2)
    first = int(np.argmin(outer[count - 1 :] - outer[: len(outer) - count + 1]))
    pile = float(np.median(outer[first : first + count]))
    return [side * level for level in (pile, *(float(np.quantile(ordered, q)) for q in WEAK_CLIPS))]


def _rail(values: FloatArray, side: float) -> float | None:
    """The value where `values` stand exactly, and which hardly any pass on this side; None where there is none.

    A few pass it: samples beside a corner are moved onto the time grid along their slope.
    """
    ordered = np.sort(side * values)
    step = 1e-9 * max(float(np.ptp(ordered)), 1e-300)
    starts = np.flatnonzero(np.r_[True, np.diff(ordered) > step])
    runs = np.diff(np.r_[starts, len(ordered)])
    at = int(np.argmax(runs))
    others = np.max(np.delete(runs, at), initial=1)
    beyond = len(ordered) - starts[at] - runs[at]
    standing = runs[at] > max(RAIL_SHARE * len(ordered), RAIL_OVER_OTHERS * others, RAIL_OVER_OTHERS * beyond)
    return float(side * ordered[starts[at]]) if standing else None


class AdcSaturation(Effect):
    """The converter cannot read resistances below a floor: conductance is clipped at the top.

    R = max(R, floor)

    Source: full scale of a converter behind a divider, as in Texas Instruments' ADS1115 data sheet.
    Valid: a hard corner in the reading alone; the force goes on.
    """

    name = "adc_saturation"
    stage = Stage.READOUT
    reads, writes = ("conductance_S",), ("conductance_S",)
    strength = "floor_ohm"
    nonlinear = True
    imitated_by = "contact"
    look = "conductance is cut off flat at the top, at exactly one value"

    floor_ohm: float = parameter(1e4, unit="ohm", low=0, high=1e12, doc="smallest resistance that can be read")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        top_S = 1 / self.floor_ohm if self.floor_ohm > 0 else np.inf
        return {"conductance_S": np.minimum(signals["conductance_S"], top_S)}

    def initial_guess(self, signals: Signals, dt_s: float) -> Effect:
        if "conductance_S" not in signals:
            return self
        return self.near(floor_ohm=float(1 / np.quantile(signals["conductance_S"], 0.95)))

    def data_grid(self, signals: Signals, residual: Signals, dt_s: float) -> list[dict[str, Any]]:
        return [{"floor_ohm": float(np.exp(-level))} for level in _levels(_measured_ln(signals, residual), 1.0)]

    def seen(self, signals: Signals, residual: Signals, dt_s: float) -> Effect | None:
        level = _rail(_measured_ln(signals, residual), 1.0)
        return None if level is None else self.near(floor_ohm=np.exp(-level))


class AdcSaturationHigh(Effect):
    """The converter cannot read resistances above a ceiling: conductance is cut off at the bottom.

    G = max(G, floor)

    Source: as `adc_saturation`.
    Valid: a hard corner in the reading alone.
    """

    name = "adc_saturation_high"
    idea = "adc_saturation"
    stage = Stage.READOUT
    reads, writes = ("conductance_S",), ("conductance_S",)
    strength = "floor_S"
    nonlinear = True
    imitated_by = "contact"
    look = "conductance is cut off flat at the bottom, at exactly one value"

    floor_S: float = parameter(1e-6, unit="S", low=0, high=1e6, doc="smallest conductance that can be read")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        return {"conductance_S": np.maximum(signals["conductance_S"], self.floor_S)}

    def initial_guess(self, signals: Signals, dt_s: float) -> Effect:
        if "conductance_S" not in signals:
            return self
        return self.near(floor_S=float(np.quantile(signals["conductance_S"], 0.05)))

    def data_grid(self, signals: Signals, residual: Signals, dt_s: float) -> list[dict[str, Any]]:
        return [{"floor_S": float(np.exp(level))} for level in _levels(_measured_ln(signals, residual), -1.0)]

    def seen(self, signals: Signals, residual: Signals, dt_s: float) -> Effect | None:
        level = _rail(_measured_ln(signals, residual), -1.0)
        return None if level is None else self.near(floor_S=np.exp(level))


class AdcSaturationSoft(Effect):
    """The amplifier before the converter bends as it nears its rail.

    G = top * s / (1 + s^hardness)^(1 / hardness),   s = G / top,   top = 1 / floor

    Source: output swing near the rail, as amplifier data sheets plot it; `adc_saturation` with a rounded corner.
    Valid: hardness above 12: the bend is confined to the last few per cent below the rail.
    """

    name = "adc_saturation_soft"
    idea = "adc_saturation"
    stage = Stage.READOUT
    reads, writes = ("conductance_S",), ("conductance_S",)
    strength = "floor_ohm"
    nonlinear = True
    imitated_by = "contact"
    look = "conductance flattens out within the last few per cent below one value"

    floor_ohm: float = parameter(1e4, unit="ohm", low=0, high=1e12, doc="smallest resistance that can be read")
    hardness: float = parameter(30.0, unit="1", low=12, high=200, scale="log", doc="sharpness of the corner")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        conductance = signals["conductance_S"]
        load = np.log(np.maximum(conductance * self.floor_ohm, 1e-12))
        return {"conductance_S": conductance * np.exp(-np.logaddexp(0.0, self.hardness * load) / self.hardness)}

    def data_grid(self, signals: Signals, residual: Signals, dt_s: float) -> list[dict[str, Any]]:
        tops_S = np.exp(_levels(_measured_ln(signals, residual), 1.0))
        return [{"floor_ohm": float(1 / top_S), "hardness": h} for top_S in tops_S for h in (20.0, 60.0)]


class AdcSaturationForce(Effect):
    """The load cell's amplifier saturates: the force reading is cut off at the top.

    F = min(F, 1 / inverse_range)

    Source: as `adc_saturation`.
    Valid: a hard corner in the reading alone; the conductance goes on.
    """

    name = "adc_saturation_force"
    idea = "adc_saturation"
    stage = Stage.READOUT
    reads, writes = ("force_N",), ("force_N",)
    strength = "inverse_range_per_N"
    nonlinear = True
    imitated_by = "elasticity"
    look = "force is cut off flat at the top, at exactly one value"

    inverse_range_per_N: float = parameter(0.3, unit="1/N", low=0, high=1e4, doc="inverse of the largest reading")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        top_N = 1 / self.inverse_range_per_N if self.inverse_range_per_N > 0 else np.inf
        return {"force_N": np.minimum(signals["force_N"], top_N)}

    def initial_guess(self, signals: Signals, dt_s: float) -> Effect:
        if "force_N" not in signals:
            return self
        return self.near(inverse_range_per_N=1 / max(float(np.quantile(signals["force_N"], 0.95)), 1e-3))

    def data_grid(self, signals: Signals, residual: Signals, dt_s: float) -> list[dict[str, Any]]:
        tops_N = _levels(signals["force_N"] + residual.get("force", 0.0), 1.0)
        return [{"inverse_range_per_N": 1 / top_N} for top_N in tops_N if top_N > 1e-3]

    def seen(self, signals: Signals, residual: Signals, dt_s: float) -> Effect | None:
        top_N = _rail(signals["force_N"] + residual["force"], 1.0) if "force" in residual else None
        return None if top_N is None or top_N <= 0 else self.near(inverse_range_per_N=1 / top_N)


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
        times, weights = spectra.logarithm(self.tau_s)
        gained = memory(signals["force_N"], times, self.per_decade / np.log(10) * weights, dt_s)
        return {"force_N": signals["force_N"] + gained}


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


class PeriodicInterference(Effect):
    """A periodic disturbance rides on the conductance: mains hum folded down by sampling, a pump, a motor.

    G *= 1 + amplitude * sin(2 pi f t + phase)

    Source: superposition; aliasing after Shannon's sampling theorem.
    Valid: one stable frequency below half the sampling rate; in phase with the clock, not with the motion.
    """

    name = "periodic_interference"
    stage = Stage.READOUT
    quick = True
    reads, writes = ("time_s", "conductance_S"), ("conductance_S",)
    strength = "amplitude"
    per_recording = ("phase_rad",)
    look = "a sine rides on the conductance, in holds too; a sharp line in the spectrum"

    amplitude: float = parameter(0.01, unit="1", low=0, high=0.5, doc="relative amplitude")
    frequency_Hz: float = parameter(1.0, unit="Hz", low=0.02, high=20, scale="log", doc="frequency as sampled")
    phase_rad: float = parameter(0.0, unit="rad", low=-3.2, high=3.2, doc="phase at the start")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        wave = np.sin(2 * np.pi * self.frequency_Hz * signals["time_s"] + self.phase_rad)
        return {"conductance_S": signals["conductance_S"] * (1 + self.amplitude * wave)}

    def initial_guess(self, signals: Signals, dt_s: float) -> Effect:
        if "conductance_S" not in signals:
            return self
        return self.near(frequency_Hz=strongest_frequency_Hz(np.log(signals["conductance_S"]), dt_s))

    def data_grid(self, signals: Signals, residual: Signals, dt_s: float) -> list[dict[str, Any]]:
        return _waves(residual.get("conductance"), dt_s)


class PeriodicInterferenceWave(PeriodicInterference):
    """A periodic disturbance that is no pure sine rides on the conductance.

    ln G += amplitude * (sin(a) + second * sin(2 a) + third * sin(3 a)),   a = 2 pi f t + phase

    Source: Fourier series, three terms; as `periodic_interference`.
    Valid: one stable frequency, its third harmonic below half the sampling rate.
    """

    name = "periodic_interference_wave"
    idea = "periodic_interference"
    look = "a wave of fixed shape rides on the conductance, in holds too; lines at multiples of one frequency"

    amplitude: float = parameter(0.01, unit="1", low=0, high=0.5, doc="amplitude of the first harmonic in ln G")
    second: float = parameter(0.0, unit="1", low=-2, high=2, doc="second harmonic over the first")
    third: float = parameter(0.0, unit="1", low=-2, high=2, doc="third harmonic over the first")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        angle = 2 * np.pi * self.frequency_Hz * signals["time_s"] + self.phase_rad
        wave = np.sin(angle) + self.second * np.sin(2 * angle) + self.third * np.sin(3 * angle)
        return {"conductance_S": shifted(signals["conductance_S"], self.amplitude * wave)}


class PeriodicInterferenceForce(Effect):
    """A periodic disturbance rides on the force reading.

    F += amplitude * sin(2 pi f t + phase)

    Source: as `periodic_interference`.
    Valid: one stable frequency below half the sampling rate.
    """

    name = "periodic_interference_force"
    idea = "periodic_interference"
    stage = Stage.READOUT
    quick = True
    reads, writes = ("time_s", "force_N"), ("force_N",)
    strength = "amplitude_N"
    per_recording = ("phase_rad",)
    look = "a sine rides on the force, in holds too; a sharp line in the spectrum"

    amplitude_N: float = parameter(0.02, unit="N", low=0, high=50, doc="amplitude")
    frequency_Hz: float = parameter(1.0, unit="Hz", low=0.02, high=20, scale="log", doc="frequency as sampled")
    phase_rad: float = parameter(0.0, unit="rad", low=-3.2, high=3.2, doc="phase at the start")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        wave = np.sin(2 * np.pi * self.frequency_Hz * signals["time_s"] + self.phase_rad)
        return {"force_N": signals["force_N"] + self.amplitude_N * wave}

    def initial_guess(self, signals: Signals, dt_s: float) -> Effect:
        if "force_N" not in signals:
            return self
        return self.near(frequency_Hz=strongest_frequency_Hz(signals["force_N"], dt_s))

    def data_grid(self, signals: Signals, residual: Signals, dt_s: float) -> list[dict[str, Any]]:
        return _waves(residual.get("force"), dt_s)


def _waves(residual: FloatArray | None, dt_s: float) -> list[dict[str, Any]]:
    """The sharpest lines of the residual, in and out of phase: together they reach any phase."""
    if residual is None:
        return []
    lines_Hz = sharpest_lines_Hz(residual, dt_s, LINES)
    phases = (-np.pi / 2, 0.0, np.pi / 2, np.pi)
    return [{"frequency_Hz": frequency, "phase_rad": phase} for frequency in lines_Hz for phase in phases]


def strongest_frequency_Hz(x: FloatArray, dt_s: float) -> float:
    """Frequency of the sharpest line of `x`, above 0.02 Hz and below 20 Hz: the peak over its surroundings."""
    return sharpest_lines_Hz(x, dt_s, 1)[0]


def sharpest_lines_Hz(x: FloatArray, dt_s: float, most: int) -> list[float]:
    """Frequencies of the lines of `x` that stand out most from their surroundings, the sharpest first."""
    from scipy.ndimage import median_filter

    power = np.abs(np.fft.rfft((x - x.mean()) * np.hanning(len(x)))) ** 2
    frequency = np.fft.rfftfreq(len(x), dt_s)
    contrast = power / np.maximum(median_filter(power, size=51), 1e-300)
    contrast[(frequency <= 0.02) | (frequency >= 20)] = 0.0
    if not contrast.any():
        return [1.0]
    found: list[float] = []
    while len(found) < most and contrast.any():
        at = int(np.argmax(contrast))
        found.append(_refined(x - x.mean(), dt_s, float(frequency[at])))
        contrast[max(at - LINE_BINS, 0) : at + LINE_BINS + 1] = 0.0
    return found


def _refined(x: FloatArray, dt_s: float, near_Hz: float) -> float:
    """The frequency at which the power is largest, within one bin of the spectrum around `near_Hz`.

    A bin is one cycle a recording; a frequency off by half a bin is out of phase at both ends.
    """
    from scipy.optimize import minimize_scalar

    t = np.arange(len(x)) * dt_s
    bin_Hz = 1 / (len(x) * dt_s)

    def minus_power(hz: float) -> float:
        return -abs(np.exp(-2j * np.pi * hz * t) @ x)

    fine = np.linspace(near_Hz - bin_Hz, near_Hz + bin_Hz, 9)
    best = fine[np.argmin([minus_power(hz) for hz in fine])]
    step = bin_Hz / 4
    return float(minimize_scalar(minus_power, bounds=(best - step, best + step), method="bounded").x)
