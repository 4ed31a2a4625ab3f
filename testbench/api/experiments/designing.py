"""`next_experiment`: the next experiment, chosen to tell rival models apart."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gcode.programs.make import Made
from gcode.support.errors import UserError
from gcode.support.figures import picture, rows_to_draw
from gcode.support.html import card, frame_table
from gcode.support.kinds import flag, whole
from testbench.api.arguments import AnyModel, Effects, Source, catalogue_of, model_file_of, recordings_for
from testbench.api.missing.diagnosing import DiagnosisResult, diagnosis_data
from testbench.api.progress import Tell, telling
from testbench.design import experiment
from testbench.design.experiment import Option
from testbench.design.experiment_words import experiment_table, verdict
from testbench.design.imitation import Rival
from testbench.design.protocols import Bounds, bounds_with, menu
from testbench.design.rivals import rivals_from_diagnosis, rivals_of, told_apart
from testbench.knit.catalogue import Catalogue
from testbench.knit.effect import FloatArray
from testbench.measurements.splitting import split
from testbench.recordings.channels import TEMPERATURE
from testbench.report.figures.experiment_figures import of_file, ranking
from testbench.report.writing.static import draw_on, write_figure

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes


@dataclass(frozen=True, eq=False, repr=False)
class NextExperiment:
    """Designed protocols, ranked by how well they tell rival models apart.

    Attributes
    ----------
    rivals : tuple of Rival
    options : tuple of Option
        The best first.
    gauge_length_mm : float
    """

    rivals: tuple[Rival, ...]
    options: tuple[Option, ...]
    gauge_length_mm: float

    @property
    def words(self) -> str:
        """What to do next and how decisive it will be, in one sentence."""
        return verdict(self.options)

    @property
    def program(self) -> Made:
        """The best protocol with its checked program: ``.write(folder)``."""
        return self.options[0].made

    def __repr__(self) -> str:
        return f"<NextExperiment {self.words}>"

    def __str__(self) -> str:
        return experiment_table(self.rivals, self.options)

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready form: the ranking, and what the best would show, thinned to what a screen can draw."""
        left = {}
        for channel, (time_s, values) in self.left().items():
            rows = rows_to_draw(values)
            left[channel] = {"time_s": time_s[rows].round(3).tolist(), "over_noise": values[rows].round(4).tolist()}
        return {
            "rivals": [rival.name for rival in self.rivals],
            "gauge_length_mm": self.gauge_length_mm,
            "options": [option.to_dict() for option in self.options],
            "left": left,
        }

    def left(self) -> dict[str, tuple[FloatArray, FloatArray]]:
        """What the wrong model cannot imitate: by channel, time in s and misfit over the noise, each shape (n,)."""
        best = self.options[0]
        time_s = best.made.trajectory.time_s
        return {channel: (time_s[-len(values) :], values) for channel, values in best.hardest.left.items()}

    def to_frame(self) -> pd.DataFrame:
        """A row a protocol, the best first: duration_s, noise_units, log_odds in nats, grade, channel, ..."""
        import pandas as pd

        return pd.DataFrame(option.to_dict() for option in self.options)

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the expected log odds of every protocol on `axes` (default: of a new figure); returns them."""
        return draw_on(ranking([(option.name, option.hardest.log_odds) for option in self.options]), axes)[0]

    def write_picture(self, path: str | Path) -> None:
        """Draw the ranking, the best motion and what it would show into a PNG, PDF or SVG."""
        made = self.program.trajectory
        strain = 100 * made.position_mm / self.gauge_length_mm
        write_figure(of_file(self.to_dict(), made.time_s, strain), path)

    def _repr_html_(self) -> str:
        frame = frame_table(self.to_frame())
        return card(self.words, [], picture(self.plot, 1), frame)


def next_experiment(
    rivals: Sequence[AnyModel] | Mapping[str, AnyModel] | DiagnosisResult | str | Path,
    recording: Source | None = None,
    held_out: Source | None = None,
    *,
    bounds: Bounds | Mapping[str, float] | None = None,
    seed: int = 1,
    temperature: bool = False,
    effects: Effects = None,
    gauge_length_mm: float | None = None,
    progress: Tell | bool | None = None,
) -> NextExperiment:
    """Rank designed protocols by how well they tell rival models apart, after each did its best to imitate.

    Parameters
    ----------
    rivals : sequence or mapping of results or paths, or a diagnosis
        Two or more fitted models, by name in a mapping, else called after the effects that not all of them have; or a
        diagnosis (a result, or the path of its JSON), whose tied effects are each put in and refitted on `recording`.
    recording, held_out : Recording or path, optional
        With a diagnosis only: what it was made on.
    bounds : Bounds or mapping, optional
        Fields of `testbench.Bounds` that differ from its defaults: ``v_max_mm_per_s``, ``strain_max_percent``, ...
    seed : int
        Of the random protocols.
    temperature : bool
        The temperature will be measured too.
    effects : path, Catalogue or effect classes, optional
        The user's own effects.
    gauge_length_mm : float, optional
        In mm; default: of the recording, or that the models were fitted at.
    progress : callable or bool, optional
        See `testbench.api.progress.telling`.

    Returns
    -------
    NextExperiment

    Raises
    ------
    UserError
        If the rivals are fewer than two or the same, or no protocol keeps the limits.

    Examples
    --------
    >>> import testbench as tb
    >>> recording = tb.example(tb.effects.StressRelaxation(fraction=0.3), duration_s=60)
    >>> base = tb.fit(recording, progress=False)
    >>> other = tb.fit(recording, model=base.model + tb.effects.StressRelaxation(), progress=False)
    >>> plan = tb.next_experiment([base, other], bounds={"duration_s": 120}, progress=False)
    >>> plan.program.gauge_length_mm
    25.0
    """
    catalogue, seed = catalogue_of(effects), whole("seed:", seed, 0)
    temperature = flag("temperature", temperature)
    with telling(progress) as tell:
        if isinstance(rivals, DiagnosisResult | str | Path):
            if recording is None:
                raise UserError("next_experiment: a diagnosis needs the recording that its rivals are refitted on")
            first, held, _ = recordings_for(None, None, recording, held_out, gauge_length_mm)
            data, source = diagnosis_data(rivals), "diagnosis" if isinstance(rivals, DiagnosisResult) else str(rivals)
            menu(bounds_with(bounds_said(bounds), first.gauge_length_mm))  # refused before the refits
            say = tell or (lambda _text: None)
            found, noise = rivals_from_diagnosis(data, source, *split(first, held), catalogue, say)
            gauge, temperature = first.gauge_length_mm, temperature or first.has(TEMPERATURE)
        else:
            if recording is not None or held_out is not None:
                raise UserError("next_experiment: models are as they were fitted; leave recording and held_out out")
            found, noise, gauge = _fitted(rivals, catalogue)
            gauge = gauge if gauge_length_mm is None else gauge_length_mm
        limits = bounds_with(bounds_said(bounds), gauge)
        return NextExperiment(
            tuple(found), tuple(experiment.propose(found, noise, limits, seed, temperature, tell)), gauge
        )


def _fitted(
    rivals: Sequence[AnyModel] | Mapping[str, AnyModel], catalogue: Catalogue
) -> tuple[list[Rival], dict[str, float], float]:
    given = len(rivals) if isinstance(rivals, Sequence | Mapping) else repr(rivals)
    if isinstance(given, str) or given < 2:
        raise UserError(f"next_experiment: give two or more rival models, got {given}")
    if isinstance(rivals, Mapping):
        return rivals_of({str(name): model_file_of(one, catalogue) for name, one in rivals.items()})
    names = [str(one) if isinstance(one, str | Path) else f"model {n}" for n, one in enumerate(rivals, 1)]
    unique = names if len(set(names)) == len(names) else [f"{name} ({n})" for n, name in enumerate(names, 1)]
    found, noise, gauge_mm = rivals_of(
        {name: model_file_of(one, catalogue) for name, one in zip(unique, rivals, strict=True)}
    )
    told = told_apart({rival.name: rival.model for rival in found})
    return [replace(rival, name=name) for rival, name in zip(found, told, strict=True)], noise, gauge_mm


def bounds_said(bounds: Mapping[str, float] | Bounds | None) -> dict[str, float]:
    """The fields that differ from the defaults."""
    if isinstance(bounds, Bounds):
        usual = asdict(Bounds())
        return {name: value for name, value in asdict(bounds).items() if value != usual[name]}
    if not isinstance(bounds or {}, Mapping):
        raise UserError(f"bounds must be testbench.Bounds or a mapping of its fields, got {type(bounds).__name__}")
    return dict(bounds or {})
