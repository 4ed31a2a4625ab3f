"""How the modelled signals answer to each free parameter, by finite differences."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby

import numpy as np

from testbench.fitting.parameters import FreeParameter, value_of
from testbench.fitting.propagation import Chain, change_of
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
    for indices, rows in derivatives(model, parameters, range(len(parameters)), measurement, cache):
        for channel, values in rows.items():
            jacobian[channel][indices] = values
    return modelled, jacobian


def derivatives(
    model: KnitModel,
    parameters: Sequence[FreeParameter],
    which: Sequence[int],
    measurement: Measurement,
    cache: SimulationCache,
) -> Iterator[tuple[list[int], dict[str, FloatArray]]]:
    """Indices and derivatives, by channel, each shape (m, n), of those of `parameters` that `which` names.

    They come from the end of the signal chain backwards, so that the cache always holds the unchanged beginning. A
    change is simulated as far as any law remembers it; beyond, it passes by the slopes of the laws.
    """
    measurement.modelled(model, cache)
    chain = Chain(model, measurement, cache)
    for (name, key), group in groupby(reversed(which), lambda index: parameters[index].place[:2]):
        indices, number = list(group), chain.number[name]
        until = chain.until(number)
        places = [parameters[index].place[2] for index in indices]
        terms = chain.terms(number, key) if until == number and min(places) >= 0 else None
        if terms is not None:
            yield indices, chain.answers_behind(number).to({model[name].writes[0]: terms[places]})
            continue
        for index in indices:
            change = _change(chain, until, parameters[index], measurement, cache)
            yield [index], chain.answers_behind(until).to(change)


def _change(
    chain: Chain, until: int, parameter: FreeParameter, measurement: Measurement, cache: SimulationCache
) -> dict[str, FloatArray]:
    """Change of the signals behind one law over that of a parameter in the fit's coordinate, each shape (1, n)."""
    model, here = chain.head(until), chain.behind[until]
    at = parameter.to_fit(value_of(model, parameter))
    step = _step(parameter, at)
    moved = model.with_places([(parameter.place, parameter.to_physical(at + step))])
    there = moved.simulate(measurement.signals, measurement.dt_s, cache)
    changed = (signal for signal, values in there.items() if values is not here[signal])
    return {signal: change_of(signal, there, here)[None] / step for signal in changed}


def _step(parameter: FreeParameter, at: float) -> float:
    size = 1.0 if parameter.log else max(abs(at), 0.1 * parameter.width)
    step = RELATIVE_STEP * size
    high = parameter.to_fit(parameter.high)
    return -step if at + step > high else step
