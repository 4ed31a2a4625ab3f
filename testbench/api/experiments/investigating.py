"""`investigate`: plan, run, diagnose, and design the motion that separates what is still likely."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Literal

from gcode.support.errors import UserError
from gcode.support.files import refuse_links, write_json
from gcode.support.kinds import path_of
from gcode.support.strict import validated
from testbench.api.arguments import AnyModel, Effects, catalogue_of, model_file_of, model_name
from testbench.api.experiments.investigation import InvestigationResult
from testbench.api.progress import Tell, telling
from testbench.investigating import loop
from testbench.investigating.benches import Bench, PortBench, PtyBench, SimulatedBench
from testbench.investigating.state import Investigation, Settings, go_on, load_investigation, run_folder
from testbench.investigating.words import run_words
from testbench.knit.catalogue import Catalogue
from testbench.rig.acquisition.recorder import Limits, Status
from testbench.rig.connection.ports import stated_port

SENSOR = "sensor.json"  # the simulated sensor, kept in the folder: who continues need not name it again


def investigate(
    sensor: AnyModel | None = None,
    folder: str | Path = "investigation",
    *,
    port: str | None = None,
    speed: float | None = None,
    resume: bool = False,
    bounds: Mapping[str, float] | None = None,
    run_minutes: float = 3.0,
    budget_minutes: float | None = None,
    sure: float | None = None,
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

    The first run has a bit of everything. Each further one is the motion that is expected to tell most between
    hypotheses that are still likely. Everything is kept in `folder`, step by step, and goes on from there with
    `resume`.

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
    run_minutes : float
        Length of one run.
    budget_minutes, sure : float, optional
        Time of motion to spend at most, and probability at which it ends; default: 30 and 0.95, with `resume` as they
        were. What else is asked of an investigation stays as it began.
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
    gauge_length_mm : float
        Length of the unstretched sensor between the clamps.
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
    folder, catalogue = path_of(folder, "folder"), catalogue_of(effects)
    hidden = None if sensor is None else model_file_of(sensor, catalogue).model
    own_effects = Path(effects) if isinstance(effects, str | Path) else None
    if resume:
        if sensor is not None:
            raise UserError(f"investigate: {folder} knows its sensor; to go on with it leave SENSOR out")
        refuse_links(folder.glob("*"), "copy the folder and use the copy")
        go_on(folder, budget_minutes, sure)
    elif (hidden is None) == (port is None):
        raise UserError("investigate: give a SENSOR to simulate, or the port of a real rig")
    else:
        asked = {
            "bounds": {**(bounds or {}), "duration_s": 60 * run_minutes},
            "budget_s": 60 * (30.0 if budget_minutes is None else budget_minutes),
            "sure": 0.95 if sure is None else sure,
            "specimen": specimen,
            "motion": motion,
            "rest_s": rest_s,
            "seed": seed,
            "trials": trials,
            "effects_at_most": most,
            "force_max_N": force_max_N,
            "gauge_length_mm": gauge_length_mm,
        }
        settings = validated(asked, Settings, "investigate", "set of limits")
        loop.begin(folder, settings, str(port) if sensor is None else model_name(sensor))
        if hidden is not None:
            write_json(folder / SENSOR, hidden.to_dict())
    told = partial(_told, folder, after_run)
    with _forgotten_unless_begun(folder, resume), telling(progress) as tell:
        state = load_investigation(folder)
        bench = _bench(folder, port, speed, state, catalogue, own_effects)
        start = None if model is None else model_file_of(model, catalogue).model
        watcher = loop.Watcher(tell or (lambda _text: None), told, status or (lambda _status: None), stopped)
        return InvestigationResult(loop.proceed(folder, bench, catalogue, start, watcher), folder)


@contextmanager
def _forgotten_unless_begun(folder: Path, resumed: bool) -> Iterator[None]:
    """Take a new investigation away that bad words end before anything was recorded: the right ones may begin it."""
    try:
        yield
    except UserError:
        if not resumed and not run_folder(folder, 1).exists():
            shutil.rmtree(folder)
        raise


def _told(folder: Path, after_run: Callable[[str], None] | None, now: Investigation) -> None:
    """A picture of the belief after each run, and a few lines for whoever asked for them."""
    InvestigationResult(now, folder).write_picture(folder / f"belief-{len(now.runs)}.png")
    if after_run is not None:
        after_run(run_words(len(now.runs), now.runs[-1]))


def _bench(
    folder: Path, port: str | None, speed: float | None, state: Investigation, catalogue: Catalogue, own: Path | None
) -> Bench:
    if port is not None:
        limits = Limits(max_force_N=state.settings.force_max_N or float("inf"))
        return PortBench(stated_port(port), limits=limits, specimen=state.sensor)
    if not (folder / SENSOR).is_file():
        raise UserError(f"{folder}: was made on a real rig; give its port again to go on")
    simulated = SimulatedBench(model_file_of(folder / SENSOR, catalogue).model, state.sensor, effects=own)
    if speed is None:
        return simulated
    if not 0 < speed <= 1000:
        raise UserError(f"speed: must be above 0 and at most 1000 times real time, got {speed:g}")
    return PtyBench(simulated, speed)
