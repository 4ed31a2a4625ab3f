"""What is believed of every parameter before the data: physical priors, as the effects declare them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from testbench.discrepancy.fit import shape_scales
from testbench.discrepancy.measurement import Measurement
from testbench.discrepancy.parameters import FreeParameter, _lookup, free_parameters
from testbench.knit.effect import Effect, FloatArray, bounds_of
from testbench.knit.model import KnitModel


@dataclass(frozen=True)
class Priors:
    """Gaussian priors in the fit's coordinates.

    Attributes
    ----------
    parameters : tuple of FreeParameter
    mean, precision, low, high : ndarray, shape (p,)
    group : ndarray of int, shape (p,)
        Weights of one vector share a scale that the evidence finds; -1: as declared.
    groups : tuple of str
        Address of each group.
    """

    parameters: tuple[FreeParameter, ...]
    mean: FloatArray
    precision: FloatArray
    low: FloatArray
    high: FloatArray
    group: np.ndarray
    groups: tuple[str, ...]

    def scaled(self, factor: FloatArray) -> FloatArray:
        """Precisions with the scales of the groups, shape (p,)."""
        return self.precision * np.where(self.group >= 0, factor[self.group], 1.0) if len(factor) else self.precision


def priors_of(model: KnitModel, measurement: Measurement, reference: KnitModel) -> Priors:
    """Priors of all free parameters of `model`; base laws are believed near those of `reference`, within wide limits."""
    parameters = free_parameters(model, shape_scales(measurement))
    groups: list[str] = []
    mean, width, group = [], [], []
    for p in parameters:
        vector, _, index = p.address.partition("[")
        if index:
            if vector not in groups:
                groups.append(vector)
            group.append(groups.index(vector))
            mean.append(0.0)
            width.append(p.width)
            continue
        group.append(-1)
        name, _, key = p.address.partition(".")
        if name in reference and type(reference[name]) is type(model[name]):
            mean.append(p.to_fit(_lookup(reference, p.address)))
            width.append(p.width)
        else:
            centre, sd = declared(type(model[name]), key)
            mean.append(centre)
            width.append(sd)
    low, high = (np.array([p.to_fit(getattr(p, side)) for p in parameters]) for side in ("low", "high"))
    return Priors(
        tuple(parameters), np.array(mean), np.array(width) ** -2.0, low, high, np.array(group, int), tuple(groups)
    )


def declared(effect: type[Effect], key: str) -> tuple[float, float]:
    """Centre and standard deviation of an effect's parameter, in the fit's coordinate."""
    field = effect.model_fields[key]
    extra = bounds_of(field)
    default = float(field.default)
    if not effect.strength:
        return default, (extra["high"] - extra["low"]) / 4 if extra["scale"] != "log" else 2.0
    if extra["scale"] == "log":
        return float(np.log(default)), max(float(np.log(extra["high"] / extra["low"])) / 4, 0.5)
    if key == effect.strength:
        return 0.0, typical(effect)
    return default, (extra["high"] - extra["low"]) / 4


def typical(effect: type[Effect]) -> float:
    """Typical size of an effect's strength."""
    extra = bounds_of(effect.model_fields[effect.strength])
    said = extra.get("typical")
    default = effect.model_fields[effect.strength].default
    return float(said or abs(default) or 0.1 * max(abs(extra["high"]), abs(extra["low"])))
