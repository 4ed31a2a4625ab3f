"""What a model is judged on in a recording: samples that it was not fitted on, with the mounting free.

The command, the notebook, the report and the studio ask here, so that one model has one error on one recording.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from gcode.support.errors import UserError
from testbench.comparing.clamping import Zero, may_be_clamped_anew, moved, zero_of
from testbench.comparing.model_errors import channel_name, noise_floors
from testbench.comparing.remounting import held_errors, remounted
from testbench.knit.model import KnitModel
from testbench.measurements.joining import last_of
from testbench.measurements.measurement import Measurement
from testbench.measurements.preparing import prepare
from testbench.measurements.responses import UNIT_OF
from testbench.measurements.splitting import check_play, split
from testbench.recordings.between import Between
from testbench.recordings.doubts import say_once
from testbench.recordings.recording import Recording
from testbench.results.model_file import ModelFile, same_source

SAME = 3e-3  # relative; noise floors, and errors of one model, of the same samples


@dataclass(frozen=True, eq=False)
class Judged:
    """The samples of one recording that a model is judged on.

    Attributes
    ----------
    measurement : Measurement
        Its displacement counts from `zero`.
    elsewhere : bool
        The model was not fitted on these samples. Force zero, conductance gain and what of an effect belongs to one
        recording are free then.
    zero : Zero, optional
        Where the sensor was clamped anew.
    from_s : float, optional
        Where the last third begins, of a recording that was fitted on before it.
    doubt : str
        What is not known of the samples: whether the model was fitted on them, or why they are judged otherwise than
        when it was made; empty where nothing is.
    """

    measurement: Measurement
    elsewhere: bool
    zero: Zero | None = None
    from_s: float | None = None
    doubt: str = ""

    def mounted(self, model: KnitModel) -> KnitModel:
        """The model with what belongs to one recording fitted to this one."""
        return remounted(model, self.measurement) if self.elsewhere else model

    def notes(self, model: KnitModel) -> list[str]:
        """What a reader should know of these samples, one sentence each; it may cost three simulations."""
        source = self.measurement.recording.source
        if self.from_s is not None:
            return [
                f"{source}: judged on its last third, from {self.from_s:.0f} s on; the model was fitted on the rest"
            ]
        if self.zero is not None:
            told = f"{source}: {self.zero}"
        else:
            told = may_be_clamped_anew(model, self.measurement) if self.elsewhere else ""
        return [note for note in (self.doubt, told) if note]

    def to_dict(self) -> dict[str, Any]:
        """``clamped_anew`` and ``judged_from_s``, where they are known; JSON-ready."""
        found: dict[str, Any] = {} if self.zero is None else {"clamped_anew": asdict(self.zero)}
        return found if self.from_s is None else {**found, "judged_from_s": self.from_s}


def judged(
    file: ModelFile, recording: Recording, clamp_play_mm: float = 0.0, before: Recording | None = None
) -> Judged:
    """The samples of any recording to judge a model on.

    That is the last third where the model was fitted on the rest, all of it otherwise. The held-out recording of
    the model keeps the zero of displacement that its last step found, and the rest before it.

    Parameters
    ----------
    file : ModelFile
    recording : Recording
    clamp_play_mm : float
        The sensor was clamped anew for `recording`: the zero of its displacement is found anew, within so many mm
        (standard deviation).
    before : Recording, optional
        What the model was fitted on, if it is at hand: its held-out recording may be of the same specimen.

    Raises
    ------
    UserError
        If the recording is too short or still; if there is play in what the model was fitted on, or too much.
    """
    check_play(recording, clamp_play_mm)
    if same_source(file.fitted_on, recording.source):
        return _of_its_own(file, recording, clamp_play_mm)
    is_held_out = same_source(file.held_out, recording.source)
    rest_s, doubt = file.between.rest_s if is_held_out else None, ""
    if rest_s is not None and before is not None:
        measurement = last_of([before, recording], [rest_s])
    else:
        measurement = prepare(recording)
        doubt = _taken_for_fresh(file, recording) if is_held_out else _perhaps_fitted_on(file, recording)
    zero = kept_zero(file) if is_held_out else None
    if clamp_play_mm:
        zero = zero_of(file.model, replace(measurement, clamp_play_mm=clamp_play_mm))
    if zero is not None:
        measurement = moved(measurement, zero.shift_mm)
    return Judged(measurement, elsewhere=True, zero=zero, doubt=doubt)


def _taken_for_fresh(file: ModelFile, recording: Recording) -> str:
    """What to say where a held-out recording is judged without what its specimen had gone through; else empty."""
    if file.between.rest_s is None and not file.of_several:
        return ""
    return (
        f"{recording.source}: judged as of a fresh specimen; it is of that of {file.fitted_on}, not there to say "
        "what it had gone through: its errors are not those of the ladder"
    )


def _perhaps_fitted_on(file: ModelFile, recording: Recording) -> str:
    """What to say of a recording of a model that was fitted on several, whose names it does not keep."""
    if not file.of_several:
        return ""
    return (
        f"{recording.source}: taken for new; the model was fitted on {file.fitted_on} in a row, and if this is one "
        "of them, its errors are not those of a prediction"
    )


def _of_its_own(file: ModelFile, recording: Recording, clamp_play_mm: float) -> Judged:
    if clamp_play_mm:
        raise UserError(
            f"{recording.source}: the model was fitted on this recording, so its zero is the model's own; "
            "clamp play is that of another one"
        )
    if not same_source(file.held_out, file.fitted_on):
        return Judged(prepare(recording), elsewhere=False)
    third = split(recording)[1]
    return Judged(third, elsewhere=True, from_s=float(third.grid_s[np.argmax(third.counts)]))


def kept_zero(file: ModelFile) -> Zero | None:
    """The zero of the held-out displacement as the last step of a ladder found it; None: it was not clamped anew."""
    zero = file.history[-1].get("zero") if file.history else None
    return Zero(**zero) if zero else None


def check_judged_on(held: Measurement, step: Mapping[str, Any], model: KnitModel) -> None:
    """Refuse held-out samples that a step of a ladder was not judged on.

    Their noise floors tell them, and the error of its `model` on them, unless that was fitted on several recordings:
    what its specimen had gone through before `held` is not known here.
    """
    told = {"noise floor": (step["noise_floor"], noise_floors(held))}
    if step.get("recordings", 1) == 1:
        told["error"] = step["errors"]["held_out"], held_errors(model, held)
    for what, (kept, here) in told.items():
        # Of several recordings in a row a sample at either end may count or not.
        if kept.keys() != here.keys() or not all(math.isclose(kept[c], here[c], rel_tol=SAME) for c in here):
            there, found = (
                " and ".join(f"{channel_name(c)} {size:.4g} {UNIT_OF[c]}" for c, size in sizes.items())
                for sizes in (kept, here)
            )
            raise UserError(
                f"{held.recording.source}: the diagnosis was judged on other samples: their {what} is {there}, and "
                f"here it is {found}; give the recordings that were diagnosed, or diagnose these"
            )


def held_samples(file: ModelFile, recording: Recording, held_out: Recording | None) -> Measurement:
    """Held-out samples as the last step of a ladder judged them: of `held_out`, or the last third of `recording`."""
    if held_out and file.of_several:
        say_once(_taken_for_fresh(file, held_out))
    rested = Between(rest_s=file.between.rest_s if held_out else None)
    held, zero = split(recording, held_out, between=rested)[1], kept_zero(file)
    return moved(held, zero.shift_mm) if zero else held
