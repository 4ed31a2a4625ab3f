"""The loop: plan, run, judge, until something is sure or the time is spent. Every step is kept before the next."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from time import time as now_s  # rests outlive the process that measures them
from typing import Any

from gcode.programs.make import Made, make
from gcode.support.errors import UserError
from gcode.support.files import make_folder
from testbench.design.best_motion import best_motion
from testbench.design.compositions import SURVEY, in_words, motion_of
from testbench.design.protocols import NOISE, menu
from testbench.investigating.alarms import after_alarm, set_aside
from testbench.investigating.belief import belief_after, doubted, over_specimens
from testbench.investigating.benches import Bench, Order, status_of
from testbench.investigating.state import (
    NAME,
    SPENT,
    SURE,
    Investigation,
    RunState,
    Settings,
    load_investigation,
    program_folder,
    run_folder,
    save_investigation,
)
from testbench.knit.catalogue import Catalogue
from testbench.knit.model import KnitModel
from testbench.measurements.joining import joined
from testbench.measurements.measurement import Measurement
from testbench.recordings.files import read_recording
from testbench.rig.acquisition.recorder import Status

RANDOM = "random motion (Perlin noise)"
Tell = Callable[[str], None]


@dataclass(frozen=True)
class Watcher:
    """Who is told what.

    Attributes
    ----------
    tell : callable
        A short text at each small step.
    judged : callable
        The investigation after each run.
    status : callable
        Of a recording that is under way.
    stopped : callable
        Whether to end early.
    """

    tell: Tell = lambda text: None
    judged: Callable[[Investigation], None] = lambda investigation: None
    status: Callable[[Status], None] = lambda status: None
    stopped: Callable[[], bool] = lambda: False


def begin(
    folder: Path, settings: Settings, sensor: str = "", keep: Callable[[Path], None] = lambda folder: None
) -> Investigation:
    """Make the folder of a new investigation.

    `keep` writes what lies beside its state, and before it: a kill leaves no investigation that lacks it.

    Raises
    ------
    UserError
        If something is there already.
    """
    if (folder / NAME).exists():
        raise UserError(
            f"{folder}: holds an investigation already; continue it with `resume`, or choose another folder"
        )
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise UserError(f"{folder}: exists and is not empty; choose another place")
    investigation = Investigation(sensor=sensor, settings=settings)
    keep(make_folder(folder))
    save_investigation(folder, investigation)
    return investigation


def proceed(
    folder: Path, bench: Bench, catalogue: Catalogue, start: KnitModel | None = None, watcher: Watcher | None = None
) -> Investigation:
    """Go on from wherever the investigation in `folder` is, to its end.

    Parameters
    ----------
    bench : Bench
        What it runs on.
    start : KnitModel, optional
        The model that something may be missing from; default: the baseline of the recording.
    """
    return _Loop(folder, bench, catalogue, start, watcher or Watcher()).run()


class _Loop:
    def __init__(
        self, folder: Path, bench: Bench, catalogue: Catalogue, start: KnitModel | None, watcher: Watcher
    ) -> None:
        self.folder, self.bench, self.catalogue, self.start, self.watcher = folder, bench, catalogue, start, watcher
        self.state = load_investigation(folder)

    def run(self) -> Investigation:
        while not self.state.ended and not self.watcher.stopped():
            runs = self.state.runs
            if not runs or runs[-1].belief is not None:
                if ending := self._ending():
                    self._keep(self.state.model_copy(update={"ended": ending}))
                    break
                self._plan()
            elif runs[-1].recorded:
                self._judge()
            elif status_of(run_folder(self.folder, len(runs))) == "alarm":
                self._plan_anew()
            else:
                self._record()
        return self.state

    def _keep(self, state: Investigation) -> None:
        self.state = state
        save_investigation(self.folder, state)

    def _keep_run(self, **changes: Any) -> None:
        """Keep what the last run has come to."""
        *before, run = self.state.runs
        self._keep(self.state.model_copy(update={"runs": [*before, run.model_copy(update=changes)]}))

    def _ending(self) -> str:
        settings, belief = self.state.settings, self.state.belief
        if belief is not None and belief.top[1] >= settings.sure:
            return SURE
        beyond = self.state.spent_s + settings.limits.duration_s > settings.budget_s * (1 + 1e-6)
        return SPENT if beyond else ""

    def _plan(self) -> None:
        """The next motion and its program: a bit of everything at first, then what separates what is still likely."""
        number, settings, belief = len(self.state.runs) + 1, self.state.settings, self.state.belief
        rivals = belief.rivals(self.catalogue, str(self.folder / NAME)) if belief else []
        # Where no law was worth a refit, one model alone foretells recordings: no motion separates it from others.
        expected, perlin = None, None
        if settings.motion == "perlin" or (belief and len(rivals) < 2):
            made, words = self._random(number), RANDOM
        elif belief is None:
            made, words = self._survey()
        else:
            self.watcher.tell(f"run {number}: designing the motion that tells most")
            found = best_motion(
                rivals,
                self._measured(),
                belief.reading,
                settings.limits,
                seed=settings.seed + number,
                rest_s=None if settings.specimen == "fresh" else settings.rest_s,
                trials=settings.trials,
                max_force_N=settings.max_force_N or float("inf"),
                progress=self.watcher.tell,
            )
            made, words, expected, perlin = found.made, found.words, found.expected.low, found.perlin.low
        made.write(program_folder(self.folder, number))
        run = RunState(words=words, seconds=made.trajectory.duration_s, expected_nats=expected, perlin_nats=perlin)
        self._keep(self.state.model_copy(update={"runs": [*self.state.runs, run]}))

    def _plan_anew(self) -> None:
        """Take back the plan whose recording an alarm ended: the next one keeps what the force has allowed.

        The state goes first: after a kill between the two the campaign is met, and set aside, once more.
        """
        run = run_folder(self.folder, len(self.state.runs))
        settings = after_alarm(run, self.state.settings)
        self._keep(self.state.model_copy(update={"settings": settings, "runs": self.state.runs[:-1]}))
        self.watcher.tell(f"{run.name}: an alarm ended it; kept as {set_aside(run).name}, planned anew")

    def _survey(self) -> tuple[Made, str]:
        """A motion for a sensor of which nothing is known yet, and it in words."""
        settings = self.state.settings
        found = motion_of(SURVEY, settings.limits, settings.seed)
        with contextlib.suppress(UserError):  # the controller's deviations may pass a limit that the plan keeps
            if found is not None:
                return make(found.spec, settings.seed, settings.gauge_length_mm), in_words(found.spec)
        return self._random(1), RANDOM

    def _random(self, number: int) -> Made:
        settings = self.state.settings
        spec = menu(settings.limits)[NOISE]
        return make(spec, settings.seed + number, settings.gauge_length_mm)

    def _record(self) -> None:
        number, settings = len(self.state.runs), self.state.settings
        earlier = range(1, number) if settings.specimen == "aged" else ()
        past = [program_folder(self.folder, k) / "program.tap" for k in earlier]
        self.watcher.tell(f"run {number}: program {program_folder(self.folder, number) / 'program.tap'}")
        # A run that was broken off goes on: the rest before it ended when it was first begun.
        begun_s = self.state.runs[-1].begun_s or now_s()
        self._keep_run(begun_s=begun_s)
        order = Order(
            program_folder(self.folder, number) / "program.tap",
            run_folder(self.folder, number),
            settings.gauge_length_mm,
            past,
            settings.rest_s,
            settings.seed + number,
        )
        self.bench.run(order, self.watcher.status, self.watcher.stopped)
        self._keep_run(recorded=True, rest_s=self._rest_before(number, begun_s), ended_s=now_s())

    def _rest_before(self, number: int, begun_s: float) -> float | None:
        """The rest before a run: as it was stated, or by the clock where time was real."""
        settings = self.state.settings
        if settings.specimen == "fresh" or number == 1:
            return None
        before_s = self.state.runs[number - 2].ended_s
        return max(begun_s - before_s, 1.0) if self.bench.keeps_time and before_s else settings.rest_s

    def _measured(self) -> Measurement:
        """All that the present specimen has shown; of fresh ones the last."""
        recorded = [k for k, run in enumerate(self.state.runs, 1) if run.recorded]
        if self.state.settings.specimen == "fresh":
            recorded = recorded[-1:]
        recordings = [read_recording(run_folder(self.folder, k)) for k in recorded]
        rests = [self.state.runs[k - 1].rest_s or self.state.settings.rest_s for k in recorded[1:]]
        return joined(recordings, rests)

    def _judge(self) -> None:
        number, settings = len(self.state.runs), self.state.settings
        fresh = settings.specimen == "fresh"
        self.watcher.tell(f"run {number}: diagnosing")
        runs = 1 if fresh else number
        tell = self.watcher.tell
        found = belief_after(self._measured(), runs, self.catalogue, self.start, settings.effects_at_most, tell)
        own = [run.belief.own for run in self.state.runs if run.belief is not None] + [found.own]
        together = doubted([over_specimens(own[: k + 1]) for k in range(len(own))] if fresh else own)
        self._keep_run(belief=found.told_as(together))
        self.watcher.judged(self.state)
