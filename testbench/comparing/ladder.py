"""The ladder: models one effect apart, and what each step did to the errors."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, replace
from typing import Any

import numpy as np

from gcode.support.errors import UserError
from testbench.comparing.clamping import moved, zero_of
from testbench.comparing.model_errors import noise_floors, over_the_floors, rms_errors
from testbench.comparing.remounting import held_errors
from testbench.fitting.baseline import without_zeros
from testbench.fitting.fit import Fit, fit
from testbench.knit.catalogue import Catalogue, model_from_dict
from testbench.knit.effect import Effect, FloatArray
from testbench.knit.model import KnitModel
from testbench.measurements.measurement import Measurement
from testbench.measurements.responses import CONDUCTANCE_CHANNEL, FORCE_CHANNEL
from testbench.results.model_file import ModelFile

NO_LONGER_PAYS = 0.005  # leaving an effect out costs less than this share of the held-out error


def fitted_file(
    model: KnitModel,
    calibration: Measurement,
    held: Measurement,
    step: str,
    before: ModelFile | None = None,
    progress: Callable[[str], None] | None = None,
) -> ModelFile:
    """Fit `model` and put it on top of the ladder.

    Parameters
    ----------
    model : KnitModel
        Where the search starts.
    calibration, held : Measurement
    step : str
        What this step did, e.g. ``baseline`` or ``+ stress_relaxation``.
    before : ModelFile, optional
        The ladder so far.
    """
    return on_the_ladder(fit(model, calibration, progress=progress), before, step, calibration, held)


def on_the_ladder(
    result: Fit, before: ModelFile | None, step: str, calibration: Measurement, held: Measurement
) -> ModelFile:
    """A model that was fitted already, put on top of the ladder so far."""
    return as_a_step(result.model, result.summary(), before, step, calibration, held)


def as_a_step(
    model: KnitModel,
    summary: Mapping[str, Any],
    before: ModelFile | None,
    step: str,
    calibration: Measurement,
    held: Measurement,
) -> ModelFile:
    """A model with the summary of its fit (`Fit.summary`), put on top of the ladder so far."""
    entry = ladder_step(step, model, calibration, held)
    below = _with_fit(before) if before else ()
    return ModelFile(
        without_zeros(model),
        calibration.recording.gauge_length_mm,
        calibration.recording.source,
        held.recording.source,
        summary,
        (*below, entry),
    )


def _with_fit(file: ModelFile) -> tuple[Mapping[str, Any], ...]:
    """The history of a model, if any, whose last step keeps what its fit found: another step is to stand on it."""
    told = {"fit": file.fit} if file.fit else {}
    return (*file.history[:-1], *({**last, **told} for last in file.history[-1:]))


def ladder_step(step: str, model: KnitModel, calibration: Measurement, held: Measurement) -> dict[str, Any]:
    """One entry of the history: the model, its errors on both recordings, their names, and the noise floor.

    Where the sensor was clamped anew for the held-out recording, also the `Zero` that was found there; where that is
    of the same specimen, the rest before it; where it was fitted on several recordings in a row, how many.
    """
    sensor = without_zeros(model)
    zero = zero_of(sensor, held) if held.clamp_play_mm else None
    if zero is not None:
        held = moved(held, zero.shift_mm)
    recordings = 1 + len(calibration.begins_s)
    rested = held.rest_s is not None and recordings == 1
    return {
        "step": step,
        "model": sensor.to_dict(),
        "errors": {"calibration": rms_errors(model, calibration), "held_out": held_errors(sensor, held)},
        "noise_floor": noise_floors(held),
        "fitted_on": calibration.recording.source,
        "held_out": held.recording.source,
        **({} if zero is None else {"zero": asdict(zero)}),
        **({"rest_s": held.rest_s} if rested else {}),
        **({} if recordings == 1 else {"recordings": recordings}),
    }


def drawn_to_data(law: Effect, calibration: Measurement, strain: FloatArray | None = None) -> Effect:
    """A law where it starts on the measured curve; over another strain than the nominal one, if given."""
    signals = {"strain": calibration.signals["strain"] if strain is None else strain}
    if FORCE_CHANNEL in calibration.measured:
        signals["force_N"] = calibration.measured[FORCE_CHANNEL]
    if CONDUCTANCE_CHANNEL in calibration.measured:
        signals["conductance_S"] = np.exp(calibration.measured[CONDUCTANCE_CHANNEL])
    return law.started(signals, {})


def continued(mine: ModelFile, found: ModelFile) -> ModelFile:
    """The model of a diagnosis on top of the ladder that it was made of, whose last step is the diagnosis's first."""
    if len(found.history) == 1:
        return replace(found, history=mine.history)
    return replace(found, history=(*_with_fit(mine), *found.history[1:]))


def undo(file: ModelFile, catalogue: Catalogue) -> ModelFile:
    """Take the last step back.

    Raises
    ------
    UserError
        If there is only the baseline left.
    """
    if len(file.history) < 2:
        raise UserError("nothing to undo: the ladder has only its first step")
    *earlier, last = file.history[:-1]
    model = model_from_dict(last["model"], catalogue, "history")
    step = {key: value for key, value in last.items() if key != "fit"}
    names = {key: last.get(key, getattr(file, key)) for key in ("fitted_on", "held_out")}
    return replace(file, model=model, history=(*earlier, step), fit=last.get("fit", {}), **names)


def idle_effects(file: ModelFile, calibration: Measurement, held: Measurement, optional: set[str]) -> list[str]:
    """Names of added effects that no longer pay: refitted without them, the held-out error hardly rises."""
    floors = noise_floors(held)
    full = over_the_floors(held_errors(file.model, held), floors)
    idle = []
    for name in optional:
        if name in file.model:
            without = fit(file.model.without(name), calibration, iterations=6).model
            if over_the_floors(held_errors(without, held), floors) < full * (1 + NO_LONGER_PAYS):
                idle.append(name)
    return sorted(idle)
