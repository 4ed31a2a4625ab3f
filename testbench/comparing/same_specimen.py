"""A held-out recording taken for one of a fresh specimen may be of the same one, made a while later."""

from __future__ import annotations

from dataclasses import replace

from testbench.comparing.carried_over import REST_S, fails_elsewhere
from testbench.comparing.remounting import held_errors
from testbench.measurements.joining import last_of
from testbench.recordings.recording import Recording
from testbench.results.model_file import ModelFile


def with_same_specimen(
    file: ModelFile, found: int, recording: Recording, held_out: Recording, clamp_play_mm: float
) -> ModelFile:
    """The ladder of a diagnosis; where it fails on a fresh specimen, the last step also says its errors on the same.

    Those are in ``errors["same_specimen"]``: of `held_out` after `recording` and a rest of `REST_S`.

    Parameters
    ----------
    file : ModelFile
        With the ladder of a diagnosis whose held-out recording was taken for one of a fresh specimen.
    found : int
        How many effects were put in.
    recording, held_out : Recording
    clamp_play_mm : float
        See `Measurement`.
    """
    if not fails_elsewhere(file.history, found):
        return file
    again = last_of([recording, held_out], [REST_S], clamp_play_mm)
    *earlier, last = file.history
    errors = {**last["errors"], "same_specimen": held_errors(file.model, again)}
    return replace(file, history=(*earlier, {**last, "errors": errors}))
