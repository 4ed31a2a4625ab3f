"""A model on another recording of the same sensor: what belongs to one recording is free in each."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from testbench.comparing.clamping import moved, zero_of
from testbench.comparing.model_errors import log_error, rms_errors
from testbench.fitting.baseline import without_laws, without_zeros
from testbench.fitting.fit import fit
from testbench.knit.additive import ConductanceLaw, ForceLaw
from testbench.knit.effect import FloatArray, Signals, Stage, bounds_of, parameter
from testbench.knit.model import KnitModel
from testbench.measurements.measurement import Measurement
from testbench.measurements.responses import SIGNAL_OF


class ForceOffset(ForceLaw):
    """The zero of the load cell in one recording: F += offset."""

    name = "force_offset"
    stage, reads = Stage.READOUT, ("force_N",)
    strength = "offset_N"

    offset_N: float = parameter(0.0, unit="N", low=-1e3, high=1e3, typical=1.0, doc="what is read without load")

    def change(self, signals: Signals, dt_s: float) -> FloatArray:
        return np.array(self.offset_N)


class ConductanceGain(ConductanceLaw):
    """The gain of the conductance in one recording: ln G += gain."""

    name = "conductance_gain"
    stage, reads = Stage.READOUT, ("conductance_S",)

    gain: float = parameter(0.0, unit="1", low=-20, high=20, typical=1.0, doc="ln of the ratio to the model's")

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        return np.array(self.gain)


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
    """The model with the parameters that belong to one recording fitted to this one.

    Its zero of force and its gain are free meanwhile: a line through an offset would have another slope.
    """
    own = {name: effect.of_one_recording(measurement.signals) for name, effect in model.effects.items()}
    free = {f"{name}.{key}" for name, keys in own.items() for key in keys}
    if not free:
        return model
    for name, keys in own.items():
        if keys:
            model = _placed(model, name, keys, measurement)
    for address in sorted(free):
        model = _best_of_turn(model, address, measurement)
    measured = {SIGNAL_OF[channel] for channel in measurement.channels}
    offsets = [law for law in (ForceOffset(), ConductanceGain()) if law.writes[0] in measured]
    for law in offsets:
        model = model.plus(law)
    free |= {f"{law.name}.{law.strength}" for law in offsets}
    found = fit(model, measurement, iterations=8, free=lambda a: a.partition("[")[0] in free).model
    return without_laws(found, [law.name for law in offsets])


def _placed(model: KnitModel, name: str, keys: Sequence[str], measurement: Measurement) -> KnitModel:
    """The model with an effect's events where the misfit of the rest has them in this recording."""
    base = model.without(name)
    state = base.simulate(measurement.signals, measurement.dt_s)
    effect = model[name]
    there = next(iter(effect.starting_points(state, measurement.residual(base))), {})
    return model.replacing(name, effect.near(**{key: there[key] for key in keys if key in there}))


def _best_of_turn(model: KnitModel, address: str, measurement: Measurement) -> KnitModel:
    """The model with a phase at the best of eight points of the circle; other parameters stay."""
    name, _, key = address.partition(".")
    extra = bounds_of(type(model[name]).model_fields[key])
    if extra["unit"] != "rad":
        return model
    turns = [model.with_parameters({address: phase}) for phase in np.linspace(-np.pi, np.pi, 8, endpoint=False)]
    return min(turns, key=lambda turned: log_error(turned, measurement, free_offset=True))
