"""Periodic disturbances that ride on a reading, in phase with the clock and not with the motion."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from testbench.knit.effect import Effect, FloatArray, Points, Signals, Stage, Vector, parameter, step_s
from testbench.knit.filters import shifted
from testbench.knit.shapes.waves import harmonics_parameter, wave_of

LINES, LINE_BINS = 3, 4  # lines of a spectrum that are tried, and how wide one is


class InterferenceLaw(Effect):
    """Base of the laws of a periodic disturbance that rides on a reading, in phase with the clock."""

    mechanism = "periodic_interference"
    stage = Stage.READOUT
    reads, writes = ("time_s", "conductance_S"), ("conductance_S",)
    pointwise = ("conductance_S",)
    strength = "amplitude"
    per_recording = ("phase_rad",)
    channel: ClassVar[str] = "conductance"  # of the residual

    frequency_Hz: float = parameter(1.0, unit="Hz", low=0.02, high=20, scale="log", doc="frequency as sampled")
    phase_rad: float = parameter(0.0, unit="rad", low=-6.3, high=6.3, doc="phase at the start")

    def angle(self, signals: Signals) -> FloatArray:
        """Of the first harmonic, shape (n,), in rad."""
        return 2 * np.pi * self.frequency_Hz * signals["time_s"] + self.phase_rad

    def starts(self, signals: Signals, residual: Signals) -> Points:
        """The sharpest lines of the residual, in and out of phase: together they reach any phase."""
        if self.channel not in residual:
            return []
        lines_Hz = sharpest_lines_Hz(residual[self.channel], step_s(signals), LINES)
        phases = (-np.pi / 2, 0.0, np.pi / 2, np.pi)
        return [{"frequency_Hz": frequency, "phase_rad": phase} for frequency in lines_Hz for phase in phases]

    def unfolded(self, grid_Hz: float, highest_Hz: float) -> list[Effect]:
        """Its aliases, each at the phases of an eighth of a turn."""
        folds = np.arange(1, int(highest_Hz / grid_Hz) + 2) * grid_Hz
        aliases = [f for f in np.r_[folds - self.frequency_Hz, folds + self.frequency_Hz] if 0 < f < highest_Hz]
        phases = np.linspace(-np.pi, np.pi, 8, endpoint=False)
        return [self.near(frequency_Hz=float(f), phase_rad=float(phase)) for f in aliases for phase in phases]


class PeriodicInterference(InterferenceLaw):
    """A periodic disturbance rides on the conductance: mains hum folded down by sampling, a pump, a motor.

    G *= 1 + amplitude * sin(2 pi f t + phase)

    Source: superposition; aliasing after Shannon's sampling theorem.
    Valid: one stable frequency below half the sampling rate; in phase with the clock, not with the motion.
    """

    name = "periodic_interference"
    look = "a sine rides on the conductance, in holds too; a sharp line in the spectrum"

    amplitude: float = parameter(0.01, unit="1", low=0, high=0.5, doc="relative amplitude")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        return {"conductance_S": signals["conductance_S"] * (1 + self.amplitude * np.sin(self.angle(signals)))}


class PeriodicInterferenceWave(PeriodicInterference):
    """A periodic disturbance of any form rides on the conductance: a pump that switches, a saw-tooth.

    ln G += amplitude * (sin(a) + sum_k (s_k sin(k a) + c_k cos(k a))),   a = 2 pi f t + phase,   k = 2 to 6

    Source: Fourier series; as `periodic_interference`.
    Valid: one stable frequency, its sixth harmonic below half the sampling rate.
    """

    name = "periodic_interference_wave"
    look = "a wave of fixed form rides on the conductance, in holds too; lines at multiples of one frequency"

    amplitude: float = parameter(0.01, unit="1", low=0, high=0.5, doc="amplitude of the first harmonic in ln G")
    harmonics: Vector = harmonics_parameter()

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        wave = wave_of(self.angle(signals), self.harmonics)
        return {"conductance_S": shifted(signals["conductance_S"], self.amplitude * wave)}


class PeriodicInterferenceForce(InterferenceLaw):
    """A periodic disturbance rides on the force reading.

    F += amplitude * sin(2 pi f t + phase)

    Source: as `periodic_interference`.
    Valid: one stable frequency below half the sampling rate.
    """

    name = "periodic_interference_force"
    reads, writes = ("time_s", "force_N"), ("force_N",)
    pointwise = ("force_N",)
    strength = "amplitude_N"
    channel = "force"
    look = "a sine rides on the force, in holds too; a sharp line in the spectrum"

    amplitude_N: float = parameter(0.02, unit="N", low=0, high=50, doc="amplitude")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        return {"force_N": signals["force_N"] + self.amplitude_N * np.sin(self.angle(signals))}


def sharpest_lines_Hz(x: FloatArray, dt_s: float, most: int) -> list[float]:
    """Frequencies of the lines of `x` that stand out most from their surroundings, the sharpest first."""
    from scipy.ndimage import median_filter

    power = np.abs(np.fft.rfft((x - x.mean()) * np.hanning(len(x)))) ** 2
    frequency = np.fft.rfftfreq(len(x), dt_s)
    contrast = power / np.maximum(median_filter(power, size=51), 1e-300)
    contrast[(frequency <= 0.02) | (frequency >= 20)] = 0.0
    found: list[float] = []
    while len(found) < most and contrast.any():
        at = int(np.argmax(contrast))
        found.append(_refined(x - x.mean(), dt_s, float(frequency[at])))
        contrast[max(at - LINE_BINS, 0) : at + LINE_BINS + 1] = 0.0
    return found or [1.0]


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
