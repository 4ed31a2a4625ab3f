"""`investigate`: plan, run, diagnose, and design the motion that separates what is still likely."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import Literal

from gcode.support.errors import UserError
from gcode.support.files import copy_file, refuse_links, sha256_of, write_json
from gcode.support.kinds import flag, number, path_of, whole
from testbench.api.arguments import AnyModel, Effects, catalogue_of, model_file_of, model_name
from testbench.api.experiments.designing import bounds_said
from testbench.api.experiments.investigation import InvestigationResult
from testbench.api.progress import Tell, telling
from testbench.campaigns.plan import EFFECTS, effects_kept
from testbench.design.protocols import Bounds, check_duration
from testbench.investigating import loop
from testbench.investigating.benches import Bench, PortBench, PtyBench, SimulatedBench
from testbench.investigating.state import (
    NAME,
    Investigation,
    Settings,
    go_on,
    load_investigation,
    program_folder,
    run_folder,
)
from testbench.investigating.words import run_words
from testbench.knit.catalogue import Catalogue, load_catalogue
from testbench.knit.model import KnitModel
from testbench.rig.acquisition.recorder import Limits, Status
from testbench.rig.connection.ports import stated_port
from testbench.trust import named_effects

# The simulated sensor and the model that something may be missing from: who continues need not name them again.
SENSOR, START = "sensor.json", "start.json"


def investigate(
    sensor: AnyModel | None = None,
    folder: str | Path = "investigation",
    *,
    port: str | None = None,
    speed: float | None = None,
    resume: bool = False,
    bounds: Bounds | Mapping[str, float] | None = None,
    run_minutes: float = 3.0,
    budget_minutes: float | None = None,
    sure: float | None = None,
    specimen: Literal["aged", "fresh"] = "aged",
    motion: Literal["designed", "perlin"] = "designed",
    rest_s: float = 30.0,
    seed: int = 1,
    trials: int = 24,
    most: int = 2,
    max_force_N: float | None = None,
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
    bounds : Bounds or mapping, optional
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
    max_force_N : float, optional
        No motion is designed that any likely hypothesis expects more force of; a real recording stops there, and
        with `resume` its run is planned anew with less strain. Before the first run nothing is known of the force.
    gauge_length_mm : float
        Length of the unstretched sensor between the clamps.
    model : KnitModel, result or path, optional
        The model that something may be missing from; default: the baseline. It is kept: None with `resume`.
    effects : path, Catalogue or effect classes, optional
        The user's own effects; with `resume` the same again.
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
    folder, resume = path_of(folder, "folder"), flag("resume", resume)
    speed = None if speed is None else number("speed", speed)
    budget_minutes = None if budget_minutes is None else number("budget_minutes", budget_minutes)
    own_file = Path(effects) if isinstance(effects, str | Path) else None
    if resume:
        _check_as_begun(folder, sensor, model, own_file)
    catalogue, there = catalogue_of(effects), folder.exists()
    hidden = None if sensor is None else model_file_of(sensor, catalogue).model
    start = None if model is None else model_file_of(model, catalogue).model
    if resume:
        _check_own_effects(folder, catalogue)
        go_on(folder, budget_minutes, sure)
    elif (hidden is None) == (port is None):
        got = "neither" if port is None else "both"
        raise UserError(f"investigate: give a SENSOR to simulate, or the port of a real rig; got {got}")
    else:
        asked = {
            "bounds": _bounds_of_a_run(bounds, run_minutes),
            "budget_s": 60 * (30.0 if budget_minutes is None else budget_minutes),
            "sure": 0.95 if sure is None else sure,
            "specimen": specimen,
            "motion": motion,
            "rest_s": rest_s,
            "seed": seed,
            "trials": trials,
            "effects_at_most": whole("most: effects to find", most, 1),
            "max_force_N": max_force_N,
            "gauge_length_mm": gauge_length_mm,
            "effects_sha256": sha256_of(own_file) if own_file else None,
            "own_effects": _own_effects(catalogue),
        }
        keep = partial(_keep_beside, models={SENSOR: hidden, START: start}, effects=own_file)
        loop.begin(folder, Settings(**asked), str(port) if sensor is None else model_name(sensor), keep)
    told = partial(_told, folder, after_run)
    with _forgotten_unless_begun(folder, resume, there), telling(progress) as tell:
        state = load_investigation(folder)
        bench = _bench(folder, port, speed, state, catalogue, own_file)
        start = model_file_of(folder / START, catalogue).model if (folder / START).is_file() else None
        watcher = loop.Watcher(tell or (lambda _text: None), told, status or (lambda _status: None), stopped)
        return InvestigationResult(loop.proceed(folder, bench, catalogue, start, watcher), folder)


def _check_as_begun(folder: Path, sensor: AnyModel | None, model: AnyModel | None, own_file: Path | None) -> None:
    """Refuse what an investigation that goes on would not heed, before a file of effects, a program, is loaded."""
    for name, said in (("SENSOR", sensor), ("model", model)):
        if said is not None:
            raise UserError(f"investigate: {folder} goes on as it began, and knows its own; leave {name} out")
    refuse_links(folder.glob("*"), "copy the folder and use the copy")
    if sha256 := load_investigation(folder).settings.effects_sha256:
        named_effects(folder, folder / EFFECTS, own_file, sha256)


def _bounds_of_a_run(bounds: Bounds | Mapping[str, float] | None, run_minutes: float) -> dict[str, float]:
    """What was said of the bounds, and the duration, which is said by `run_minutes` alone."""
    said, run_s = bounds_said(bounds), 60 * number("run_minutes", run_minutes)
    check_duration("run_minutes", run_s)
    if said.get("duration_s", run_s) != run_s:
        raise UserError(
            f"bounds: a run takes {run_s:g} s (run_minutes), got a duration_s of {said['duration_s']!r}; say it by "
            "run_minutes"
        )
    return {**said, "duration_s": run_s}


def _own_effects(catalogue: Catalogue) -> list[str]:
    """Names of the effects that are the user's own."""
    return sorted(set(catalogue.effects) - set(load_catalogue().effects))


def _check_own_effects(folder: Path, catalogue: Catalogue) -> None:
    """Refuse to go on with other effects than it began with: its belief would be about other hypotheses."""
    begun, now = load_investigation(folder).settings.own_effects, _own_effects(catalogue)
    if begun is not None and begun != now:
        kept, got = (", ".join(names) or "none" for names in (begun, now))
        raise UserError(
            f"effects: {folder} goes on with the effects of your own that it began with ({kept}), got {got}; "
            "give the same, or begin a new investigation"
        )


def _keep_beside(folder: Path, models: Mapping[str, KnitModel | None], effects: Path | None) -> None:
    """Put into the folder what an investigation goes on with."""
    for name, model in models.items():
        if model is not None:
            write_json(folder / name, model.to_dict())
    if effects is not None:
        copy_file(effects, folder / EFFECTS)


@contextmanager
def _forgotten_unless_begun(folder: Path, resumed: bool, there: bool) -> Iterator[None]:
    """Take a new investigation away that bad words end before anything was recorded: the right ones may begin it.

    Only what was made goes: not a folder that was `there` before, nor what somebody else put into it.
    """
    try:
        yield
    except UserError:
        if not resumed and not run_folder(folder, 1).exists():
            with suppress(OSError):  # what stays is less bad than a fault that nobody hears of
                for name in (NAME, SENSOR, START, EFFECTS):
                    (folder / name).unlink(missing_ok=True)
                shutil.rmtree(program_folder(folder, 1), ignore_errors=True)
                if not there:
                    folder.rmdir()
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
        if (folder / SENSOR).is_file():
            raise UserError(
                f"{folder}: was made on the simulated rig, whose sensor is another; leave port out to go on"
            )
        if speed is not None:
            raise UserError("speed: is that of the simulated rig; leave it out where a port is given")
        limits = Limits(max_force_N=state.settings.max_force_N or float("inf"))
        return PortBench(stated_port(port), limits=limits, specimen=state.sensor)
    if not (folder / SENSOR).is_file():
        raise UserError(f"{folder}: was made on a real rig; give its port again to go on")
    model = model_file_of(folder / SENSOR, catalogue).model
    simulated = SimulatedBench(model, state.sensor, effects=effects_kept(model, own))
    if speed is None:
        return simulated
    if not 0 < speed <= 1000:
        raise UserError(f"speed: must be above 0 and at most 1000 times real time, got {speed:g}")
    return PtyBench(simulated, speed)
