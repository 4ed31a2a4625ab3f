"""What is missing: every law of the catalogue weighed by its evidence, and what was found put in and judged."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from gcode.support.errors import UserError
from testbench.comparing.carried_over import REST_S
from testbench.comparing.same_specimen import with_same_specimen
from testbench.diagnosis.conclusion import concluded
from testbench.diagnosis.result import Diagnosis
from testbench.diagnosis.searching.search import Progress, searched
from testbench.fitting import constants
from testbench.knit.catalogue import Catalogue, load_catalogue
from testbench.knit.model import KnitModel
from testbench.measurements.joining import joined, last_of
from testbench.measurements.measurement import Measurement
from testbench.measurements.splitting import split
from testbench.recordings.between import Between
from testbench.recordings.recording import Recording
from testbench.results.model_file import ModelFile


def diagnose(
    recording: Recording | Sequence[Recording],
    held_out: Recording | None = None,
    model: KnitModel | ModelFile | None = None,
    catalogue: Catalogue | None = None,
    progress: Progress | None = None,
    most: int = constants.ROUNDS,
    clamp_play_mm: float = 0.0,
    rest_s: float | None = None,
) -> Diagnosis:
    """Find out which physical effects a model is missing.

    Parameters
    ----------
    recording : Recording, or sequence of Recording
        To calibrate on; everything is selected on it. Several are of one specimen, in the order in which they were
        made: one history.
    held_out : Recording, optional
        For the final error; default the last third of `recording`. Several recordings need one, made after them.
    model : KnitModel or ModelFile, optional
        Start from this model instead of the baseline. One that was fitted is the first step of the ladder as it is,
        with the errors that `compare` shows; a bare one is fitted first.
    catalogue : Catalogue, optional
        Effects to consider.
    progress : callable, optional
        Called with a short text at each step.
    most : int
        Effects to find at most.
    clamp_play_mm : float
        The sensor was clamped anew for `held_out`, and for each of several recordings: the zero of its displacement
        is free, within so many mm.
    rest_s : float, optional
        Between several recordings; default 60 s. Where it is given for one recording, `held_out` is of the same
        specimen, so long after it; by default it is of a fresh one.

    Raises
    ------
    UserError
        If the recordings are too short or still, have a constant channel, or do not fit together.
    """
    catalogue = catalogue or load_catalogue()
    every = [recording] if isinstance(recording, Recording) else list(recording)
    calibration, held = calibration_and_held_out(every, held_out, clamp_play_mm, rest_s)
    given = model if isinstance(model, ModelFile) and model.fit else None
    start = model.model if isinstance(model, ModelFile) else model
    pieces = constants.INDEPENDENT * len(every)
    search, rounds, put_in = searched(calibration, catalogue, most, start, progress, pieces)
    told = concluded(search, rounds, put_in, calibration, held, given)
    if held_out is None or rest_between(len(every), rest_s) is not None:
        return told
    return replace(told, after=with_same_specimen(told.after, len(told.found), every[0], held_out, clamp_play_mm))


def rest_between(recordings: int, rest_s: float | None) -> float | None:
    """The rest in s before each of so many recordings but the first, and before what is held out; as said, or usual.

    None where there is none: what is held out of one recording is of a fresh specimen.
    """
    return REST_S if rest_s is None and recordings > 1 else rest_s


def calibration_and_held_out(
    recordings: Sequence[Recording],
    held_out: Recording | None,
    clamp_play_mm: float = 0.0,
    rest_s: float | None = None,
) -> tuple[Measurement, Measurement]:
    """What is calibrated on, one history of all recordings, and what is held out; parameters as of `diagnose`.

    What is held out comes after several recordings, and after one where the rest before it was given.
    """
    between = Between(clamp_play_mm, rest_between(len(recordings), rest_s))
    if len(recordings) == 1 or between.rest_s is None:
        return split(recordings[0], held_out, between=between)
    if held_out is None:
        raise UserError("several recordings are one history: give another one to judge on as `held_out`")
    _, held = split(recordings[0], held_out, between=Between(clamp_play_mm))
    rests_s = [between.rest_s] * len(recordings)
    calibration = joined(recordings, rests_s[1:], clamp_play_mm)
    if calibration.channels != held.channels:
        shared, needed = (", ".join(one.channels) or "no channel" for one in (calibration, held))
        raise UserError(
            f"the recordings share {shared}, but {held.recording.source} has {needed}; all need the same channels"
        )
    return calibration, last_of([*recordings, held_out], rests_s, clamp_play_mm)
