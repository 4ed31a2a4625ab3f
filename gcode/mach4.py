"""The Mach4 dialect, written. The reader is `gcode.reader`; nothing else knows the dialect.

Every block carries a G1, a position and a feed: Mach4 readers differ in what is modal, explicit words never hurt.
Positions have 4 decimals (3 distort the acceleration), feeds 2 (0 would give F0).
"""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from gcode.compensate import compensated_speeds, rounded_feeds
from gcode.header import header_lines
from gcode.reader import parse_program, read_program
from gcode.support.errors import UserError
from gcode.trajectory import POSITION_DECIMALS, Trajectory

__all__ = ["parse_program", "read_program", "write_program"]

FeedMode = Literal["G94", "G93"]
SAFE_START = "G0 G90 G54 G17 G40 G49 G80"
LEAST_DWELL_S = 0.25  # a shorter standstill is carried into the next move's time
LEAST_FEED = 0.01


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
        Uniformly sampled; positions are rounded to 4 decimals.
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
        The program; `gcode.reader.read_program` gives the trajectory back exactly.
    """
    rate_hz = trajectory.rate_hz
    length, steps, dwell = _moves(trajectory.position_mm, rate_hz)
    if not len(length):
        raise UserError("program: the trajectory never moves, there is nothing to write")
    speed = _speeds(length, steps / rate_hz, machine_acceleration_mm_per_s2, v_max_mm_per_s)
    about: dict[str, Any] = {"rate_hz": rate_hz}
    if machine_acceleration_mm_per_s2 is not None:
        about["machine_acceleration_mm_per_s2"] = machine_acceleration_mm_per_s2
    start = float(np.round(trajectory.position_mm[0], POSITION_DECIMALS))
    lines = [*header_lines({**about, **(header or {})}), SAFE_START, "G21", feed_mode, "G64"]
    if start:
        lines.append(f"G0 X{start:.{POSITION_DECIMALS}f}")
    lines += _body(start, length, steps, dwell, speed, feed_mode, rate_hz)
    return "\n".join([*lines, "M30", ""])


def _moves(position_mm: np.ndarray, rate_hz: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Blocks as (length in units of the last decimal, steps, is a dwell); no move has length zero."""
    ticks = np.rint(np.asarray(position_mm) * 10**POSITION_DECIMALS).astype(np.int64)
    moved = np.flatnonzero(np.diff(ticks))
    ends = np.concatenate((moved, [len(ticks) - 2])) if len(moved) else moved
    blocks: list[tuple[int, int, bool]] = []
    waited = np.diff(ends, prepend=-1) - 1
    least = LEAST_DWELL_S * rate_hz
    for index, wait in zip(moved.tolist(), waited.tolist(), strict=False):
        if wait >= least:
            blocks.append((0, wait, True))
            wait = 0
        blocks.append((int(ticks[index + 1] - ticks[index]), wait + 1, False))
    if len(moved) and moved[-1] < len(ticks) - 2:
        blocks.append((0, len(ticks) - 2 - int(moved[-1]), True))
    columns = np.array(blocks, dtype=np.int64).reshape(-1, 3)
    return columns[:, 0], columns[:, 1], columns[:, 2].astype(bool)


def _speeds(length: np.ndarray, duration_s: np.ndarray, acceleration: float | None, v_max: float) -> np.ndarray:
    length_mm = length / 10**POSITION_DECIMALS
    if acceleration is None:
        return np.minimum(np.abs(length_mm) / duration_s, v_max)
    return compensated_speeds(length_mm, duration_s, acceleration, v_max)


def _body(
    start: float,
    length: np.ndarray,
    steps: np.ndarray,
    dwell: np.ndarray,
    speed: np.ndarray,
    feed_mode: FeedMode,
    rate_hz: float,
) -> list[str]:
    position = start + np.cumsum(length) / 10**POSITION_DECIMALS + 0.0
    per_minute = 60.0 * speed
    if feed_mode == "G93":
        per_minute = per_minute / np.where(dwell, 1.0, np.abs(length) / 10**POSITION_DECIMALS)
    feeds = rounded_feeds(np.maximum(per_minute, LEAST_FEED), steps / rate_hz).tolist()
    lines = []
    for x, k, still, feed in zip(position.tolist(), steps.tolist(), dwell.tolist(), feeds, strict=True):
        if still:
            lines.append(f"G4 P{k / rate_hz:.4f}")
        else:
            note = "" if k == 1 else f" (STEPS {k})"
            lines.append(f"G1 X{x:.{POSITION_DECIMALS}f} F{feed:.2f}{note}")
    return lines
