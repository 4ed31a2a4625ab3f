"""Feed pre-compensation: choose feeds so that the controller, not only the program, keeps the planned time."""

from __future__ import annotations

import numpy as np

from gcode.motion.blocks import Blocks, block_ends

ITERATIONS = 40  # each plays the whole program; the best one seen is taken
_GAIN = 0.5  # part of a block's accumulated lateness that it tries to make up for

_SETTLE = 12  # iterations that look at each block alone, before lateness is carried over


def compensated_speeds(
    length_mm: np.ndarray, duration_s: np.ndarray, acceleration_mm_per_s2: float, v_max_mm_per_s: float = np.inf
) -> np.ndarray:
    """Speeds (mm/s) with which a trapezoidal planner ends each block when it was planned to end.

    Parameters
    ----------
    length_mm : array (n,)
        Signed lengths; zero is a dwell.
    duration_s : array (n,)
        Planned time of each block.
    acceleration_mm_per_s2 : float
        The controller's acceleration.
    v_max_mm_per_s : float
        No speed above this is chosen.
    """
    distance, moving = np.abs(length_mm), length_mm != 0
    nominal = np.where(moving, distance / duration_s, 0.0)
    highest = np.minimum(4 * nominal + 0.5, v_max_mm_per_s)
    planned_end, dwell = np.cumsum(duration_s), np.where(moving, 0.0, duration_s)
    speed, best, least = nominal, nominal, np.inf
    for turn in range(ITERATIONS):
        ends = block_ends(Blocks(length_mm, speed, dwell), acceleration_mm_per_s2)
        late = ends - planned_end
        worst = float(np.abs(late).max())
        if worst < least:
            best, least = speed, worst
        if worst < 1e-4:
            break
        took = np.diff(ends, prepend=0.0)
        before = np.concatenate(([0.0], late[:-1]))
        make_up = _GAIN * before if turn >= _SETTLE else np.zeros_like(before)
        aim = np.clip(duration_s - make_up, 0.5 * duration_s, 1.5 * duration_s)
        factor = np.clip(took / aim, 0.8, 1.25)
        speed = np.where(moving, np.clip(speed * factor, 0.5 * nominal, highest), 0.0)
    return best


def rounded_feeds(feed: np.ndarray, duration_s: np.ndarray, highest: np.ndarray, decimals: int = 2) -> np.ndarray:
    """Round feeds, each so that the time its rounding costs or saves is paid back by the next ones.

    Plain rounding is biased here: positions are whole ticks, so nominal feeds are whole too, and the small
    additions of the compensation would all be lost.

    Parameters
    ----------
    feed : array (n,)
        Feeds, all above zero.
    duration_s : array (n,)
        Time of each block.
    highest : array (n,)
        No feed is rounded above these.
    decimals : int
        Decimals of the file.
    """
    quantum, owed = 10.0**-decimals, 0.0
    whole: list[int] = []
    most = np.floor(np.minimum(highest / quantum, 1e15) * (1 + 1e-12)).tolist()
    for wanted, seconds, limit in zip((feed / quantum).tolist(), duration_s.tolist(), most, strict=True):
        ticks = max(min(round(wanted * (1.0 + owed / seconds)), int(limit)), 1)
        owed += seconds * (wanted / ticks - 1.0)
        whole.append(ticks)
    return np.array(whole, dtype=float) * quantum
