"""The Mach4 dialect, written. The reader is `gcode.mach4.reader`; nothing else knows the dialect.

Every block carries a G1, a position and a feed: readers differ in what is modal, explicit words never hurt.
Positions have at least 4 decimals (3 distort the acceleration), feeds at least 2 (0 would give F0).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from gcode.mach4.feeds import compensated_speeds, rounded_feeds
from gcode.mach4.header import header_lines, sealed
from gcode.support.errors import UserError
from gcode.trajectories.trajectory import Trajectory, position_decimals

FeedMode = Literal["G94", "G93"]
SAFE_START = "G0 G90 G54 G17 G40 G49 G80"
LEAST_DWELL_S = 0.25  # the axis creeps where it takes less than this for one tick


@dataclass(frozen=True)
class _Moves:
    """Blocks of a program: lengths in ticks of the last decimal, samples each stands for, whether it is a dwell."""

    ticks: np.ndarray
    steps: np.ndarray
    dwell: np.ndarray
    start_ticks: int
    decimals: int
    rate_hz: float

    @property
    def length_mm(self) -> np.ndarray:
        return self.ticks / 10**self.decimals

    @property
    def duration_s(self) -> np.ndarray:
        return self.steps / self.rate_hz

    @property
    def position_mm(self) -> np.ndarray:
        return (self.start_ticks + np.cumsum(self.ticks)) / 10**self.decimals


def write_program(
    trajectory: Trajectory,
    *,
    header: dict[str, Any] | None = None,
    feed_mode: FeedMode = "G94",
    machine_acceleration_mm_per_s2: float | None = None,
    v_max_mm_per_s: float = np.inf,
) -> str:
    """Write a trajectory as a Mach4 program.

    Parameters
    ----------
    trajectory : Trajectory
        Uniformly sampled; positions are rounded to 4 decimals (more above 50 Hz).
    header : dict or None
        What the header comments shall say, ``{"name": "paper-1", "seed": 51}``; nested values are flattened.
    feed_mode : {'G94', 'G93'}
        Feed per minute, or inverse time (one over minutes).
    machine_acceleration_mm_per_s2 : float or None
        The controller's acceleration; feeds are pre-compensated for it. None writes the nominal feeds.
    v_max_mm_per_s : float
        No programmed feed is above this.

    Returns
    -------
    str
        The program; `gcode.mach4.reader.read_program` gives the trajectory back exactly.

    Raises
    ------
    UserError
        If the trajectory never moves, or a header value cannot be a comment.
    """
    moves = _moves(trajectory)
    speed = np.minimum(np.abs(moves.length_mm) / moves.duration_s, v_max_mm_per_s)
    about: dict[str, Any] = {"rate_hz": moves.rate_hz}
    if machine_acceleration_mm_per_s2 is not None:
        about["machine_acceleration_mm_per_s2"] = machine_acceleration_mm_per_s2
        speed = compensated_speeds(moves.length_mm, moves.duration_s, machine_acceleration_mm_per_s2, v_max_mm_per_s)
    lines = [*header_lines({**about, **(header or {})}), SAFE_START, "G21", feed_mode, "G64"]
    if moves.start_ticks:
        lines.append(f"G0 X{moves.start_ticks / 10**moves.decimals:.{moves.decimals}f}")
    # A controller may keep G93 after the end, and the next program's F500 would be 500 moves a minute.
    end = ["G94"] if feed_mode == "G93" else []
    return sealed("\n".join([*lines, *_body(moves, speed, v_max_mm_per_s, feed_mode), *end, "M30", ""]))


def _moves(trajectory: Trajectory) -> _Moves:
    """Blocks without moves of length zero: where the axis stands there is a dwell; where it creeps, a tick in several
    samples, their time is carried into the move of that tick.
    """
    rate_hz = round(trajectory.rate_hz, 6)
    decimals = position_decimals(rate_hz)
    ticks = np.rint(np.asarray(trajectory.position_mm) * 10**decimals).astype(np.int64)
    delta = np.diff(ticks)
    moved = np.flatnonzero(delta)
    if not len(moved):
        raise UserError("program: the trajectory never moves, there is nothing to write")
    waited = np.diff(moved, prepend=-1) - 1
    stands = (waited > 0) & ((np.abs(delta[moved]) > 1) | (waited >= LEAST_DWELL_S * rate_hz))
    # Each move is one block, with a dwell block before it where the axis stood still long enough.
    rows = np.arange(len(moved)) + np.cumsum(stands)
    tail = len(delta) - 1 - int(moved[-1])
    size = len(moved) + int(stands.sum()) + (tail > 0)
    length, steps, dwell = np.zeros(size, np.int64), np.zeros(size, np.int64), np.ones(size, bool)
    length[rows], dwell[rows] = delta[moved], False
    steps[rows] = np.where(stands, 1, waited + 1)
    steps[rows[stands] - 1] = waited[stands]
    if tail:
        steps[-1] = tail
    return _Moves(length, steps, dwell, int(ticks[0]), decimals, rate_hz)


def _body(moves: _Moves, speed: np.ndarray, v_max: float, feed_mode: FeedMode) -> list[str]:
    unit = np.full(len(speed), 60.0)
    if feed_mode == "G93":
        unit = unit / np.where(moves.dwell, 1.0, np.abs(moves.length_mm))
    per_minute = np.where(moves.dwell, 1.0, speed * unit)
    slow = per_minute[~moves.dwell].min() < 1.0
    x_format, f_format = f".{moves.decimals}f", ".4f" if slow else ".2f"
    feeds = rounded_feeds(per_minute, moves.duration_s, v_max * unit, 4 if slow else 2)
    columns = zip(moves.position_mm.tolist(), moves.steps.tolist(), moves.dwell.tolist(), feeds.tolist(), strict=True)
    lines = []
    for x, steps, still, feed in columns:
        if still:
            lines.append(f"G4 P{steps / moves.rate_hz:.4f}")
        else:
            note = "" if steps == 1 else f" (STEPS {steps})"
            lines.append(f"G1 X{x + 0.0:{x_format}} F{feed:{f_format}}{note}")
    return lines
