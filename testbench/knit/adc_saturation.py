"""Readings that stop at the rail of a converter or an amplifier."""

from __future__ import annotations

from typing import Any

import numpy as np

from testbench.knit.effect import Effect, FloatArray, Signals, Stage, parameter

WEAK_CLIPS = (0.97, 0.99)  # quantiles at which a read-out may clip so rarely that nothing piles up
PILE = 0.04  # share of the samples that makes a pile
RAIL_SHARE, RAIL_OVER_OTHERS = 0.004, 5  # of all samples stand at a rail, and so many times more than elsewhere


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
