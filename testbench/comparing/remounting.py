"""A model on another recording of the same sensor: what belongs to one recording is free in each."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from testbench.comparing.clamping import moved, zero_of
from testbench.comparing.model_errors import log_error, rms_errors
from testbench.fitting.baseline import without_zeros
from testbench.fitting.fit import fit
from testbench.knit.effect import bounds_of
from testbench.knit.model import KnitModel
from testbench.measurements.measurement import Measurement


def held_errors(model: KnitModel, held: Measurement) -> dict[str, float]:
    """Errors on held-out samples; what belongs to the mounting or to one recording is free.

    That is force zero and conductance gain, what of an effect is `of_one_recording` (the phase of a hum), and the
    zero of displacement where the sensor was clamped anew.
    """
    model, held = brought_together(model, held)
    return rms_errors(model, held, free_offset=True)


def brought_together(model: KnitModel, held: Measurement) -> tuple[KnitModel, Measurement]:
    """Model and recording with all free that belongs to that recording; what is left between them is the model's."""
    model = without_zeros(model)
    if held.clamp_play_mm:
        held = moved(held, zero_of(model, held).shift_mm)
    return remounted(model, held), held


def remounted(model: KnitModel, measurement: Measurement) -> KnitModel:
    """The model with the parameters that belong to one recording fitted to this one."""
    own = {name: effect.of_one_recording(measurement.signals) for name, effect in model.effects.items()}
    free = {f"{name}.{key}" for name, keys in own.items() for key in keys}
    if not free:
        return model
    for name, keys in own.items():
        if keys:
            model = _placed(model, name, keys, measurement)
    for address in sorted(free):
        model = _best_of_turn(model, address, measurement)
    return fit(model, measurement, iterations=8, free=lambda a: a.partition("[")[0] in free).model


def _placed(model: KnitModel, name: str, keys: Sequence[str], measurement: Measurement) -> KnitModel:
    """The model with an effect's events where the misfit of the rest has them in this recording."""
    base = model.without(name)
    state = base.simulate(measurement.signals, measurement.dt_s)
    effect = model[name]
    there = next(iter(effect.starts(state, measurement.residual(base))), {})
    return model.replacing(name, effect.near(**{key: there[key] for key in keys if key in there}))


def _best_of_turn(model: KnitModel, address: str, measurement: Measurement) -> KnitModel:
    """The model with a phase at the best of eight points of the circle; other parameters stay."""
    name, _, key = address.partition(".")
    extra = bounds_of(type(model[name]).model_fields[key])
    if extra["unit"] != "rad":
        return model
    turns = [model.with_parameters({address: phase}) for phase in np.linspace(-np.pi, np.pi, 8, endpoint=False)]
    return min(turns, key=lambda turned: log_error(turned, measurement))
