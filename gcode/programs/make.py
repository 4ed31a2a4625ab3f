"""make(): the whole way from a spec to a checked program, and the three files it is written to."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gcode.mach4.check import check_program
from gcode.mach4.controller import Machine
from gcode.mach4.header import unflatten
from gcode.mach4.program import Problem, Program
from gcode.mach4.reader import read_program
from gcode.mach4.writer import FeedMode, write_program
from gcode.motion.statistics import MotionStatistics
from gcode.support import files
from gcode.support.console import knitbench_version
from gcode.support.errors import UserError
from gcode.support.html import card
from gcode.support.strict import ExtraIgnored, load, validated
from gcode.trajectories.natural import NAMES, Noise
from gcode.trajectories.planning import check_request, plan, slowest_stroke, whole_path
from gcode.trajectories.trajectory import AMPLE, Trajectory, TrajectorySpec

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

MISSED = 0.05  # relative deviation from a target that is worth a note
LITTLE_USED = 0.85
FAR_OFF_MM = 0.05  # of an executed motion from its plan
FEW_CELLS = 100  # of a noise: so few do not have its statistics
MOST_BYTES = 16 << 20  # of a plan that was written
_RESERVES = (1.0, 0.85, 0.7, 0.5)  # tried in turn when the controller's deviations pass a limit


@dataclass(frozen=True, repr=False)
class Made:
    """A planned trajectory and its checked program.

    Attributes
    ----------
    spec : TrajectorySpec
    seed : int
    gauge_length_mm : float
    feed_mode : {"G94", "G93"}
    trajectory : Trajectory
        As planned.
    program : str
        The text.
    executed : Trajectory
        What the controller that the spec names makes of the program.
    statistics : MotionStatistics
        Of that.
    """

    spec: TrajectorySpec
    seed: int
    gauge_length_mm: float
    feed_mode: FeedMode
    trajectory: Trajectory = field(compare=False)
    program: str
    executed: Trajectory = field(compare=False)
    statistics: MotionStatistics

    def __repr__(self) -> str:
        found = self.statistics
        low, high = (round(end, 6) + 0.0 for end in (found.x_min_mm, found.x_max_mm))
        return f"<Made {self.spec.name}, seed {self.seed}: {found.duration_s:.1f} s, {low:.3g} to {high:.3g} mm>"

    def _repr_html_(self) -> str:
        title = f"{self.spec.name}, seed {self.seed}, gauge length {self.gauge_length_mm:g} mm, as executed"
        return card(title, [*self.statistics.lines(), *self.notes()], self.trajectory.curve())

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the planned position over time on `axes` (default: of a new figure); returns them."""
        return self.trajectory.plot(axes)

    def to_frame(self) -> pd.DataFrame:
        """The planned trajectory as a table: ``time_s``, ``position_mm``."""
        return self.trajectory.to_frame()

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready form: the recipe and the statistics of the motion as executed."""
        return {**self.recipe(), "statistics": self.statistics.model_dump()}

    def notes(self) -> list[str]:
        """What a user should know: a target that is missed, a strain range that is hardly used."""
        notes = []
        for piece in self.spec.pieces:
            if not isinstance(piece, Noise) or piece.target is None:
                continue
            is_short = piece.duration_s * piece.cells_per_s < FEW_CELLS
            if len(self.spec.pieces) == 1:
                off = zip(NAMES, piece.target.deviations(self.statistics).tolist(), strict=True)
                missed = ", ".join(f"{name} {value:+.0%}" for name, value in off if abs(value) > MISSED)
                limit = "" if self.spec.limits.j_max_mm_per_s3 is None else " within this jerk limit"
                where = "in so short a motion" if is_short else f"at this gauge length and range{limit}"
                notes += [f"the target is missed {where}: {missed}"] if missed else []
            reached = (self.statistics.x_max_mm - self.spec.offset_mm) / self.gauge_length_mm * 100.0
            if not is_short and reached < LITTLE_USED * piece.high_percent:
                notes.append(
                    f"strain reaches {reached:.0f} % of {piece.high_percent:g} %: such speeds and accelerations need "
                    "a smaller stroke; gcode fit finds others for this gauge length"
                )
        return notes + self._slowed() + self._off_the_plan()

    def _slowed(self) -> list[str]:
        """Where the limits do not let a designed piece, or the way to it, be as fast or go as far as asked."""
        designed = tuple(piece for piece in self.spec.pieces if not isinstance(piece, Noise))
        if not designed:
            return []
        spec, limits, told = self.spec.model_copy(update={"pieces": designed}), self.spec.limits, []
        asked, reached = slowest_stroke(spec, self.gauge_length_mm)
        if reached < (1.0 - MISSED) * asked:
            told.append(
                f"{asked:.3g} mm/s are asked for where limits and rate_hz let the axis reach {reached:.3g} mm/s"
            )
        path = whole_path(spec, self.seed, self.gauge_length_mm, limits.v_max_mm_per_s, limits.a_max_mm_per_s2)
        asked_mm, reached_mm = (float(np.ptp(one.position_mm)) for one in (path, self.trajectory))
        if asked_mm - reached_mm > FAR_OFF_MM:
            # A turn between two samples is not in the program.
            smooth = limits.j_max_mm_per_s3 is not None
            why = "the jerk limit leaves" if smooth else f"samples at {spec.rate_hz:g} Hz leave"
            told.append(f"{asked_mm:.4g} mm are asked for, of which {why} {reached_mm:.4g} mm")
        return told

    def _off_the_plan(self) -> list[str]:
        """What a controller of little acceleration makes of the plan, where that is something else."""
        acceleration = self.spec.controller_acceleration_mm_per_s2
        if acceleration >= AMPLE * self.spec.limits.a_max_mm_per_s2:
            return []
        done_mm, planned_mm = self.executed.position_mm, self.trajectory.position_mm
        count = min(len(done_mm), len(planned_mm))
        off_mm = float(np.abs(done_mm[:count] - planned_mm[:count]).max())
        if off_mm <= FAR_OFF_MM:
            return []
        remedy = "set a higher one in the machine, or plan a slower motion"
        return [f"a controller of {acceleration:g} mm/s2 is up to {off_mm:.2f} mm off this plan: {remedy}"]

    def recipe(self) -> dict[str, Any]:
        """What `make` was called with, and the version that did it."""
        return {
            "version": knitbench_version(),
            "seed": self.seed,
            "gauge_length_mm": self.gauge_length_mm,
            "feed_mode": self.feed_mode,
            "spec": self.spec.model_dump(mode="json", exclude_none=True),
        }

    def write(self, folder: str | Path) -> list[Path]:
        """Write trajectory.csv, program.tap and trajectory.json into `folder`."""
        paths = places(folder)
        files.make_folder(folder)
        self.trajectory.write_csv(paths[0])
        files.write_text(paths[1], self.program)
        files.write_json(paths[2], self.to_dict())
        return paths


def places(folder: str | Path) -> list[Path]:
    """Where `Made.write` puts its files; asked before the work whose result would be lost there.

    Raises
    ------
    UserError
        If they cannot be written there.
    """
    folder = files.check_folder(folder)
    paths = [folder / name for name in ("trajectory.csv", "program.tap", "trajectory.json")]
    for path in paths if folder.exists() else ():
        files.check_place(path)
    return paths


def make(spec: TrajectorySpec, seed: int, gauge_length_mm: float, feed_mode: FeedMode = "G94") -> Made:
    """Plan, write and check a program.

    Raises
    ------
    UserError
        If the request cannot be planned, or the program does not pass its own check.
    """
    check_request(spec, seed, gauge_length_mm)
    seed, gauge_length_mm = int(seed), float(gauge_length_mm)  # as a header of ours is read again
    for reserve in _RESERVES:
        made, problems = _attempt(spec, seed, gauge_length_mm, feed_mode, reserve)
        if not problems:
            return made
    raise UserError(
        f"limits: the program did not pass its own check, nothing was written: {problems[0].reason}; raise that "
        "limit, lower the spec's rate_hz, or ask for a slower motion"
    )


def _attempt(
    spec: TrajectorySpec, seed: int, gauge_length_mm: float, feed_mode: FeedMode, reserve: float
) -> tuple[Made, tuple[Problem, ...]]:
    """Plan and write once; what the check of the program finds."""
    trajectory = plan(spec, seed, gauge_length_mm, reserve=reserve)
    planned = trajectory.statistics()
    acceleration = spec.controller_acceleration_mm_per_s2
    draft = Made(spec, seed, gauge_length_mm, feed_mode, trajectory, "", trajectory, planned)
    text = write_program(
        trajectory,
        header={"program": spec.name, **draft.recipe(), "statistics": _rounded(planned)},
        feed_mode=feed_mode,
        machine_acceleration_mm_per_s2=acceleration,
        v_max_mm_per_s=spec.limits.v_max_mm_per_s,
    )
    machine = Machine(acceleration_mm_per_s2=acceleration)
    result = check_program(read_program(text), spec.limits, spec.rate_hz, machine, longest_dwell_s=np.inf)
    done, statistics = result.executed or trajectory, result.statistics or planned
    return replace(draft, program=text, executed=done, statistics=statistics), result.problems


def make_again(program: Program) -> Made:
    """Make one of our own programs again from its header comments.

    Raises
    ------
    UserError
        If the header does not hold a spec, a seed and a gauge length.
    """
    spec = unflatten(program.header, "spec")
    seed, gauge = program.header_number("seed"), program.header_number("gauge_length_mm")
    if not spec or seed is None or gauge is None:
        raise UserError(
            "program: its header holds no spec, seed and gauge length; only our own files can be made again"
        )
    mode: FeedMode = "G93" if program.header.get("feed_mode") == "g93" else "G94"
    if seed != int(seed):
        raise UserError(f"program: its header's seed must be a whole number, got {seed:g}")
    return make(validated(spec, TrajectorySpec, "program", "recipe in its header"), int(seed), gauge, mode)


def _rounded(statistics: MotionStatistics) -> dict[str, float]:
    return {key: round(value, 4) for key, value in statistics.model_dump().items()}


class StoredPlan(ExtraIgnored):
    """``trajectory.json``, as far as other rooms read it."""

    spec: TrajectorySpec
    statistics: MotionStatistics


def read_plan(path: str | Path) -> StoredPlan:
    """What `gcode generate` wrote beside the program.

    Raises
    ------
    UserError
        If it is missing or is something else.
    """
    return load(path, StoredPlan, "plan", MOST_BYTES)
