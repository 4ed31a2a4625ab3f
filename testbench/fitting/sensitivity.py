"""How the modelled signals answer to each free parameter, by finite differences."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from testbench.fitting.measurement import Measurement
from testbench.fitting.parameters import FreeParameter, values_of, with_values
from testbench.knit.cache import SimulationCache
from testbench.knit.effect import FloatArray
from testbench.knit.model import KnitModel

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
    start = values_of(model, parameters)
    jacobian = {channel: np.zeros((len(parameters), len(values))) for channel, values in modelled.items()}
    # From the end of the signal chain backwards, so that the cache always holds the unchanged beginning.
    for index in reversed(range(len(parameters))):
        step = _step(parameters[index], start[index])
        moved = start.copy()
        moved[index] += step
        shifted = measurement.modelled(with_values(model, [parameters[index]], moved[index : index + 1]), cache)
        _store(jacobian, index, modelled, shifted, step)
    return modelled, jacobian


def _step(parameter: FreeParameter, at: float) -> float:
    size = 1.0 if parameter.log else max(abs(at), 0.1 * parameter.width)
    step = RELATIVE_STEP * size
    high = parameter.to_fit(parameter.high)
    return -step if at + step > high else step


def _store(
    jacobian: Mapping[str, FloatArray],
    index: int,
    modelled: Mapping[str, FloatArray],
    shifted: Mapping[str, FloatArray],
    step: float,
) -> None:
    for channel, rows in jacobian.items():
        rows[index] = (shifted[channel] - modelled[channel]) / step
