"""Where rival hypotheses come from: two model files, or the tied effects of a diagnosis."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from gcode.support.errors import UserError
from testbench.comparing.carried_over import step_before
from testbench.design.imitation import Rival
from testbench.diagnosis.adding import add_effect
from testbench.knit.catalogue import Catalogue, model_from_dict
from testbench.knit.model import KnitModel
from testbench.measurements.measurement import Measurement
from testbench.results.model_file import ModelFile

MOST = 3  # tied effects that are weighed against each other


def rivals_of(files: Mapping[str, ModelFile]) -> tuple[list[Rival], dict[str, float], float]:
    """Rivals, noise floors and gauge length [mm] from fitted models, by name.

    Raises
    ------
    UserError
        If one was never fitted, or they were at different gauge lengths or on different channels.
    """
    if unfitted := [name for name, file in files.items() if not file.history]:
        raise UserError(f"{unfitted[0]}: was never fitted, and knows no noise floor; fit it on a recording first")
    (name, first), *others = files.items()
    for path, file in others:
        if abs(file.gauge_length_mm - first.gauge_length_mm) > 1e-3 * first.gauge_length_mm:
            raise UserError(
                f"{path}: fitted at a gauge length of {file.gauge_length_mm:g} mm, but {name} at "
                f"{first.gauge_length_mm:g} mm; rivals must be fitted on recordings of one set-up"
            )
    rivals = [Rival(name, file.model) for name, file in files.items()]
    return rivals, shared_noise(list(files.values())), first.gauge_length_mm


def rivals_from_diagnosis(
    data: Any,
    source: str,
    calibration: Measurement,
    held: Measurement,
    catalogue: Catalogue,
    progress: Callable[[str], None],
) -> tuple[list[Rival], dict[str, float]]:
    """Put each tied effect (or the first two) into the model before it, refit, and let them be rivals.

    Parameters
    ----------
    data : mapping
        A diagnosis as ``testbench diagnose --json`` writes it.
    source : str
        Where it came from, for messages.

    Raises
    ------
    UserError
        If it is no diagnosis, or ranks fewer than two effects.
    """
    try:
        base = _base(data, catalogue, source, calibration.recording.gauge_length_mm)
        laws = {entry["effect"]: entry["law"] for entry in data["ranking"]}
        names = list(data.get("tied", ())) or list(laws)[:2]
    except (KeyError, IndexError, TypeError) as error:
        raise UserError(f"{source}: not a diagnosis ({error}); write one with `testbench diagnose --json`") from None
    if len(names) < 2:
        raise UserError(f"{source}: it ranks {len(names)} effects; an experiment needs two rivals")
    files = []
    for name in names[:MOST]:
        progress(f"putting in {laws[name]} and refitting")
        files.append(add_effect(base, laws[name], calibration, held, catalogue))
    rivals = [Rival(name, file.model) for name, file in zip(names, files, strict=False)]
    return rivals, shared_noise(files)


def _base(data: Mapping[str, Any], catalogue: Catalogue, source: str, gauge_length_mm: float) -> ModelFile:
    """The model as it was before anything that was found was put in."""
    before = step_before(data["history"], len(data["found"]))
    model = model_from_dict(before["model"], catalogue, source)
    return ModelFile(model, gauge_length_mm, history=(before,))


def shared_noise(files: Sequence[ModelFile]) -> dict[str, float]:
    """What the best of the rivals leaves of each channel that all were fitted on, at least the noise floor.

    Not the noise floor alone: a misfit that all rivals share would drown a smaller difference between them.
    """
    floors = [file.history[-1]["noise_floor"] for file in files]
    shared = [channel for channel in floors[0] if all(channel in floor for floor in floors)]
    if not shared:
        raise UserError("the models were fitted on different channels; give rivals that share force or resistance")
    spreads = [file.fit.get("residual_scale", {}) for file in files]
    both = list(zip(floors, spreads, strict=True))
    return {channel: min(max(f[channel], s.get(channel, 0.0)) for f, s in both) for channel in shared}


def told_apart(models: Mapping[str, KnitModel]) -> list[str]:
    """A name for each model: the effects that not all of them have, or that it is without them.

    Where these tell nothing, or the same of two, the names as they are given.
    """
    common = set.intersection(*map(set, models.values()))
    own = [[name for name in model if name not in common] for model in models.values()]
    lacking = "without " + " and ".join(dict.fromkeys(name for names in own for name in names))
    told = [" + ".join(names) or lacking for names in own]
    return told if len(set(told)) == len(told) else list(models)
