"""Checks a program, ours or another's, before a machine sees it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from gcode.mach4.controller import MAX_PLAYED_S, Machine, execute
from gcode.mach4.program import Problem, Program
from gcode.motion.blocks import MOST_SAMPLES, Motion
from gcode.motion.statistics import MotionStatistics, motion_statistics
from gcode.support.errors import UserError
from gcode.support.html import card
from gcode.support.kinds import instance, number
from gcode.trajectories.bounds import Limits, excesses
from gcode.trajectories.trajectory import Trajectory, sampled

if TYPE_CHECKING:
    import pandas as pd

LONGEST_DWELL_S = 120.0  # in files that others made; a longer P is most likely milliseconds
TOLERANCE_MM = 1e-6
# Within these parts of a sample the speed may change by what the limit allows from one sample to the next, and by
# half of that again: our own programs need up to 1.24. No shaking keeps in step with both and with the samples.
PARTS_OF_A_SAMPLE, ALLOWED_WITHIN = (0.382, 0.618), 1.5
ACCELERATION_FACTOR = 5.0  # a controller faster than the limit shows whether the program itself asks for too much


@dataclass(frozen=True, repr=False)
class CheckResult:
    """What was found.

    Attributes
    ----------
    problems : tuple of Problem
        Where it is empty, the program may run.
    statistics : MotionStatistics or None
        Of the motion as executed, and the range of its turns; None where it was not executed.
    executed : Trajectory or None
        That motion, sampled at the rate of the check.
    """

    problems: tuple[Problem, ...]
    statistics: MotionStatistics | None
    executed: Trajectory | None = field(default=None, compare=False)

    @property
    def ok(self) -> bool:
        """Whether nothing was found."""
        return not self.problems

    def __repr__(self) -> str:
        return f"<CheckResult {'ok' if self.ok else f'{len(self.problems)} problem(s)'}>"

    def _repr_html_(self) -> str:
        executed = self.statistics.lines() if self.statistics else []
        return card(repr(self)[1:-1], [*map(str, self.problems), *executed])

    def to_frame(self) -> pd.DataFrame:
        """A row a problem: ``line``, ``reason``; none where the program may run."""
        import pandas as pd

        return pd.DataFrame([(one.line, one.reason) for one in self.problems], columns=["line", "reason"])

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready form: what was found, as ``gcode check --json`` prints it."""
        return {
            "ok": self.ok,
            "problems": [{"line": problem.line, "reason": problem.reason} for problem in self.problems],
            "statistics": self.statistics.model_dump() if self.statistics else None,
        }


def check_program(
    program: Program,
    limits: Limits,
    rate_hz: float = 20.0,
    machine: Machine | None = None,
    *,
    rapid_mm_per_s: float | None = None,
    longest_dwell_s: float | None = None,
) -> CheckResult:
    """Check a program against limits; its parameters are those of `gcode.check`.

    Positions, feeds and dwells are checked as programmed. Speed, acceleration and jerk are checked as executed: the
    program is played and differentiated at `rate_hz`. What the file says of its controller counts for nothing.

    Raises
    ------
    UserError
        If `rate_hz` is not from 1 to 10,000, or `longest_dwell_s` not above zero.
    """
    if not 1 <= number("rate_hz", rate_hz) <= 10_000:
        # Below, the differences would be taken over whole strokes, and show nothing of them.
        raise UserError(f"rate_hz must be from 1 to 10000, got {rate_hz:g}")
    longest_dwell_s = LONGEST_DWELL_S if longest_dwell_s is None else longest_dwell_s
    if not number("longest_dwell_s", longest_dwell_s) > 0:
        raise UserError(f"the longest dwell must be a number of seconds above 0, got {longest_dwell_s:g}")
    problems = [
        *program.problems,
        *_modes(program),
        *_positions(program, limits),
        *_feeds(program, limits, rapid_mm_per_s),
        *_dwells(program, longest_dwell_s),
    ]
    executed = None
    if unplayed := _unplayed(program, rate_hz):
        problems.append(Problem(1, unplayed))
    else:
        motion = execute(program, _machine(machine, limits, rapid_mm_per_s))
        found, executed = _executed(program, motion, rate_hz, limits)
        hint = "" if machine else _other_controller(program, limits)
        problems += [Problem(one.line, one.reason + hint) for one in found]
    statistics = None
    if executed:
        turns_mm = np.append(program.position_mm, program.start_mm)  # the axis turns at the ends of blocks only
        range_mm = {"x_min_mm": float(turns_mm.min()), "x_max_mm": float(turns_mm.max())}
        statistics = motion_statistics(executed.position_mm, rate_hz).model_copy(update=range_mm)
    return CheckResult(tuple(sorted(problems, key=lambda problem: problem.line)), statistics, executed)


def _modes(program: Program) -> list[Problem]:
    """What the file leaves to the controller's last job."""
    if not len(program.line):
        return []
    line = int(program.line[0])
    return [
        Problem(line, f"moves before {mode} is said: it would mean whatever the machine did last")
        for mode in program.unsaid
    ]


def _other_controller(program: Program, limits: Limits) -> str:
    """A hint where the file was written for a controller of another acceleration than it is judged with."""
    stated = program.header_number("machine_acceleration_mm_per_s2")
    used = ACCELERATION_FACTOR * limits.a_max_mm_per_s2
    if not stated or abs(stated - used) < 1e-9 * used:
        return ""
    return (
        f" (judged with a controller of {used:g} mm/s2; the file was written for {stated:g}: if yours is set so, "
        "give its `acceleration_mm_per_s2`)"
    )


def _machine(machine: Machine | None, limits: Limits, rapid_mm_per_s: float | None) -> Machine:
    """The controller to judge with: the given one or that of `ACCELERATION_FACTOR`, at the stated rapid speed."""
    usual = Machine(acceleration_mm_per_s2=ACCELERATION_FACTOR * limits.a_max_mm_per_s2)
    machine = usual if machine is None else instance("machine", machine, Machine)
    if rapid_mm_per_s is None:
        return machine
    return Machine(**{**machine.model_dump(), "rapid_mm_per_s": rapid_mm_per_s})


def _unplayed(program: Program, rate_hz: float) -> str:
    """Why the program cannot be executed here; empty if it can."""
    moving = program.length_mm != 0
    if not moving.any():
        return "the program moves nothing"
    feed = np.minimum(program.feed_mm_per_s[moving], 1e3)
    if not (feed > 0).all():
        return "not executed, since it has moves of no feed: nothing is known of its motion"
    seconds = float(np.abs(program.length_mm[moving] / feed).sum() + program.dwell_s.sum())
    if seconds > MAX_PLAYED_S:
        return f"not executed, since it would take {_long(seconds)}: more than {_long(MAX_PLAYED_S)} is refused"
    if seconds * rate_hz > MOST_SAMPLES:
        return f"not executed, since {_long(seconds)} at {rate_hz:g} Hz are too many samples; lower `rate_hz`"
    return ""


def _long(seconds: float) -> str:
    for unit, length in (("years", 365.25 * 86400.0), ("days", 86400.0)):
        if seconds >= 2 * length:
            return f"{seconds / length:.3g} {unit}"
    return f"{seconds:.4g} s"


def _first(mask: np.ndarray, program: Program, reason: Callable[[int], str]) -> list[Problem]:
    """One problem for the first line of a kind, saying how many more there are."""
    hits = np.flatnonzero(mask)
    if not len(hits):
        return []
    more = f" (and {len(hits) - 1} more lines)" if len(hits) > 1 else ""
    return [Problem(int(program.line[hits[0]]), reason(int(hits[0])) + more)]


def _positions(program: Program, limits: Limits) -> list[Problem]:
    x = program.position_mm
    outside = (x < limits.x_min_mm - TOLERANCE_MM) | (x > limits.x_max_mm + TOLERANCE_MM)
    between = f"{limits.x_min_mm:g} to {limits.x_max_mm:g} mm"
    return _first(outside, program, lambda i: f"X{x[i]:.4f} leaves the soft limits {between}")


def _feeds(program: Program, limits: Limits, rapid_mm_per_s: float | None) -> list[Problem]:
    moving = program.length_mm != 0
    feed, limit = program.feed_mm_per_s, limits.v_max_mm_per_s
    rapid = np.isinf(feed) & moving
    fast = np.isfinite(feed) & moving & (feed > limit * 1.001)
    found = _first(fast, program, lambda i: f"feed {feed[i]:.4g} mm/s is above v max {limit:g} mm/s")
    if rapid_mm_per_s is None:
        found += _first(rapid, program, lambda i: "a G0 move has no known speed; use G1, or state `rapid_mm_per_s`")
    elif number("rapid_mm_per_s", rapid_mm_per_s) > limit:
        text = f"a G0 move at {rapid_mm_per_s:g} mm/s is above v max {limit:g} mm/s"
        found += _first(rapid, program, lambda i: text)
    return found


def _dwells(program: Program, longest_s: float) -> list[Problem]:
    dwell = program.dwell_s
    text = f"longer than {longest_s:g} s; P is in seconds, is this milliseconds? (see `longest_dwell_s`)"
    return _first(dwell > longest_s, program, lambda i: f"G4 P{dwell[i]:g} dwells {text}")


def _executed(
    program: Program, motion: Motion, rate_hz: float, limits: Limits
) -> tuple[list[Problem], Trajectory | None]:
    """What the executed motion passes, and the motion; positions are left to the programmed check."""
    # A controller of next to no acceleration takes as long as it likes, whatever the feeds are.
    if not motion.end_s * rate_hz <= MOST_SAMPLES:
        took = f"not executed, since this controller would take {_long(motion.end_s)}: more than can be looked at"
        return [Problem(1, took)], None
    position_mm = motion.positions(rate_hz)
    problems = []
    for excess in excesses(position_mm, rate_hz, limits):
        if excess.name == "position":
            continue
        line = _line_at(program, motion, (excess.sample + 1) / rate_hz)
        problems.append(Problem(line, f"executed {excess.at(rate_hz)}"))
    if not problems:
        problems = _between_samples(program, motion, rate_hz, limits)
    return problems, sampled(position_mm, rate_hz)


def _between_samples(program: Program, motion: Motion, rate_hz: float, limits: Limits) -> list[Problem]:
    """What samples at `rate_hz` do not show: an axis that shakes in step with them seems to stand still."""
    allowed = ALLOWED_WITHIN * limits.a_max_mm_per_s2 / rate_hz
    found = []
    for within_s in (part / rate_hz for part in PARTS_OF_A_SAMPLE):
        change, when_s = motion.largest_change(within_s)
        found.append((change, within_s, when_s))
    most, within_s, when_s = max(found)
    if most <= allowed:
        return []
    return [
        Problem(
            _line_at(program, motion, when_s),
            f"executed speed changes by {most:.4g} mm/s within {within_s:.3g} s at {when_s:.2f} s, between samples "
            f"at {rate_hz:g} Hz: {limits.a_max_mm_per_s2:g} mm/s2 allow {allowed:.3g} mm/s there",
        )
    ]


def _line_at(program: Program, motion: Motion, time_s: float) -> int:
    """The line that is executed at a time."""
    return int(program.line[min(int(np.searchsorted(motion.block_end_s, time_s)), len(program.line) - 1)])
