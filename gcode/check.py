"""Checks a program, ours or another's, before a machine sees it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from gcode.motion import Motion
from gcode.planner import Machine, execute
from gcode.program import Problem, Program
from gcode.statistics import MotionStatistics, accelerations, motion_statistics, speeds
from gcode.trajectory import Limits

LONGEST_DWELL_S = 3600.0
TOLERANCE = 1e-6
ACCELERATION_FACTOR = 5.0  # a controller faster than the limit shows whether the program itself asks for too much


@dataclass(frozen=True)
class CheckResult:
    """What was found: problems (none: the program may run) and the statistics of the executed motion."""

    problems: list[Problem]
    statistics: MotionStatistics | None

    @property
    def ok(self) -> bool:
        """Whether nothing was found."""
        return not self.problems

    def as_json(self) -> dict[str, Any]:
        """For ``gcode check --json``."""
        return {
            "ok": self.ok,
            "problems": [{"line": problem.line, "reason": problem.reason} for problem in self.problems],
            "statistics": self.statistics.model_dump() if self.statistics else None,
        }


def check_program(
    program: Program, limits: Limits, rate_hz: float = 20.0, machine: Machine | None = None
) -> CheckResult:
    """Check a program against limits.

    Positions and feeds are checked as programmed. Speed and acceleration are checked as executed: the program is
    played by a controller whose acceleration is five times the limit (or by `machine`) and differentiated at
    `rate_hz`.
    """
    problems = [*program.problems, *_positions(program, limits), *_feeds(program, limits), *_dwells(program)]
    statistics = None
    if _playable(program):
        machine = machine or Machine(acceleration_mm_per_s2=ACCELERATION_FACTOR * limits.a_max_mm_per_s2)
        motion = execute(program, machine)
        samples = max(int(np.ceil(motion.end_s * rate_hz - 1e-6)) + 1, 2)
        position = motion.position_at(np.arange(samples) / rate_hz)
        statistics = motion_statistics(position, rate_hz)
        problems += _executed(program, motion, position, rate_hz, limits)
    return CheckResult(sorted(problems, key=lambda problem: problem.line), statistics)


def _playable(program: Program) -> bool:
    moving = program.length_mm != 0
    return bool(len(program.line)) and bool((program.feed_mm_per_s[moving] > 0).all())


def _first(mask: np.ndarray, program: Program, reason: Any) -> list[Problem]:
    """One problem for the first line of a kind, saying how many more there are."""
    hits = np.flatnonzero(mask)
    if not len(hits):
        return []
    more = f" (and {len(hits) - 1} more lines)" if len(hits) > 1 else ""
    return [Problem(int(program.line[hits[0]]), reason(int(hits[0])) + more)]


def _positions(program: Program, limits: Limits) -> list[Problem]:
    x = program.position_mm
    outside = (x < limits.x_min_mm - TOLERANCE) | (x > limits.x_max_mm + TOLERANCE)
    return _first(
        outside,
        program,
        lambda i: f"X{x[i]:.4f} leaves the soft limits {limits.x_min_mm:g} to {limits.x_max_mm:g} mm",
    )


def _feeds(program: Program, limits: Limits) -> list[Problem]:
    feed = program.feed_mm_per_s
    with np.errstate(invalid="ignore"):
        fast = np.isfinite(feed) & (feed > limits.v_max_mm_per_s * 1.001 + 0.001)
    rapid = np.isinf(feed) & (program.length_mm != 0)
    limit = limits.v_max_mm_per_s
    return [
        *_first(fast, program, lambda i: f"feed {feed[i]:.3f} mm/s is above v max {limit:g} mm/s"),
        *_first(rapid, program, lambda i: "G0 moves at the rapid speed, not within v max; use G1"),
    ]


def _dwells(program: Program) -> list[Problem]:
    return _first(
        program.dwell_s > LONGEST_DWELL_S,
        program,
        lambda i: (
            f"G4 P{program.dwell_s[i]:g} would dwell {program.dwell_s[i] / 3600:.1f} h; P is in seconds, not ms"
        ),
    )


def _executed(
    program: Program, motion: Motion, position_mm: np.ndarray, rate_hz: float, limits: Limits
) -> list[Problem]:
    problems = []
    for name, unit, values, limit in (
        ("speed", "mm/s", np.abs(speeds(position_mm, rate_hz)), limits.v_max_mm_per_s),
        ("acceleration", "mm/s2", np.abs(accelerations(position_mm, rate_hz)), limits.a_max_mm_per_s2),
    ):
        if values.size and values.max() > limit * (1 + 1e-6) + TOLERANCE:
            at = int(values.argmax())
            block = min(int(np.searchsorted(motion.block_end_s, (at + 1) / rate_hz)), len(program.line) - 1)
            reason = f"executed {name} {values[at]:.3f} {unit} at {at / rate_hz:.2f} s is above {limit:g} {unit}"
            problems.append(Problem(int(program.line[block]), reason))
    return problems
