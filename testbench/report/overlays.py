"""From recordings and models to what the figures need: simulated signals over measured ones, steps of a ladder."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from testbench.comparing.cell import Cell
from testbench.comparing.compare import Comparison, residual_maps
from testbench.comparing.judged import kept_zero
from testbench.comparing.model_errors import noise_floors
from testbench.comparing.remounting import remounted
from testbench.comparing.residual_coordinates import coordinates
from testbench.comparing.words import spoken
from testbench.knit.catalogue import Catalogue, model_from_dict
from testbench.knit.model import KnitModel
from testbench.measurements.measurement import Measurement
from testbench.report.downsample import liveliest
from testbench.report.figures.comparison_figures import Overlay
from testbench.report.figures.ladder_figures import Step
from testbench.results.model_file import ModelFile

LOOK_S = 30.0  # how much is shown around a place


def zero_in_words(file: ModelFile) -> str:
    """What to say of the zero of a held-out recording that was clamped anew; empty where it was not."""
    zero = kept_zero(file)
    return f"The held-out recording was {zero}. This is no finding about the sensor." if zero else ""


def overlay_of(
    measurement: Measurement,
    models: Mapping[str, KnitModel],
    free_offset: bool = False,
    held_out_from_s: float | None = None,
) -> Overlay:
    """Simulate `models` along a measurement.

    Parameters
    ----------
    measurement : Measurement
    models : mapping of label to KnitModel
        In the order of drawing.
    free_offset : bool
        Shift each modelled signal to the measured mean and fit what belongs to this recording alone, as errors on
        another recording are counted: force zero and conductance gain belong to the mounting.
    held_out_from_s : float, optional
        Where the held-out part begins.
    """
    mounted = {label: remounted(model, measurement) if free_offset else model for label, model in models.items()}
    modelled = {label: measurement.modelled(model) for label, model in mounted.items()}
    if free_offset:
        modelled = {label: _shifted(signals, measurement) for label, signals in modelled.items()}
    return Overlay(
        measurement.grid_s - measurement.begin_s,
        measurement.signals["strain_nominal"],
        dict(measurement.measured),
        modelled,
        noise_floors(measurement),
        held_out_from_s,
    )


def as_read(both: Overlay, measurement: Measurement) -> Overlay:
    """The overlay without the grid points in gaps of the recording: what stands there was made up between samples.

    What the specimen went through before is not shown.
    """
    time_s, first_s = measurement.grid_s, float(measurement.recording.time_s[0])
    hidden = measurement.signals["time_s"] < measurement.begin_s
    for start_s, end_s in measurement.recording.gaps:
        hidden |= (time_s > start_s - first_s) & (time_s < end_s - first_s)
    return both.within(~hidden)


def _shifted(signals: Mapping[str, np.ndarray], measurement: Measurement) -> dict[str, np.ndarray]:
    rows = measurement.counts
    return {
        channel: values + np.mean(measurement.measured[channel][rows] - values[rows])
        for channel, values in signals.items()
    }


def maps_of(
    compared: Comparison, measurement: Measurement, both: Overlay, free_offset: bool
) -> Mapping[str, Mapping[str, Sequence[Cell]]]:
    """Mean residuals by channel and coordinate, those of the resistance in kΩ beside those of the conductance.

    `both` is the overlay of the model that was compared.
    """
    if "conductance" not in both.measured:
        return compared.maps
    counts = measurement.counts
    rows = {name: values[counts] for name, values in coordinates(measurement).items()}
    kohm = both.in_resistance().residual("resistance")[counts]
    return {**compared.maps, "resistance": residual_maps(kohm - kohm.mean() if free_offset else kohm, rows)}


def spans_of(compared: Comparison, measurement: Measurement, both: Overlay) -> list[tuple[float, float]]:
    """For each of the worst places, start and end in s of the stretch in which it adds most to the squared error."""
    where, found = coordinates(measurement), []
    for place in compared.worst:
        values, direction = where[place.coordinate], place.cell.direction
        inside = measurement.counts & (values >= place.cell.low) & (values <= place.cell.high)
        if direction:
            inside &= where["direction"] == direction
        energy = np.where(inside, both.residual(place.channel) ** 2, 0.0)
        found.append(liveliest(both.time_s, energy, LOOK_S))
    return found


def steps_in_resistance(file: ModelFile, catalogue: Catalogue, judged: Measurement) -> list[Step]:
    """The ladder with the error of the resistance in kΩ, each model simulated along the held-out samples."""
    found = []
    for entry, step in zip(file.history, steps_of(file.history), strict=True):
        model = model_from_dict(entry["model"], catalogue, "history")
        both = overlay_of(judged, {step.label: model}, free_offset=True).within(judged.counts).in_resistance()
        errors = {
            channel: float(np.std(both.residual(channel))) if channel == "resistance" else step.errors[channel]
            for channel in both.measured
        }
        found.append(Step(step.label, errors, {channel: both.noise_floor[channel] for channel in both.measured}))
    return found


def steps_of(history: Sequence[Mapping[str, Any]]) -> list[Step]:
    """The ladder of a model file, held-out errors."""
    return [Step(step_label(entry["step"]), entry["errors"]["held_out"], entry["noise_floor"]) for entry in history]


def step_label(step: str) -> str:
    """Short name of a step: several shapes of the base laws are one thing to a reader."""
    names = step.removeprefix("+ ").split(", ")
    return "+ base shapes" if len(names) > 1 and all(name.endswith("_shape") for name in names) else spoken(step)


def models_of(file: ModelFile, catalogue: Catalogue) -> dict[str, KnitModel]:
    """The first and the last model of a ladder, by the name of their step; one when there is only one."""
    if not file.history:
        return {"model": file.model}
    first = file.history[0]
    models = {step_label(first["step"]): model_from_dict(first["model"], catalogue, "history")}
    if len(file.history) > 1:
        last, count = step_label(file.history[-1]["step"]), len(file.history)
        models[last if count == 2 else f"{last} (after {count - 1} steps)"] = file.model
    return models
