"""Sensors of one kind that differ as specimens do: drawn around a preset.

Two knits off the same machine are not alike. A specimen's parameters are the preset's times lognormal factors, each
drawn by itself. How far they spread is an assumption, not a measurement: the paper had one sensor of each kind.
`SPREADS` says it for each kind of parameter.
"""

from __future__ import annotations

from types import MappingProxyType

import numpy as np

from gcode.support.errors import UserError
from testbench.knit.effect import bounds_of
from testbench.knit.model import KnitModel

# Standard deviation of ln(parameter), by the unit it is given in; forces and stiffnesses, resistances, times, shares.
SPREADS = MappingProxyType({"N": 0.10, "ohm": 0.15, "S": 0.15, "s": 0.15, "1": 0.10})
OTHER_SPREAD = 0.10
LARGEST_NUMBER = 10**6
# What is chosen, not what grows in the fabric.
SAME = ("pretension", "renewed", "exponent")


def specimen(model: KnitModel, number: int) -> KnitModel:
    """One specimen of the population around `model`.

    Parameters
    ----------
    model : KnitModel
        The middle of the population.
    number : int
        0 is the model itself; every other number is another specimen, always the same one.

    Raises
    ------
    UserError
        If the number is negative or above a million.
    """
    if not 0 <= number <= LARGEST_NUMBER:
        raise UserError(f"a specimen's number must be from 0 (the preset itself) to {LARGEST_NUMBER}, got {number}")
    if number == 0:
        return model
    rng, values = np.random.default_rng([number, 2023]), {}
    for name in model:
        effect = model[name]
        for key, field in type(effect).model_fields.items():
            value = getattr(effect, key)
            if key in SAME or not isinstance(value, float):
                continue
            bounds = bounds_of(field)
            moved = value * np.exp(SPREADS.get(bounds["unit"], OTHER_SPREAD) * rng.standard_normal())
            values[f"{name}.{key}"] = float(f"{np.clip(moved, bounds['low'], bounds['high']):.6g}")
    return model.with_parameters(values)
