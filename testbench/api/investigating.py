"""`investigate`: plan, run, diagnose, and design the motion that separates what is still likely."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from gcode.support.errors import UserError
from gcode.support.figures import panels, picture
from gcode.support.files import write_json
from gcode.support.html import card, frame_table
from gcode.trajectories.trajectory import read_csv
from testbench.api.arguments import AnyModel, Effects, catalogue_of, model_file_of
from testbench.api.progress import Tell, telling
from testbench.investigating import loop
from testbench.investigating.benches import Bench, PortBench, PtyBench, SimulatedBench
from testbench.investigating.state import (
    Investigation,
    RunState,
    Settings,
    load_investigation,
    program_folder,
)
from testbench.investigating.words import ending_words, investigation_words, run_words, spoken
from testbench.knit.catalogue import Catalogue, model_from_dict
from testbench.knit.effect import FloatArray
from testbench.knit.model import KnitModel
from testbench.knit.presets import names as preset_names
from testbench.knit.presets import preset
from testbench.recordings.stored import read_model
from testbench.report.investigation_figures import COLOURS, hypotheses
from testbench.report.investigation_figures import investigation as figure_of
from testbench.report.static import write_figure
from testbench.rig.ports import stated_port
from testbench.rig.recorder import Limits, Status

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

SENSOR = "sensor.json"  # the simulated sensor, kept in the folder: who continues need not name it again


@dataclass(frozen=True, eq=False, repr=False)
class InvestigationResult:
    """An investigation: its runs, and what was believed after each.

    Attributes
    ----------
    state : Investigation
        Everything that is kept in ``investigation.json``.
    folder : Path
    """

    state: Investigation
    folder: Path

    @property
    def hypothesis(self) -> str:
        """The most probable one: ``nothing``, ``unknown`` or a mechanism; empty before the first run was judged."""
        return self.state.belief.top[0] if self.state.belief else ""

    @property
    def probability(self) -> float:
        """Of the most probable hypothesis."""
        return self.state.belief.top[1] if self.state.belief else float("nan")

    @property
    def probabilities(self) -> Mapping[str, float]:
        """After the last run, of every hypothesis; they sum to 1."""
        return self.state.belief.probabilities if self.state.belief else {}

    @property
    def is_sure(self) -> bool:
        """Whether it ended because one hypothesis was sure."""
        return self.state.ended == loop.SURE

    @property
    def minutes(self) -> float:
        """Time of motion."""
        return self.state.spent_s / 60

    @property
    def words(self) -> str:
        """How it ended, in one sentence."""
        return ending_words(self.state)

    def __repr__(self) -> str:
        return f"<InvestigationResult {self.words}>"

    def __str__(self) -> str:
        return investigation_words(self.state)

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready form, the same as ``testbench investigate --json``: settings, runs, ending."""
        return self.state.model_dump(mode="json")

    def to_frame(self) -> pd.DataFrame:
        """A row a run: run, motion, minutes, expected_nats, perlin_nats, hypothesis, probability, verdict."""
        import pandas as pd

        return pd.DataFrame(_row(number, run) for number, run in enumerate(self.state.runs, 1))

    def beliefs(self) -> pd.DataFrame:
        """Probability of each hypothesis (column) after each run (row) that was judged."""
        import pandas as pd

        judged = {number: run.belief for number, run in enumerate(self.state.runs, 1)}
        rows = {number: belief.probabilities for number, belief in judged.items() if belief is not None}
        return pd.DataFrame.from_dict(rows, orient="index").rename_axis("run")

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the belief over the time of motion on `axes` (default: of a new figure); returns them."""
        (axis,) = panels(axes, 1)
        beliefs = self.beliefs()
        minutes = [sum(run.seconds for run in self.state.runs[:number]) / 60 for number in beliefs.index]
        for colour, name in zip(COLOURS, hypotheses(self.state), strict=False):
            axis.plot(minutes, 100 * beliefs[name].fillna(0), marker="o", color=colour, label=spoken(name))
        axis.axhline(100 * self.state.settings.sure, color="0.7", linestyle="--", linewidth=1)
        axis.set_ylim(0, 103)
        axis.set_xlabel("time of motion / min")
        axis.set_ylabel("probability / %")
        if axis.lines[:-1]:
            axis.legend(frameon=False)
        return axis

    def write_picture(self, path: str | Path) -> None:
        """Draw belief and motions into a PNG, PDF or SVG."""
        write_figure(figure_of(self.state, motions_of(self.folder, self.state)), path)

    def _repr_html_(self) -> str:
        return card(self.words, [], picture(lambda axes: self.plot(axes), 1), frame_table(self.to_frame()))


def investigate(
    sensor: AnyModel | str | None = None,
    folder: str | Path = "investigation",
    *,
    port: str | None = None,
    speed: float | None = None,
    resume: bool = False,
    bounds: Mapping[str, float] | None = None,
    run_minutes: float = 3.0,
    budget_minutes: float = 30.0,
    sure: float = 0.95,
    specimen: Literal["aged", "fresh"] = "aged",
    motion: Literal["designed", "perlin"] = "designed",
    rest_s: float = 30.0,
    seed: int = 1,
    trials: int = 24,
    most: int = 2,
    force_max_N: float | None = None,
    gauge_length_mm: float = 25.0,
    model: AnyModel | None = None,
    effects: Effects = None,
    progress: Tell | bool | None = None,
    after_run: Callable[[str], None] | None = None,
    status: Callable[[Status], None] | None = None,
    stopped: Callable[[], bool] = lambda: False,
) -> InvestigationResult:
    """Run experiments until one hypothesis is sure: nothing missing, a mechanism, or something unknown.

    The first run is random motion. Each further one is the motion that is expected to tell most between hypotheses
    that are still likely. Everything is kept in `folder`, step by step, and goes on from there with `resume`.

    Parameters
    ----------
    sensor : KnitModel, result, path or name of a preset, optional
        What hangs in the simulated rig. None with `port` or `resume`.
    folder : path
        New or empty; with `resume` that of an investigation.
    port : str, optional
        A real rig's serial port.
    speed : float, optional
        Record the simulated rig over its pseudo-terminal, so many times faster than real; default: at once.
    bounds : mapping, optional
        Fields of `testbench.Bounds` but the duration: ``v_max_mm_per_s``, ``strain_max_percent``, ...
    run_minutes, budget_minutes : float
        Length of one run; time of motion to spend at most.
    sure : float
        Probability at which it ends.
    specimen : {"aged", "fresh"}
        One specimen that remembers all runs, or a new one for each.
    motion : {"designed", "perlin"}
        ``perlin``: random motion all along, to compare with.
    rest_s : float
        Rest of an aged specimen before each run; a real rig's is measured.
    seed : int
        Of noise and random motion.
    trials : int
        Motions that a design weighs beside the named protocols.
    most : int
        Effects that a diagnosis puts in at most; the belief is about the one that is missing most.
    force_max_N : float, optional
        No motion is designed that any likely hypothesis expects more force of; a real recording stops there.
    model : KnitModel, result or path, optional
        The model that something may be missing from; default: the baseline.
    effects : path, Catalogue or effect classes, optional
        The user's own effects.
    progress : callable or bool, optional
        See `testbench.api.progress.telling`.
    after_run : callable, optional
        Called with a few lines of text after each run.
    status, stopped : callable, optional
        Called with the progress of a recording; asked whether to end early.

    Returns
    -------
    InvestigationResult

    Raises
    ------
    UserError
        If the folder is taken, the limits allow no motion, or a recording cannot be made.

    Examples
    --------
    >>> import tempfile
    >>> import testbench as tb
    >>> where = tempfile.mkdtemp()
    >>> sensor = tb.baseline() + tb.effects.StressRelaxation(fraction=0.3)
    >>> found = tb.investigate(sensor, where, run_minutes=2, budget_minutes=2, most=1, progress=False)
    >>> len(found.state.runs)
    1
    """
    folder, catalogue = Path(folder), catalogue_of(effects)
    hidden, name = _sensor(sensor, catalogue)
    own_effects = Path(effects) if isinstance(effects, str | Path) else None
    if not resume:
        if (hidden is None) == (port is None):
            raise UserError("investigate: give a SENSOR to simulate, or the port of a real rig")
        given = {**(bounds or {}), "duration_s": 60 * run_minutes}
        settings = Settings(
            bounds=given,
            budget_s=60 * budget_minutes,
            sure=sure,
            specimen=specimen,
            motion=motion,
            rest_s=rest_s,
            seed=seed,
            trials=trials,
            effects_at_most=most,
            force_max_N=force_max_N,
            gauge_length_mm=gauge_length_mm,
        )
        loop.begin(folder, settings, name or str(port))
        if hidden is not None:
            write_json(folder / SENSOR, hidden.to_dict())
    state = load_investigation(folder)
    bench = _bench(folder, port, speed, state, catalogue, own_effects)
    start = None if model is None else model_file_of(model, catalogue).model

    def judged(now: Investigation) -> None:
        result = InvestigationResult(now, folder)
        result.write_picture(folder / f"belief-{len(now.runs)}.png")
        if after_run is not None:
            after_run(run_words(len(now.runs), now.runs[-1]))

    with telling(progress) as tell:
        watcher = loop.Watcher(tell or (lambda _text: None), judged, status or (lambda _status: None), stopped)
        return InvestigationResult(loop.proceed(folder, bench, catalogue, start, watcher), folder)


def motions_of(folder: Path, state: Investigation) -> list[tuple[FloatArray, FloatArray]]:
    """Time in s and strain in percent of each run's motion, as far as its plan is there."""
    found = []
    for number in range(1, len(state.runs) + 1):
        path = program_folder(folder, number) / "trajectory.csv"
        if path.is_file():
            planned = read_csv(path)
            found.append((planned.time_s, 100 * planned.position_mm / state.settings.gauge_length_mm))
    return found


def _sensor(sensor: AnyModel | str | None, catalogue: Catalogue) -> tuple[KnitModel | None, str]:
    if sensor is None:
        return None, ""
    if isinstance(sensor, str) and sensor.partition("@")[0] in preset_names():
        return preset(sensor), sensor
    name = Path(sensor).name if isinstance(sensor, str | Path) else "model"
    if isinstance(sensor, str | Path) and not Path(sensor).is_file():
        raise UserError(
            f"{sensor}: no such model.json, and no preset of this name; presets are {', '.join(preset_names())}"
        )
    return model_file_of(sensor, catalogue).model if not isinstance(sensor, str | Path) else _read(
        sensor, catalogue
    ), name


def _read(path: str | Path, catalogue: Catalogue) -> KnitModel:
    return model_from_dict(read_model(path), catalogue, str(path))


def _bench(
    folder: Path, port: str | None, speed: float | None, state: Investigation, catalogue: Catalogue, own: Path | None
) -> Bench:
    if port is not None:
        limits = Limits(max_force_N=state.settings.force_max_N or float("inf"))
        return PortBench(stated_port(port), limits=limits, specimen=state.sensor)
    if not (folder / SENSOR).is_file():
        raise UserError(f"{folder}: was made on a real rig; give its port again to go on")
    simulated = SimulatedBench(_read(folder / SENSOR, catalogue), state.sensor, effects=own)
    if speed is None:
        return simulated
    if not 0 < speed <= 1000:
        raise UserError(f"speed: must be above 0 and at most 1000 times real time, got {speed:g}")
    return PtyBench(simulated, speed)


def _row(number: int, run: RunState) -> dict[str, Any]:
    name, chance = run.belief.top if run.belief else ("", float("nan"))
    return {
        "run": number,
        "motion": run.words,
        "minutes": run.seconds / 60,
        "expected_nats": run.expected_nats,
        "perlin_nats": run.perlin_nats,
        "hypothesis": name,
        "probability": chance,
        "verdict": run.belief.verdict if run.belief else "",
    }
