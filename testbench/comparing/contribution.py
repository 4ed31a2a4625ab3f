"""What one effect would add to a model that the model's own parameters could not do: for a person to look at."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from gcode.support.errors import UserError
from gcode.support.read_only import Unchanging
from testbench.fitting.evidence.independent_samples import independent_share
from testbench.fitting.parameters import free_parameters, shape_scales
from testbench.fitting.sensitivity import sensitivities
from testbench.knit.cache import SimulationCache
from testbench.knit.effect import Effect, FloatArray
from testbench.knit.model import KnitModel
from testbench.measurements.measurement import Measurement
from testbench.measurements.noise_level import robust_sd


@dataclass(frozen=True, eq=False)
class Contribution(Unchanging):
    """Residual and predicted contribution over the samples that count.

    Attributes
    ----------
    time_s : ndarray, shape (n,)
    residual, added : mapping of channel to ndarray, shape (n,)
        What the model leaves, and what the effect would add; both without what a refit of the model's own
        parameters, or another offset of a channel, would take up. Force in N, conductance in ln S.
    """

    time_s: FloatArray
    residual: Mapping[str, FloatArray]
    added: Mapping[str, FloatArray]


def contribution(model: KnitModel, effect: Effect, measurement: Measurement) -> Contribution:
    """Compare what `effect` would add to `model` with what the model leaves.

    An effect changes much that a refit of the base laws would undo at once (a relaxing force is also a weaker
    one). So the base's sensitivities are projected out of both, to first order, as in the screening.

    Raises
    ------
    UserError
        If the effect gives NaN on these data.
    """
    rows = measurement.counts
    parameters = free_parameters(model, shape_scales(measurement))
    modelled, jacobian = sensitivities(model, parameters, measurement, SimulationCache())
    changed = measurement.modelled(model.plus(effect))
    added = {channel: (changed[channel] - modelled[channel])[rows] for channel in modelled}
    if not all(np.all(np.isfinite(values)) for values in added.values()):
        raise UserError(f"{effect.name} gives NaN on {measurement.recording.source}")
    residual = {channel: (measurement.measured[channel] - modelled[channel])[rows] for channel in modelled}
    base = {channel: values[:, rows] for channel, values in jacobian.items()}
    scale = {channel: max(robust_sd(values), 1e-12) for channel, values in residual.items()}
    # Neighbours count as if they were independent: the priors must be as much stronger.
    precision = np.array([p.width for p in parameters]) ** -2.0 / independent_share(measurement)
    project = _Projection(base, scale, precision)
    return Contribution(measurement.signals["time_s"][rows], project(residual), project(added))


class _Projection:
    """Takes out what the base's parameters can do: ridge regression over all channels at once."""

    def __init__(self, base: Mapping[str, FloatArray], scale: Mapping[str, float], precision: FloatArray) -> None:
        self.base = {channel: values - values.mean(axis=1, keepdims=True) for channel, values in base.items()}
        self.scale = scale
        self.normal = np.diag(precision) + sum(
            (values / scale[channel] ** 2) @ values.T for channel, values in self.base.items()
        )

    def __call__(self, signals: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
        centred = {channel: values - values.mean() for channel, values in signals.items()}
        goal = sum(self.base[channel] @ values / self.scale[channel] ** 2 for channel, values in centred.items())
        weights = np.linalg.lstsq(self.normal, goal, rcond=1e-12)[0]
        return {channel: values - weights @ self.base[channel] for channel, values in centred.items()}
