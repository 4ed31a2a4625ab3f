"""How closely one model can imitate another on a motion, when its parameters are let go."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from testbench.fitting.downhill import Linearised, minimised
from testbench.fitting.fit import independent_share
from testbench.fitting.parameters import free_parameters, values_of, with_values
from testbench.fitting.sensitivity import sensitivities
from testbench.knit.cache import SimulationCache
from testbench.knit.effect import FloatArray
from testbench.knit.model import KnitModel
from testbench.measurements.measurement import Measurement
from testbench.measurements.responses import CONDUCTANCE_CHANNEL, FORCE_CHANNEL

# A search that begins anew where another was broken off leaves valleys in which one alone would end.
ITERATIONS = (12, 40)
SMALL_IMITATION_GAIN = 1e-3

Noise = Mapping[str, float]  # what a fit leaves anyway, by channel


@dataclass(frozen=True)
class Rival:
    """One hypothesis: a fitted model under a short name."""

    name: str
    model: KnitModel


@dataclass(frozen=True)
class Imitation:
    """What remains of one rival when another has imitated it.

    Attributes
    ----------
    truth, imitator : str
        Names of the rivals.
    left : dict of channel to ndarray, shape (n,)
        Truth minus imitation over the noise floor, at the samples that count, means taken out: force zero and
        conductance gain belong to each mounting.
    independent_share : float
        Independent samples per sample of `left`.
    """

    truth: str
    imitator: str
    left: Mapping[str, FloatArray]
    independent_share: float

    @property
    def noise_units(self) -> float:
        """RMS of what remains over the noise floor, in the channel where it is largest."""
        return max(float(np.sqrt(np.mean(values**2))) for values in self.left.values())

    @property
    def log_odds(self) -> float:
        """Expected log-likelihood ratio for the truth, with the residual's autocorrelation allowed for."""
        return 0.5 * self.independent_share * sum(float(np.sum(values**2)) for values in self.left.values())

    @property
    def channel(self) -> str:
        """The channel that shows it best."""
        return max(self.left, key=lambda one: float(np.sum(self.left[one] ** 2)))


def imitate(truth: Rival, imitator: Rival, measurement: Measurement, noise: Noise) -> Imitation:
    """Move the parameters of the imitator until it comes as near to the truth as it can.

    Levenberg-Marquardt as in `testbench.fitting.fit`, but with the known noise for a weight and no outliers to be
    wary of: what is left is the expected misfit of a wrong hypothesis, without any noise in it.

    Parameters
    ----------
    truth, imitator : Rival
        The weak priors of the imitator's parameters are centred where each search begins: at its model, then where
        the first search ended.
    measurement : Measurement
        The motion, with the channels of `noise`.
    noise : mapping of channel to float
        Standard deviations.
    """
    clean = replace(measurement, measured=measurement.modelled(truth.model))
    model = imitator.model
    for iterations in ITERATIONS:
        problem = _Problem(model, clean, noise)
        x, _, _ = minimised(problem, problem.start, iterations, SMALL_IMITATION_GAIN, quiet=2)
        model = problem.at(x)
    return Imitation(truth.name, imitator.name, problem.left(x), problem.share)


class _Problem:
    """Misfit and normal equations."""

    def __init__(self, model: KnitModel, measurement: Measurement, noise: Noise) -> None:
        self.model, self.measurement, self.noise = model, measurement, noise
        self.parameters = free_parameters(model, _scales(measurement.measured))
        self.start = values_of(model, self.parameters)
        self.low, self.high = np.array([(p.to_fit(p.low), p.to_fit(p.high)) for p in self.parameters]).T
        self.precision = np.array([p.width for p in self.parameters]) ** -2.0
        self.weights = dict.fromkeys(noise, 1.0)
        self.share, self.cache = independent_share(measurement), SimulationCache()

    def at(self, x: FloatArray) -> KnitModel:
        """The imitator at a point."""
        return with_values(self.model, self.parameters, x)

    def left(self, x: FloatArray) -> dict[str, FloatArray]:
        """What is not imitated, in noise units."""
        gaps = self.measurement.residual(self.at(x), self.cache)
        return {channel: self._counted(gaps, channel) for channel in self.noise}

    def cost(self, x: FloatArray) -> float:
        """Minus the log-likelihood, autocorrelation allowed for, with the priors."""
        misfit = self.share * sum(self.weights[c] * float(np.sum(v**2)) for c, v in self.left(x).items())
        total = 0.5 * (misfit + float(np.sum(self.precision * (x - self.start) ** 2)))
        return total if np.isfinite(total) else np.inf

    def linearised(self, x: FloatArray) -> Linearised:
        """Normal equations with the weights for what is left here.

        While it is far off, a channel weighs by its misfit instead of its noise: else the priors are too weak to keep
        ill-determined parameters from running away on the first steps.
        """
        left = self.left(x)
        self.weights = {c: 1 / max(1.0, float(np.mean(values**2))) for c, values in left.items()}
        cost = self.cost(x)
        _, jacobian = sensitivities(self.at(x), self.parameters, self.measurement, self.cache)
        matrix, gradient = np.diag(self.precision), -self.precision * (x - self.start)
        for channel, gap in left.items():
            columns, weight = self._counted(jacobian, channel), self.share * self.weights[channel]
            matrix = matrix + columns @ columns.T * weight
            gradient = gradient + columns @ gap * weight
        return Linearised(matrix, gradient, cost)

    def _counted(self, signals: Mapping[str, FloatArray], channel: str) -> FloatArray:
        picked = signals[channel][..., self.measurement.counts] / self.noise[channel]
        return picked - picked.mean(axis=-1, keepdims=True)


def _scales(clean: Mapping[str, FloatArray]) -> dict[str, float]:
    """Typical size of a correction by unit, as `testbench.fitting.fit.shape_scales` takes it from recordings."""
    scales = {"1": 0.3, "1/ks": 0.1, "N": 1.0}
    for channel, unit, least in ((FORCE_CHANNEL, "N", 1e-6), (CONDUCTANCE_CHANNEL, "1", 0.02)):
        if channel in clean:
            scales[unit] = max(0.1 * float(np.ptp(clean[channel])), least)
    return scales
