"""`add`: an effect put into a model, started where the data want it, and everything refitted."""

from __future__ import annotations

from pathlib import Path

from testbench.api.arguments import AnyModel, Effects, Source, catalogue_of, model_file_of, recording_of
from testbench.api.fitting import FitResult
from testbench.api.progress import Tell, telling
from testbench.diagnosis.adding import add_effect
from testbench.fitting.measurement import split
from testbench.fitting.model_file import check_same_set_up


def add(
    model: AnyModel,
    effect: str,
    recording: Source,
    held_out: Source | None = None,
    *,
    effects: Effects = None,
    gauge_length_mm: float | None = None,
    progress: Tell | bool | None = None,
) -> FitResult:
    """Put an effect of the catalogue into a model, refit, and put the step on the ladder.

    The search starts at the strength and the times that the residual asks for; ``tb.fit(recording, model=fit.model +
    effect)`` starts at the parameters of `effect` instead.

    Parameters
    ----------
    model : KnitModel, result or path
    effect : str
        Its name in the catalogue (``testbench effects`` lists them).
    recording, held_out : Recording or path
        To refit on, and to judge on; default: the last third of `recording`.
    effects : path, Catalogue or effect classes, optional
        The user's own effects.
    gauge_length_mm : float, optional
        In mm, for paths of bare CSV files; default: the model's.
    progress : callable or bool, optional
        See `testbench.api.progress.telling`.

    Returns
    -------
    FitResult

    Raises
    ------
    UserError
        If there is no such effect, or the recordings do not fit the model or each other.

    Examples
    --------
    >>> import testbench as tb
    >>> recording = tb.example(tb.effects.StressRelaxation(fraction=0.3))
    >>> base = tb.fit(recording, progress=False)
    >>> tb.add(base, "stress_relaxation", recording, progress=False).ladder
    <Ladder baseline + stress_relaxation>
    """
    catalogue = catalogue_of(effects)
    file = model_file_of(model, catalogue)
    gauge_length_mm = gauge_length_mm or file.gauge_length_mm or None
    first = recording_of(recording, gauge_length_mm)
    check_same_set_up(file, first, model if isinstance(model, str | Path) else "model")
    second = None if held_out is None else recording_of(held_out, gauge_length_mm)
    calibration, held = split(first, second, clamp_play_mm=file.clamp_play_mm if second else 0.0)
    with telling(progress) as tell:
        return FitResult(add_effect(file, effect, calibration, held, catalogue, tell), calibration, held)
