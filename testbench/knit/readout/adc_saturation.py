"""Readings that stop at the rail of a converter or an amplifier."""

from __future__ import annotations

from typing import Any

import numpy as np

from testbench.knit.effect import Effect, FloatArray, Points, Signals, Stage, parameter

WEAK_CLIPS = (0.97, 0.99)  # quantiles at which a read-out may clip so rarely that nothing piles up
PILE = 0.04  # share of the samples that makes a pile
BEYOND = 6.0  # standard deviations of the noise by which readings may lie beyond a rail


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


def _rails(values: FloatArray, side: float) -> list[float]:
    """Of the levels those that no reading is beyond, but for its noise: a rail lets nothing pass.

    Noise shows in second differences; where most readings are cut off, only the largest of these do.
    """
    noise = float(np.quantile(np.abs(np.diff(values, 2)), 0.9)) / (1.645 * 6**0.5)
    farthest = float(np.max(side * values))
    return [level for level in _levels(values, side) if farthest - side * level <= BEYOND * noise]


class SaturationLaw(Effect):
    """Base of the laws of a reading that is cut off."""

    mechanism = "adc_saturation"
    stage = Stage.READOUT
    reads, writes = ("conductance_S",), ("conductance_S",)
    pointwise = ("conductance_S",)
    strength = "floor_ohm"
    nonlinear = True

    def nowhere(self) -> dict[str, Any]:
        """Where a fit starts on data that show no rail: from none, for no size of one is usual in every unit."""
        return {self.strength: 0.0}


class AdcSaturation(SaturationLaw):
    """The converter cannot read resistances below a floor: conductance is clipped at the top.

    R = max(R, floor)

    Source: full scale of a converter behind a divider, as in Texas Instruments' ADS1115 data sheet.
    Valid: a hard corner in the reading alone; the force goes on.
    """

    name = "adc_saturation"
    look = "conductance is cut off flat at the top, at exactly one value"

    floor_ohm: float = parameter(1e4, unit="ohm", low=0, high=1e12, doc="smallest resistance that can be read")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        top_S = 1 / self.floor_ohm if self.floor_ohm > 0 else np.inf
        return {"conductance_S": np.minimum(signals["conductance_S"], top_S)}

    def starts(self, signals: Signals, residual: Signals) -> Points:
        tops = _rails(_measured_ln(signals, residual), 1.0)
        return [{"floor_ohm": float(np.exp(-level))} for level in tops] or [self.nowhere()]


class AdcSaturationHigh(SaturationLaw):
    """The converter cannot read resistances above a ceiling: conductance is cut off at the bottom.

    G = max(G, floor)

    Source: as `adc_saturation`.
    Valid: a hard corner in the reading alone.
    """

    name = "adc_saturation_high"
    strength = "floor_S"
    look = "conductance is cut off flat at the bottom, at exactly one value"

    floor_S: float = parameter(1e-6, unit="S", low=0, high=1e6, doc="smallest conductance that can be read")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        return {"conductance_S": np.maximum(signals["conductance_S"], self.floor_S)}

    def starts(self, signals: Signals, residual: Signals) -> Points:
        bottoms = _rails(_measured_ln(signals, residual), -1.0)
        return [{"floor_S": float(np.exp(level))} for level in bottoms] or [self.nowhere()]


class AdcSaturationSoft(SaturationLaw):
    """The amplifier before the converter bends as it nears its rail.

    G = top * s / (1 + s^hardness)^(1 / hardness),   s = G / top,   top = 1 / floor

    Source: output swing near the rail, as amplifier data sheets plot it; `adc_saturation` with a rounded corner.
    Valid: hardness above 12: the bend is confined to the last few per cent below the rail.
    """

    name = "adc_saturation_soft"
    bends_a_law = True
    look = "conductance flattens out within the last few per cent below one value"

    floor_ohm: float = parameter(1e4, unit="ohm", low=0, high=1e12, doc="smallest resistance that can be read")
    hardness: float = parameter(30.0, unit="1", low=12, high=200, scale="log", doc="sharpness of the corner")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        conductance = signals["conductance_S"]
        load = np.log(np.maximum(conductance * self.floor_ohm, 1e-12))
        return {"conductance_S": conductance * np.exp(-np.logaddexp(0.0, self.hardness * load) / self.hardness)}

    def starts(self, signals: Signals, residual: Signals) -> Points:
        tops_S = np.exp(_levels(_measured_ln(signals, residual), 1.0))
        return [{"floor_ohm": float(1 / top_S), "hardness": h} for top_S in tops_S for h in (20.0, 60.0)]


class AdcSaturationForce(SaturationLaw):
    """The load cell's amplifier saturates: the force reading is cut off at the top.

    F = min(F, 1 / inverse_range)

    Source: as `adc_saturation`.
    Valid: a hard corner in the reading alone; the conductance goes on.
    """

    name = "adc_saturation_force"
    reads, writes = ("force_N",), ("force_N",)
    pointwise = ("force_N",)
    strength = "inverse_range_per_N"
    look = "force is cut off flat at the top, at exactly one value"

    inverse_range_per_N: float = parameter(0.3, unit="1/N", low=0, high=1e4, doc="inverse of the largest reading")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        top_N = 1 / self.inverse_range_per_N if self.inverse_range_per_N > 0 else np.inf
        return {"force_N": np.minimum(signals["force_N"], top_N)}

    def starts(self, signals: Signals, residual: Signals) -> Points:
        tops_N = _rails(signals["force_N"] + residual.get("force", 0.0), 1.0)
        return [{"inverse_range_per_N": 1 / top_N} for top_N in tops_N if top_N > 0] or [self.nowhere()]
