"""What the instruments make of the truth: each a small function from true signal to reading.

The bench of the paper: a 10 kg load cell on an ADS1231, the sensor in a 606 kOhm divider on an ADS1115, an encoder,
and an ESP32 whose loop asks for all three at jittered times.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.random import Generator
from pydantic import Field

from gcode.support.arrays import FloatArray
from gcode.support.strict import NamedModel, StrictModel

CLOCK_HZ, CLOCK_SD_HZ = 41.5, 14.2  # mean and standard deviation of 1/dt, measured on the paper's bench


class Truth(NamedTuple):
    """True signals on a uniform grid, each shape (n,); all but time and displacement may be missing."""

    time_s: FloatArray
    displacement_mm: FloatArray
    force_N: FloatArray | None
    conductance_S: FloatArray | None
    temperature_C: FloatArray | None = None


def _measured_spread(clock: dict[str, Any]) -> float:
    """The SD that was measured on the paper's bench, at another mean as large a share of it."""
    return CLOCK_SD_HZ * (clock.get("rate_hz", CLOCK_HZ) / CLOCK_HZ)


class SampleClock(StrictModel):
    """When the firmware's loop reads: instantaneous rates 1/dt are lognormal with the measured mean and SD.

    A clock of another mean has the measured spread as a share of it, unless its own SD is given.
    """

    rate_hz: float = Field(default=CLOCK_HZ, ge=0.01, le=1000, description="mean of 1/dt")
    rate_sd_hz: float = Field(default_factory=_measured_spread, ge=0, le=500, description="SD of 1/dt")

    def times(self, duration_s: float, rng: Generator) -> FloatArray:
        """Sample times from 0 to at most `duration_s`, in whole microseconds, strictly increasing."""
        spread = np.sqrt(np.log1p((self.rate_sd_hz / self.rate_hz) ** 2))
        count = int(duration_s * self.rate_hz * 1.2) + 64
        rates_hz = rng.lognormal(np.log(self.rate_hz) - spread**2 / 2, spread, count)
        steps_us = np.maximum(1, np.rint(1e6 / rates_hz)).astype(np.int64)
        times_s = np.concatenate([[0], np.cumsum(steps_us)]) / 1e6
        return times_s[times_s <= duration_s]


class LoadCell(StrictModel):
    """10 kg bridge, 2 mV/V at 5 V, on a 24 bit ADS1231 with its fixed gain of 128 at 80 SPS.

    Source: Texas Instruments ADS1231 data sheet (SBAS414): input range +-19.5 mV = +-0.5 V_ref / 128, input noise
    35 nV rms at 10 SPS; times sqrt(8) for the bandwidth at 80 SPS.
    """

    capacity_N: float = Field(default=98.0665, gt=0, description="10 kg")
    sensitivity_V_per_V: float = Field(default=2e-3, gt=0)
    excitation_V: float = Field(default=5.0, gt=0)
    rate_hz: float = Field(default=80.0, gt=0, le=1e5)
    noise_V: float = Field(default=35e-9 * 8**0.5, ge=0)

    def read(self, truth: Truth, times_s: FloatArray, rng: Generator) -> FloatArray:
        """Force in N: the last finished conversion before each time."""
        assert truth.force_N is not None
        when_s = _conversions(times_s[-1], self.rate_hz)
        volts_per_N = self.sensitivity_V_per_V * self.excitation_V / self.capacity_N
        volts = np.interp(when_s, truth.time_s, truth.force_N) * volts_per_N
        volts += rng.normal(0.0, self.noise_V, len(volts))
        full_scale_V = 0.5 * self.excitation_V / 128
        codes = _quantised(volts, full_scale_V, bits=24)
        latest = np.floor(times_s * self.rate_hz * (1 + 1e-12)).astype(int)
        return codes[latest] * full_scale_V / 2**23 / volts_per_N


class Divider(StrictModel):
    """Sensor in series with a reference resistor; the ADS1115 (16 bit, +-4.096 V) reads across the reference.

    G = V / (R_ref (V_supply - V)). Conversions at 128 SPS are averaged over the last 25 ms.
    Source: Texas Instruments ADS1115 data sheet (SBAS444): LSB 125 uV at +-4.096 V; noise at 128 SPS below one LSB.
    """

    reference_ohm: float = Field(default=606e3, ge=1, le=1e12)
    supply_V: float = Field(default=3.3, gt=0, le=4.096)
    full_scale_V: float = Field(default=4.096, gt=0)
    rate_hz: float = Field(default=128.0, gt=0, le=1e5)
    average_s: float = Field(default=0.025, gt=0)
    noise_V: float = Field(default=60e-6, ge=0, description="about half an LSB rms")

    def read(self, truth: Truth, times_s: FloatArray, rng: Generator) -> FloatArray:
        """Resistance in ohm, always finite and positive: at the rails it sticks to what the last code can express."""
        assert truth.conductance_S is not None
        when_s = _conversions(times_s[-1], self.rate_hz)
        conductance_S = np.interp(when_s, truth.time_s, truth.conductance_S)
        share = conductance_S * self.reference_ohm
        volts = self.supply_V * share / (1 + share) + rng.normal(0.0, self.noise_V, len(when_s))
        codes = _quantised(volts, self.full_scale_V, bits=16)
        lsb_V = self.full_scale_V / 2**15
        mean_V = self._moving_mean(codes, times_s) * lsb_V
        mean_V = np.clip(mean_V, lsb_V / 4, self.supply_V - lsb_V / 4)
        return self.reference_ohm * (self.supply_V - mean_V) / mean_V

    def _moving_mean(self, codes: FloatArray, times_s: FloatArray) -> FloatArray:
        total = np.concatenate([[0.0], np.cumsum(codes)])
        end = np.floor(times_s * self.rate_hz * (1 + 1e-12)).astype(int) + 1
        start = np.ceil((times_s - self.average_s) * self.rate_hz).astype(int)
        start = np.clip(start, 0, end - 1)
        return (total[end] - total[start]) / (end - start)


class Encoder(StrictModel):
    """Quadrature encoder on a 5 mm pitch lead screw, 1000 lines: 4000 counts a turn, 1.25 um a count."""

    count_mm: float = Field(default=1.25e-3, gt=0)

    def read(self, truth: Truth, times_s: FloatArray) -> FloatArray:
        """Displacement in mm, in whole counts."""
        return np.rint(np.interp(times_s, truth.time_s, truth.displacement_mm) / self.count_mm) * self.count_mm


class Room(StrictModel):
    """The air around the bench, going up and down as a heating does, and a thermometer of 1/16 degree in it."""

    mean_C: float = 21.0
    swing_C: float = Field(default=1.0, ge=0, le=60, description="amplitude")
    period_s: float = Field(default=1800.0, gt=0)
    step_C: float = Field(default=1 / 16, gt=0)

    def temperature_C(self, time_s: FloatArray, rng: Generator) -> FloatArray:
        """The true temperature; where in its cycle the run begins is left to chance."""
        return self.mean_C + self.swing_C * np.sin(2 * np.pi * (time_s / self.period_s + rng.random()))

    def read(self, truth: Truth, times_s: FloatArray) -> FloatArray:
        """Temperature in degrees Celsius, in whole steps."""
        assert truth.temperature_C is not None
        return np.rint(np.interp(times_s, truth.time_s, truth.temperature_C) / self.step_C) * self.step_C


class Instruments(NamedModel, StrictModel):
    """All instruments of a simulated rig, with the settings of the paper's bench.

    Attributes
    ----------
    clock : SampleClock
        When it reads.
    load_cell, divider, encoder
        For force, resistance and displacement: range, resolution and noise.
    room : Room or None
        The thermometer; the paper's bench had none.

    Examples
    --------
    >>> import testbench as tb
    >>> tb.Instruments(clock={"rate_hz": 20, "rate_sd_hz": 0}).clock.rate_hz
    20.0
    """

    clock: SampleClock = SampleClock()
    load_cell: LoadCell = LoadCell()
    divider: Divider = Divider()
    encoder: Encoder = Encoder()
    room: Room | None = None


def _conversions(end_s: float, rate_hz: float) -> FloatArray:
    return np.arange(int(np.floor(end_s * rate_hz * (1 + 1e-12))) + 1) / rate_hz


def _quantised(volts: FloatArray, full_scale_V: float, bits: int) -> FloatArray:
    top = 2 ** (bits - 1)
    return np.clip(np.rint(volts / full_scale_V * top), -top, top - 1)
