"""How the modelled signals answer to each free parameter, by finite differences."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from testbench.fitting.parameters import FreeParameter, values_of, with_values
from testbench.knit.cache import SimulationCache
from testbench.knit.effect import FloatArray
from testbench.knit.model import KnitModel
from testbench.measurements.measurement import Measurement

RELATIVE_STEP = 1e-4


def sensitivities(
    model: KnitModel, parameters: Sequence[FreeParameter], measurement: Measurement, cache: SimulationCache
) -> tuple[dict[str, FloatArray], dict[str, FloatArray]]:
    """Modelled signals and their derivatives.

    Returns
    -------
    modelled : dict of channel to ndarray, shape (n,)
    jacobian : dict of channel to ndarray, shape (p, n)
        Derivative by the fit's coordinate of each parameter.
    """
    modelled = measurement.modelled(model, cache)
    jacobian = {channel: np.zeros((len(parameters), len(values))) for channel, values in modelled.items()}
    for index, rows in derivatives(model, parameters, range(len(parameters)), measurement, cache):
        for channel, values in rows.items():
            jacobian[channel][index] = values
    return modelled, jacobian


def derivatives(
    model: KnitModel,
    parameters: Sequence[FreeParameter],
    which: Sequence[int],
    measurement: Measurement,
    cache: SimulationCache,
) -> Iterator[tuple[int, dict[str, FloatArray]]]:
    """Index and derivatives, by channel, each shape (n,), of those of `parameters` that `which` names.

    They come from the end of the signal chain backwards, so that the cache always holds the unchanged beginning.
    """
    modelled, start = measurement.modelled(model, cache), values_of(model, parameters)
    for index in reversed(which):
        step = _step(parameters[index], start[index])
        shifted = measurement.modelled(
            with_values(model, [parameters[index]], start[index : index + 1] + step), cache
        )
        yield index, {channel: (values - modelled[channel]) / step for channel, values in shifted.items()}


def _step(parameter: FreeParameter, at: float) -> float:
    size = 1.0 if parameter.log else max(abs(at), 0.1 * parameter.width)
    step = RELATIVE_STEP * size
    high = parameter.to_fit(parameter.high)
    return -step if at + step > high else step
