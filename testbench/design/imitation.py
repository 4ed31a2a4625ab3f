"""How closely one model can imitate another on a motion, when its parameters are let go."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from testbench.fitting.downhill import Linearised, minimised
from testbench.fitting.evidence.likelihood import independent_share
from testbench.fitting.parameters import FreeParameter, free_parameters, values_of, with_values
from testbench.fitting.sensitivity import sensitivities
from testbench.knit.cache import SimulationCache
from testbench.knit.effect import FloatArray
from testbench.knit.model import KnitModel
from testbench.measurements.measurement import Measurement
from testbench.measurements.responses import CONDUCTANCE_CHANNEL, FORCE_CHANNEL

SMALL_IMITATION_GAIN = 1e-3
STRIDE = 2  # of the samples for the normal equations; neighbours say nearly the same


def imitate(
    model: KnitModel,
    measurement: Measurement,
    clean: Mapping[str, FloatArray],
    noise: Mapping[str, float],
    iterations: int,
) -> tuple[KnitModel, dict[str, FloatArray]]:
    """Move the parameters of `model` until it comes as near to `clean` as it can.

    Levenberg-Marquardt as in `testbench.fitting.fit`, but with the known noise for a weight and no outliers to be
    wary of: what is left is the expected misfit of a wrong hypothesis, without any noise in it.

    Parameters
    ----------
    model : KnitModel
        Where it starts; the weak priors are centred there.
    measurement : Measurement
        The motion.
    clean : mapping of channel to ndarray, shape (n,)
        What to imitate.
    noise : mapping of channel to float
        Standard deviations.
    iterations : int

    Returns
    -------
    model : KnitModel
        The closest imitation.
    left : dict of channel to ndarray
        `clean` minus imitation over the noise, at the samples that count, means taken out: force zero and conductance
        gain belong to each mounting.
    """
    problem = _Imitation(model, measurement, clean, noise)
    x, _, _ = minimised(problem, problem.start, iterations, SMALL_IMITATION_GAIN, quiet=2)
    closest = with_values(model, problem.parameters, x)
    return closest, problem.left(closest)


class _Imitation:
    """Misfit and normal equations."""

    def __init__(
        self,
        model: KnitModel,
        measurement: Measurement,
        clean: Mapping[str, FloatArray],
        noise: Mapping[str, float],
    ) -> None:
        self.model, self.measurement, self.clean, self.noise = model, measurement, clean, noise
        self.parameters: Sequence[FreeParameter] = free_parameters(model, _scales(clean))
        self.start = values_of(model, self.parameters)
        self.low = np.array([p.to_fit(p.low) for p in self.parameters])
        self.high = np.array([p.to_fit(p.high) for p in self.parameters])
        self.precision = np.array([p.width for p in self.parameters]) ** -2.0
        self.cache = SimulationCache()
        self.weights = dict.fromkeys(noise, 1.0)
        self.share = independent_share(measurement)

    def left(self, model: KnitModel) -> dict[str, FloatArray]:
        """What the model does not imitate, in noise units."""
        modelled = self.measurement.modelled(model, self.cache)
        return {c: self._counted(self.clean[c] - modelled[c], c) for c in self.noise}

    def cost(self, x: FloatArray) -> float:
        """Minus the log-likelihood, autocorrelation allowed for, with the priors."""
        return self._cost(self.left(with_values(self.model, self.parameters, x)), x)

    def _cost(self, left: Mapping[str, FloatArray], x: FloatArray) -> float:
        misfit = sum(self.weights[c] * float(np.sum(v**2)) for c, v in left.items()) * self.share
        total = 0.5 * (misfit + float(np.sum(self.precision * (x - self.start) ** 2)))
        return total if np.isfinite(total) else np.inf

    def linearised(self, x: FloatArray) -> Linearised:
        """Normal equations with the weights for what is left here.

        While it is far off, a channel weighs by its misfit instead of its noise: else the priors are too weak to keep
        ill-determined parameters from running away on the first steps.
        """
        model = with_values(self.model, self.parameters, x)
        left = self.left(model)
        self.weights = {c: 1 / max(1.0, float(np.mean(values**2))) for c, values in left.items()}
        _, jacobian = sensitivities(model, self.parameters, self.measurement, self.cache)
        matrix, gradient = np.diag(self.precision), -self.precision * (x - self.start)
        for channel, gap in left.items():
            columns = self._counted(jacobian[channel], channel)[:, ::STRIDE]
            weight = self.weights[channel] * STRIDE * self.share
            matrix = matrix + columns @ columns.T * weight
            gradient = gradient + columns @ gap[::STRIDE] * weight
        return Linearised(matrix, gradient, self._cost(left, x))

    def _counted(self, values: FloatArray, channel: str) -> FloatArray:
        picked = values[..., self.measurement.counts] / self.noise[channel]
        return picked - picked.mean(axis=-1, keepdims=True)


def _scales(clean: Mapping[str, FloatArray]) -> dict[str, float]:
    """Typical size of a correction by unit, as `testbench.fitting.fit.shape_scales` takes it from recordings."""
    scales = {"1": 0.3, "1/ks": 0.1, "N": 1.0}
    for channel, unit, least in ((FORCE_CHANNEL, "N", 1e-6), (CONDUCTANCE_CHANNEL, "1", 0.02)):
        if channel in clean:
            scales[unit] = max(0.1 * float(np.ptp(clean[channel])), least)
    return scales
