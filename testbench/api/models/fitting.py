"""`fit`: a model calibrated on a recording."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from gcode.support.figures import picture
from gcode.support.html import card, frame_table
from gcode.support.read_only import free_copy
from testbench.api.arguments import AnyModel, Effects, Source, catalogue_of, model_file_of, recordings_for
from testbench.api.models.model_result import ModelResult, plot_overlay
from testbench.api.progress import Tell, telling
from testbench.comparing.clamping import may_be_clamped_anew
from testbench.comparing.ladder import fitted_file
from testbench.comparing.tables import errors_line, fit_table
from testbench.fitting.baseline import starting_baseline
from testbench.measurements.measurement import Measurement
from testbench.measurements.splitting import split
from testbench.results.model_file import ModelFile, doubted

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

BEYOND = 0.02  # of the calibrated range; less is noise


@dataclass(frozen=True, eq=False, repr=False)
class FitResult(ModelResult):
    """A fitted model, and how well it does.

    Attributes
    ----------
    file : ModelFile
        The model with its parameters' errors and its history, as ``model.json`` holds it.
    calibration, held_out : Measurement
        What it was fitted to, and what it is judged on.
    told : tuple of str
        What `add` has to say of its step.
    """

    file: ModelFile
    calibration: Measurement
    held_out: Measurement
    told: tuple[str, ...] = ()

    @property
    def parameters(self) -> pd.DataFrame:
        """A row a parameter, by address (``effect.parameter``): value, standard error, unit, note."""
        return self.to_frame()

    @property
    def errors(self) -> dict[str, dict[str, float]]:
        """RMS errors in N and ln S: ``calibration``, ``held_out``, ``noise_floor``, each by channel."""
        last = self.file.history[-1]
        return free_copy({**last["errors"], "noise_floor": last["noise_floor"]})

    @property
    def notes(self) -> list[str]:
        """What a reader should know: of the step, of the held-out strain, and of the zero of its displacement."""
        told = [*self.told, beyond_calibration(self.calibration, self.held_out)]
        other = self.calibration.recording is not self.held_out.recording
        if other and not self.held_out.clamp_play_mm:
            told.append(may_be_clamped_anew(self.model, self.held_out))
        return [note for note in told if note]

    def __repr__(self) -> str:
        return f"<FitResult {', '.join(self.model)}: {errors_line(self.file.history[-1])}>"

    def __str__(self) -> str:
        return f"{fit_table(self.file)}\n{errors_line(self.file.history[-1])}"

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready form: the model, its parameters with their errors, and the history of its errors."""
        return {"model": self.model.to_dict(), "fit": free_copy(self.file.fit), "history": self.ladder.to_dict()}

    def to_frame(self) -> pd.DataFrame:
        """As `parameters`."""
        import pandas as pd

        fit, notes = self.file.fit, doubted(self.file.fit)
        frame = pd.DataFrame.from_dict(fit["parameters"], orient="index", columns=["value", "standard_error", "unit"])
        return frame.assign(note=[notes.get(address, "") for address in frame.index]).rename_axis("parameter")

    def plot(self, axes: Axes | Sequence[Axes] | None = None) -> Any:
        """Draw measured and modelled over time, one panel a channel.

        Returns
        -------
        ndarray of Axes, shape (channels,)
        """
        return plot_overlay(self.calibration, {"modelled": self.model}, axes)

    def _repr_html_(self) -> str:
        lines = [errors_line(self.file.history[-1]), *self.notes]
        parts = frame_table(self.to_frame()), picture(self.plot, len(self.calibration.channels))
        return card(f"Fit of {self.calibration.recording.source}", lines, *parts)


def fit(
    recording: Source,
    held_out: Source | None = None,
    *,
    model: AnyModel | None = None,
    effects: Effects = None,
    gauge_length_mm: float | None = None,
    clamp_play_mm: float = 0.0,
    rest_s: float | None = None,
    progress: Tell | bool | None = None,
) -> FitResult:
    """Calibrate the baseline, or a model of your own, on a recording.

    Parameters
    ----------
    recording : Recording or path
        To calibrate on.
    held_out : Recording or path, optional
        To judge on; default: the last third of `recording`, which is then not fitted on.
    model : KnitModel, result or path, optional
        Where the search starts; default: the baseline, started from the data.
    effects : path, Catalogue or effect classes, optional
        The user's own effects.
    gauge_length_mm : float, optional
        In mm, for paths of bare CSV files.
    clamp_play_mm : float
        Where the sensor was clamped anew for `held_out`: by how much, in mm, the zero of its displacement may have
        moved (standard deviation). It is then free there, and so it is in every further step of this model.
    rest_s : float, optional
        `held_out` is of the same specimen, so long after `recording`: it is then judged after all that this one went
        through, in every further step, too. By default it is of a fresh specimen.
    progress : callable or bool, optional
        See `testbench.api.progress.telling`.

    Returns
    -------
    FitResult

    Raises
    ------
    UserError
        If the recordings are too short or still, have a constant channel, or do not fit together.

    Examples
    --------
    >>> import testbench as tb
    >>> fit = tb.fit(tb.example(), progress=False)
    >>> list(fit.model)[:2], list(fit.parameters.columns)
    (['elasticity', 'hysteresis'], ['value', 'standard_error', 'unit', 'note'])
    """
    catalogue = catalogue_of(effects)
    given = None if model is None else model_file_of(model, catalogue)
    first, second, between = recordings_for(model, given, recording, held_out, gauge_length_mm, clamp_play_mm, rest_s)
    calibration, held = split(first, second, between=between)
    start = starting_baseline(calibration, catalogue) if given is None else given.model
    with telling(progress) as tell:
        file = fitted_file(start, calibration, held, "baseline" if given is None else "given model", progress=tell)
    return FitResult(file, calibration, held)


def beyond_calibration(calibration: Measurement, held: Measurement) -> str:
    """What to say where the held-out strain leaves the range that was fitted on; empty where it does not."""
    fitted, judged = (part.signals["strain"][part.counts] for part in (calibration, held))
    margin = BEYOND * float(fitted.max() - fitted.min())
    if judged.max() <= fitted.max() + margin and judged.min() >= fitted.min() - margin:
        return ""
    spans = [f"{100 * strain.min():z.1f} to {100 * strain.max():z.1f} %" for strain in (judged, fitted)]
    return (
        f"{held.recording.source}: the held-out strain, {spans[0]}, leaves the {spans[1]} that was fitted on; "
        "there its errors are those of an extrapolation"
    )
