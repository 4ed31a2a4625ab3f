"""What is believed of every parameter before the data: physical priors, as the effects declare them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from testbench.fitting.evidence.evidence import scaled
from testbench.fitting.parameters import SHARE_OF_RANGE, FreeParameters, free_parameters, shape_scales, value_of
from testbench.knit.effect import Effect, FloatArray, bounds_of
from testbench.knit.model import KnitModel
from testbench.measurements.measurement import Measurement


@dataclass(frozen=True)
class Priors:
    """Gaussian priors in the fit's coordinates; that of an effect's strength is Cauchy's.

    With Cauchy's tails an effect may be many times its typical size: ten times costs 5 nats, not fifty.

    Attributes
    ----------
    parameters : FreeParameters
    mean, precision : ndarray, shape (p,)
    tails : ndarray of bool, shape (p,)
        Which of them are strengths of effects.
    group : ndarray of int, shape (p,)
        Weights of one vector share a scale that the evidence finds; -1: as declared.
    groups : tuple of str
        Address of each group.
    typical_groups : frozenset of int
        Groups of which an effect says how large they usually are.
    """

    parameters: FreeParameters
    mean: FloatArray
    precision: FloatArray
    tails: np.ndarray
    group: np.ndarray
    groups: tuple[str, ...]
    typical_groups: frozenset[int]

    @property
    def by_address(self) -> dict[str, tuple[float, float]]:
        """Mean and standard deviation by address."""
        return {p.address: (m, w**-0.5) for p, m, w in zip(self.parameters, self.mean, self.precision, strict=True)}

    def precision_at(self, x: FloatArray) -> FloatArray:
        """Precisions of the Gaussians that have the slopes of the priors at a point, shape (p,)."""
        return np.where(self.tails, with_tails(self.precision, x - self.mean), self.precision)

    def scaled(self, scale: FloatArray) -> FloatArray:
        """Precisions with the scales of the groups, shape (p,)."""
        return scaled(self.precision, self.group, scale)

    def cost(self, x: FloatArray, scale: FloatArray) -> FloatArray:
        """How much less likely each parameter is than its mean, in nats, shape (p,)."""
        off = self.scaled(scale) * (x - self.mean) ** 2
        return np.where(self.tails, np.log1p(off), 0.5 * off)

    def over_gaussians(self, x: FloatArray) -> FloatArray:
        """ln of the norms of the densities over those of the Gaussians of `precision_at`, shape (p,)."""
        off = self.precision * (x - self.mean) ** 2
        return np.where(self.tails, 0.5 * np.log((1 + off) / np.pi), 0.0)

    def of_tails(self, x: FloatArray) -> FloatArray:
        """By how much the log evidence is above that with the Gaussians of `precision_at`, shape (p,)."""
        return np.where(self.tails, tail_evidence(self.precision, x - self.mean), 0.0)


def priors_of(
    model: KnitModel,
    measurement: Measurement,
    reference: KnitModel,
    known: Mapping[str, tuple[float, float]],
    free: Callable[[str], bool] = lambda address: True,
) -> Priors:
    """Priors of the free parameters of `model`.

    Parameters
    ----------
    reference : KnitModel
        The parameters of the base laws are believed near its own, within wide limits.
    known : mapping of address to (mean, standard deviation)
        What is believed of some parameters already, in the fit's coordinates.
    free : callable
        Whether to fit the parameter of this address.
    """
    scales = shape_scales(measurement)
    parameters = FreeParameters(p for p in free_parameters(model, scales) if free(p.address))
    groups: list[str] = []
    gaussians, group, tails = [], [], []
    for p in parameters:
        name, _, key = p.address.partition(".")
        vector, _, index = p.address.partition("[")
        if index and vector not in groups:
            groups.append(vector)
        group.append(groups.index(vector) if index else -1)
        if p.address in known:
            gaussians.append(known[p.address])
        elif index:
            gaussians.append((0.0, _size_of_vector(model, vector) or p.width))
        elif name in reference and _has_scale(type(model[name]), key):
            gaussians.append(declared(type(model[name]), key, scales))
        elif name in reference and type(reference[name]) is type(model[name]):
            gaussians.append((p.to_fit(value_of(reference, p)), p.width))
        else:
            gaussians.append(declared(type(model[name]), key, scales))
        is_strength = key == model[name].strength and name not in reference
        tails.append(is_strength and gaussians[-1][0] == 0)
    mean, width = np.array(gaussians).reshape(-1, 2).T
    said = frozenset(g for g, vector in enumerate(groups) if _size_of_vector(model, vector))
    strengths, number = np.array(tails, bool), np.array(group, int)
    return Priors(parameters, mean, width**-2.0, strengths, number, tuple(groups), said)


def declared_size(effect: type[Effect], key: str) -> float:
    """Typical size of a parameter as its effect declares it; 0 where it does not."""
    return float(bounds_of(effect.model_fields[key])["typical"] or 0.0)


def _size_of_vector(model: KnitModel, address: str) -> float:
    name, _, key = address.partition(".")
    return declared_size(type(model[name]), key)


def with_tails(precision: FloatArray, off: FloatArray) -> FloatArray:
    """Precision of the Gaussian that has the slope of Cauchy's density so far off its centre."""
    return 2 * precision / (1 + precision * off**2)


def tail_evidence(precision: FloatArray, off: FloatArray) -> FloatArray:
    """ln of Cauchy's density over that Gaussian's, so far off the centre of both."""
    size = precision * off**2
    return size / (1 + size) - 0.5 * np.log1p(size) - 0.5 * np.log(np.pi)


def declared(effect: type[Effect], key: str, scales: Mapping[str, float]) -> tuple[float, float]:
    """Centre and standard deviation of an effect's parameter, in the fit's coordinate."""
    field = effect.model_fields[key]
    extra = bounds_of(field)
    default, low, high = float(field.default), float(extra["low"]), float(extra["high"])
    if extra["scale"] == "log":
        return float(np.log(default)), max(float(np.log(high / low)) / 4, 0.5)
    if key == effect.strength:
        return 0.0, typical_strength(effect, scales)
    return default, extra["typical"] or (high - low) / 4


def _has_scale(effect: type[Effect], key: str) -> bool:
    """Whether a parameter of a base law is believed near what its effect says, not near where the data drew it."""
    return key == effect.strength or bool(declared_size(effect, key))


def typical_strength(effect: type[Effect], scales: Mapping[str, float]) -> float:
    """Typical size of an effect's strength: as declared, or on the scale of this sensor's force or resistance."""
    extra = bounds_of(effect.model_fields[effect.strength])
    said = declared_size(effect, effect.strength)
    if extra["unit"] == "N":
        return (said or SHARE_OF_RANGE) / SHARE_OF_RANGE * scales["N"]
    if extra["unit"] == "1/N":
        return SHARE_OF_RANGE / scales["N"]
    if extra["unit"] in scales.keys() & {"ohm", "S"}:
        return scales[extra["unit"]]
    default = effect.model_fields[effect.strength].default
    return float(said or abs(default) or 0.1 * max(abs(extra["high"]), abs(extra["low"])))
