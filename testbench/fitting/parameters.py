"""A model's free parameters as one vector: addresses, bounds, steps and weak priors."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import groupby
from typing import TYPE_CHECKING, Any

import numpy as np

from testbench.knit.effect import FloatArray, bounds_of
from testbench.knit.model import KnitModel, parts_of
from testbench.measurements.responses import CONDUCTANCE_CHANNEL, FORCE_CHANNEL

if TYPE_CHECKING:
    from testbench.measurements.measurement import Measurement

# Parameters that describe the data (their range, moments of events), not the sensor: set from them, never fitted.
FRAME_PARAMETERS = frozenset({"span", "span_N", "low_N", "tension_N", "slip_times_s", "reach_per_s", "begins_s"})
HELD = 1e12  # prior precision, in the fit's coordinate, of a parameter that stays where it is
SHARE_OF_RANGE = 0.1  # of the range of a reading: how large a correction usually is, if nothing else was declared
LARGEST_LOG = 700.0  # the exponential of a larger number is no float any more


@dataclass(frozen=True)
class FreeParameter:
    """One fitted number.

    Attributes
    ----------
    address : str
        ``effect.parameter`` or ``effect.parameter[index]``.
    low, high : float
        Physical bounds. The fit's own coordinate is the logarithm where `log`.
    width : float
        Standard deviation of a weak prior in the fit's coordinate, wide enough to yield to any real evidence.
    log : bool
    unit : str
    """

    address: str
    low: float
    high: float
    width: float
    log: bool
    unit: str

    @cached_property
    def place(self) -> tuple[str, str, int]:
        """Effect, parameter, and index in its vector; -1 where it is no vector."""
        return parts_of(self.address)

    def to_fit(self, value: float) -> float:
        """From the physical value to the fit's coordinate."""
        return math.log(value) if self.log else float(value)

    def to_physical(self, coordinate: float) -> float:
        """Back to the physical value, within its bounds."""
        value = math.exp(min(coordinate, LARGEST_LOG)) if self.log else coordinate
        if value < self.low:
            return self.low
        return self.high if value > self.high else value


class FreeParameters(tuple[FreeParameter, ...]):
    """Free parameters as one vector: the coordinates of a fit, p of them."""

    @cached_property
    def low(self) -> FloatArray:
        """Lower bounds in the fit's coordinates, shape (p,)."""
        return np.array([p.to_fit(p.low) for p in self])

    @cached_property
    def high(self) -> FloatArray:
        """Upper bounds in the fit's coordinates, shape (p,)."""
        return np.array([p.to_fit(p.high) for p in self])

    @cached_property
    def _single(self) -> list[int]:
        """Which of them are no weights of a vector."""
        return [i for i, p in enumerate(self) if p.place[2] < 0]

    @cached_property
    def _vectors(self) -> list[tuple[slice, tuple[str, str, slice]]]:
        """Weights that stand in a row in a vector: which of the parameters, and where they go in a model."""
        found = []
        weights = (i for i, p in enumerate(self) if p.place[2] >= 0)
        for _, row in groupby(weights, lambda i: (self[i].place[:2], i - self[i].place[2])):
            which = list(row)
            effect, key, first = self[which[0]].place
            found.append((slice(which[0], which[-1] + 1), (effect, key, slice(first, first + len(which)))))
        return found

    def within(self, x: FloatArray) -> FloatArray:
        """The point within the bounds that is nearest to this one, shape (p,)."""
        return np.clip(x, self.low, self.high)

    def model_at(self, model: KnitModel, x: FloatArray) -> KnitModel:
        """The model at a point of the fit's coordinates, shape (p,), within the bounds."""
        within = self.within(x)
        single = [(self[i].place, self[i].to_physical(float(x[i]))) for i in self._single]
        return model.with_places([*single, *((place, within[which].tolist()) for which, place in self._vectors)])

    def point_of(self, model: KnitModel) -> FloatArray:
        """Where a model is in the fit's coordinates, shape (p,)."""
        x = np.empty(len(self))
        for i in self._single:
            x[i] = self[i].to_fit(value_of(model, self[i]))
        for which, (effect, key, row) in self._vectors:
            x[which] = getattr(model[effect], key)[row]
        return x


def shape_scales(measurement: Measurement) -> dict[str, float]:
    """Typical size of a correction, by unit: a share of the range of the readings, a sensor's own resistance."""
    scales = {"1": 0.3, "1/ks": 0.1, "N": 1.0}
    if FORCE_CHANNEL in measurement.measured:
        scales["N"] = SHARE_OF_RANGE * float(np.ptp(measurement.measured[FORCE_CHANNEL]))
    if CONDUCTANCE_CHANNEL in measurement.measured:
        log_conductance = measurement.measured[CONDUCTANCE_CHANNEL]
        scales["1"] = max(SHARE_OF_RANGE * float(np.ptp(log_conductance)), 0.02)
        scales["S"] = float(np.exp(np.median(log_conductance)))
        scales["ohm"] = 1 / scales["S"]
    return scales


def free_parameters(model: KnitModel, scales: Mapping[str, float]) -> FreeParameters:
    """List what a fit may move, in the order of the signal chain.

    Parameters
    ----------
    model : KnitModel
    scales : mapping of unit to float
        Typical sizes by unit: of a shape weight the width of its prior.
    """
    found: list[FreeParameter] = []
    for name, effect in model.effects.items():
        for key, field in type(effect).model_fields.items():
            if key in FRAME_PARAMETERS:
                continue
            found += _entries(f"{name}.{key}", getattr(effect, key), bounds_of(field), scales)
    return FreeParameters(found)


def _entries(address: str, value: Any, extra: Mapping[str, Any], scales: Mapping[str, float]) -> list[FreeParameter]:
    if isinstance(value, bool | str):
        return []
    unit, low, high = str(extra["unit"]), float(extra["low"]), float(extra["high"])
    if isinstance(value, tuple):
        width = scales.get(unit, 1.0)
        return [FreeParameter(f"{address}[{i}]", low, high, width, False, unit) for i in range(len(value))]
    if extra["scale"] == "log":
        width = max(float(np.log(high / low)) / 4, 1.0)
        return [FreeParameter(address, low, high, width, True, unit)]
    width = min(high - low, 10 * max(abs(value), scales.get(unit, 1.0)))
    return [FreeParameter(address, low, high, width, False, unit)]


def value_of(model: KnitModel, parameter: FreeParameter) -> float:
    """Current value, in its own unit."""
    effect, key, index = parameter.place
    value = getattr(model[effect], key)
    return value if index < 0 else value[index]
