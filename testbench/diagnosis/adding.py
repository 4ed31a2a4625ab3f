"""Put one effect of the catalogue into a model, started where the data want it, and refit."""

from __future__ import annotations

from collections.abc import Callable

from threadpoolctl import threadpool_limits

from gcode.support.errors import UserError
from testbench.comparing.ladder import drawn_to_data, fitted_file
from testbench.diagnosis.searching.candidates import candidate_mechanisms, is_vector
from testbench.diagnosis.searching.proposals import Screen, laws_of
from testbench.fitting.baseline import framed
from testbench.fitting.evidence.independent_samples import on_the_grid
from testbench.fitting.evidence.laplace import fitted
from testbench.fitting.evidence.sample_noise import likelihood_of, noise_of
from testbench.knit.catalogue import Catalogue
from testbench.knit.effect import Effect
from testbench.knit.model import KnitModel
from testbench.knit.reach import reaching
from testbench.measurements.measurement import Measurement
from testbench.measurements.responses import SIGNAL_OF
from testbench.results.model_file import ModelFile


def add_effect(
    file: ModelFile,
    name: str,
    calibration: Measurement,
    held: Measurement,
    catalogue: Catalogue,
    progress: Callable[[str], None] | None = None,
) -> ModelFile:
    """Add the catalogue's effect `name`, refit everything, and put it on the ladder.

    A law without a strength takes the place of the model's own law of that mechanism.

    Raises
    ------
    UserError
        If the model has that law already, or nothing that the recording has depends on what the effect changes.
    """
    law = file.model.place_of(catalogue[name])
    if law and file.model[law].name == name:
        raise UserError(f"add {name}: the model has this law already; `testbench fit --model` fits it once more")
    check_shows(catalogue[name](), file.model, calibration)
    effect = framed(catalogue[name](), file.model, calibration)
    start = (
        most_likely_start(file.model, effect, calibration) if effect.strength else drawn_to_data(effect, calibration)
    )
    return fitted_file(file.model.plus(start), calibration, held, f"+ {name}", file, progress)


def check_shows(effect: Effect, model: KnitModel, calibration: Measurement) -> None:
    """Refuse an effect that would change nothing of what was measured: no data could tell its size.

    Raises
    ------
    UserError
    """
    signals, larger = [SIGNAL_OF[channel] for channel in calibration.channels], model.plus(effect)
    if not any(larger[name] is effect for name in reaching(larger, signals)):
        raise UserError(
            f"add {effect.name}: it changes {' and '.join(effect.writes)}, and nothing that "
            f"{calibration.recording.source} has ({', '.join(calibration.channels)}) depends on that; choose another "
            "effect, or a recording with that channel and a model fitted on it"
        )


def most_likely_start(model: KnitModel, effect: Effect, calibration: Measurement) -> Effect:
    """`effect` at the point of its grid, and with the strength, whose first-order evidence beside `model` is largest.

    A fit that adds an effect starts here: from the wrong time constant it would not find the right one. What is no
    candidate of the diagnosis (a shape of the base, a second law of a mechanism that the model has) stays as it is;
    what would show at none of its points (a rail that no reading comes near) starts from nothing.
    """
    measurement = on_the_grid(calibration)
    likelihood = likelihood_of(model, measurement, noise_of(calibration))
    with threadpool_limits(1, "blas"):
        hypothesis = fitted(model, likelihood, model, iterations=1)
        own = Catalogue({effect.name: type(effect)})
        laws = laws_of(hypothesis, likelihood, own)
        if not laws:
            is_candidate = candidate_mechanisms(own, model) and not is_vector(type(effect), effect.strength)
            return effect.replaced(**{effect.strength: 0.0}) if is_candidate else effect
        return Screen(hypothesis, likelihood).best_point(laws[0]).effect
