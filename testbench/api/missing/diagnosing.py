"""`diagnose`: which physical effect a model is missing."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gcode.support.errors import UserError
from gcode.support.figures import panels, picture
from gcode.support.html import card, frame_table
from gcode.support.kinds import whole
from testbench import diagnosis as core
from testbench.api.arguments import (
    AnyModel,
    Effects,
    Source,
    catalogue_of,
    model_file_of,
    recording_of,
    recordings_for,
)
from testbench.api.models.model_result import ModelResult
from testbench.api.progress import Tell, telling
from testbench.comparing.words import percent, percent_left
from testbench.diagnosis.diagnosis import rest_between
from testbench.diagnosis.result import Diagnosis, Ranked
from testbench.diagnosis.words import diagnosis_table, first_line
from testbench.fitting.constants import ROUNDS
from testbench.investigating.words import spoken
from testbench.measurements.preparing import MAX_GRID_HZ
from testbench.measurements.splitting import MIN_PART
from testbench.recordings.doubts import check_distinct, check_grid
from testbench.recordings.recording import Recording
from testbench.report import style
from testbench.results.model_file import ModelFile
from testbench.results.result_files import checked_diagnosis, read_diagnosis

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

SHOWN = 8


@dataclass(frozen=True, eq=False, repr=False)
class DiagnosisResult(ModelResult):
    """What a model is missing, how sure that is, and the model with it put in.

    Attributes
    ----------
    diagnosis : Diagnosis
        Everything that was found; see `testbench.diagnosis.Diagnosis`.
    """

    diagnosis: Diagnosis

    @property
    def verdict(self) -> str:
        """``missing``, ``nothing_missing`` or ``unknown``."""
        return self.diagnosis.verdict

    @property
    def effect(self) -> str | None:
        """Name of the mechanism that is missing most; None where none is named."""
        return self.diagnosis.found[0].effect if self.diagnosis.found else None

    @property
    def effects(self) -> tuple[str, ...]:
        """Names of all mechanisms that were put in, the most telling first."""
        return tuple(one.effect for one in self.diagnosis.found)

    @property
    def probabilities(self) -> Mapping[str, float]:
        """Of ``nothing``, ``unknown`` and every mechanism: what is missing most; the largest first. They sum to 1.

        Those that are alike stand in the order of the ranking.
        """
        places = {one.effect: place for place, one in enumerate(self.diagnosis.ranking)}
        return dict(sorted(self.diagnosis.probabilities.items(), key=lambda one: (-one[1], places.get(one[0], -1))))

    @property
    def words(self) -> str:
        """What was found, how sure that is and what is left, in one line."""
        return first_line(self.diagnosis)

    @property
    def file(self) -> ModelFile:
        """The model with what was found put in and refitted, as ``model.json`` holds it."""
        return self.diagnosis.after

    def __repr__(self) -> str:
        return f"<DiagnosisResult {self.words}>"

    def __str__(self) -> str:
        return diagnosis_table(self.diagnosis)

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready form, the same as ``testbench diagnose --json``; documented in docs/finding-effects.md."""
        return self.diagnosis.to_dict()

    def to_frame(self) -> pd.DataFrame:
        """A row a mechanism, the most probable first: effect, law, probability, evidence, what it leaves, tied.

        ``held_out_error_left`` is the share of the RMS error that a refit with it leaves on held-out samples, and
        ``_low`` and ``_high`` are its 95 % interval; NaN where the mechanism was not worth a refit.
        """
        import pandas as pd

        return pd.DataFrame(
            {
                "effect": one.effect,
                "law": one.law,
                "probability": one.probability,
                "log_evidence_nats": one.log_evidence,
                **_error_left(one),
                "tied": one.effect in self.diagnosis.tied,
            }
            for one in self.diagnosis.ranking
        )

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the probabilities of what may be missing, the largest on top.

        Parameters
        ----------
        axes : Axes, optional
            Where to draw; default: a new figure.

        Returns
        -------
        Axes
        """
        (axis,) = panels(axes, 1)
        shown = list(self.probabilities.items())[:SHOWN]
        found = self.effects
        colours = [style.VERMILION if name in found else style.SKY for name, _ in shown]
        axis.barh(range(len(shown)), [100 * chance for _, chance in shown], color=colours)
        names = [f"{spoken(name)} ({percent(chance)})" for name, chance in shown]
        axis.set_yticks(range(len(shown)), names)
        axis.invert_yaxis()
        axis.set_xlim(0, 100)
        axis.set_xlabel("probability that it is what is missing most (%)")
        return axis

    def _repr_html_(self) -> str:
        frame = frame_table(self.to_frame().head(SHOWN))
        return card(self.words, [], picture(self.plot, 1), frame)


def diagnose(
    recording: Source | list[Source] | tuple[Source, ...],
    held_out: Source | None = None,
    *,
    model: AnyModel | None = None,
    effects: Effects = None,
    most: int = ROUNDS,
    gauge_length_mm: float | None = None,
    clamp_play_mm: float = 0.0,
    rest_s: float | None = None,
    progress: Tell | bool | None = None,
) -> DiagnosisResult:
    """Find out which physical effects a model is missing.

    Parameters
    ----------
    recording : Recording or path, or a list of them
        To calibrate on; everything is selected on it. Several are of one specimen, in the order in which they were
        made: one history.
    held_out : Recording or path, optional
        For the final errors; default: the last third of `recording`. Several recordings need one, made after them.
    model : KnitModel, result or path, optional
        Diagnose this one instead of the baseline.
    effects : path, Catalogue or effect classes, optional
        The user's own effects, which take part in everything.
    most : int
        Effects to find at most, one after the other.
    gauge_length_mm : float, optional
        In mm, for paths of bare CSV files; default: the model's.
    clamp_play_mm : float
        The sensor was clamped anew for `held_out`, and for each of several recordings: the zero of its displacement
        is free, within so many mm. Default: as the model was fitted.
    rest_s : float, optional
        Rest between several recordings, in which the strain goes from where one ended to where the next begins;
        default 60 s. Where it is given for one recording, `held_out` is of the same specimen, so long after it; by
        default it is as the model was fitted, or of a fresh one.
    progress : callable or bool, optional
        See `testbench.api.progress.telling`.

    Returns
    -------
    DiagnosisResult

    Raises
    ------
    UserError
        If the recordings are too short or still, have a constant channel, or do not fit together.

    Examples
    --------
    >>> import testbench as tb
    >>> recording = tb.example(tb.effects.StressRelaxation(fraction=0.3), duration_s=90)
    >>> d = tb.diagnose(recording, most=1, progress=False)
    >>> d.effect
    'stress_relaxation'
    >>> round(sum(d.probabilities.values()), 6)
    1.0
    """
    most = whole("most: effects to find", most, 1)
    catalogue = catalogue_of(effects)
    given = None if model is None else model_file_of(model, catalogue)
    sources = list(recording) if isinstance(recording, list | tuple) else [recording]
    if not sources:
        raise UserError("recording: must be one or more, got none")
    first, held, between = recordings_for(model, given, sources[0], held_out, gauge_length_mm, clamp_play_mm, rest_s)
    more = [recording_of(one, gauge_length_mm, first.gauge_length_mm) for one in sources[1:]]
    rest = rest_between(len(sources), between.rest_s)
    if more and rest is not None:  # of one and what is held out, `recordings_for` has asked
        _check_one_history([first, *more, *([] if held is None else [held])], rest)
    with telling(progress) as tell:
        found = core.diagnose([first, *more], held, given, catalogue, tell, most, between.clamp_play_mm, rest)
    return DiagnosisResult(found)


def _error_left(one: Ranked) -> dict[str, float]:
    """What a refit with a mechanism leaves of the held-out RMS error, and its interval, as shares of it."""
    gain, low, high = one.held_out_gain or (math.nan,) * 3
    names = "held_out_error_left", "held_out_error_left_low", "held_out_error_left_high"
    return {name: percent_left(value) / 100 for name, value in zip(names, (gain, high, low), strict=True)}


def _check_one_history(recordings: Sequence[Recording], rest_s: float) -> None:
    """Refuse recordings that cannot be one history: given twice, or too much for one grid."""
    check_distinct(
        recordings,
        "of several recordings each is made after the ones before it: give each once, and another one as `held_out`",
    )
    check_grid(recordings[1:], recordings[0], MAX_GRID_HZ, MIN_PART, rest_s)


def diagnosis_data(diagnosis: DiagnosisResult | str | Path) -> Mapping[str, Any]:
    """A diagnosis, or the file of one, as pages and designs read it."""
    if isinstance(diagnosis, DiagnosisResult):
        return checked_diagnosis(json.loads(json.dumps(diagnosis.to_dict())), "diagnosis")
    return read_diagnosis(diagnosis)
