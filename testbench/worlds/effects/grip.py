"""Hidden effects on the strain that the knit really sees: set, slip and lost motion."""

from __future__ import annotations

import numpy as np

from testbench.worlds.base import soft_positive
from testbench.worlds.chain import Scene, Shape
from testbench.worlds.effects.registry import form
from testbench.worlds.kernels import last_turning_point, lowpass, ratchet_slips, stop


def _lengthened(s: Scene, extra: np.ndarray) -> None:
    """The knit has become longer by `extra` (relative): it sees less strain, and none while it is slack."""
    s.e = (s.e - extra) / (1 + extra)


@form("permanent_set", "of_largest_strain", "kinematics", 0.5, onset=(0.0, 0.08))
def set_of_maximum(s: Scene, a: float, p: Shape) -> None:
    _lengthened(s, a * soft_positive(np.maximum.accumulate(s.e) - p["onset"], 0.005))


@form("permanent_set", "creeps", "kinematics", 0.8, tau=(150, 900))
def set_creeps(s: Scene, a: float, p: Shape) -> None:
    _lengthened(s, a * lowpass(s.t, np.concatenate([[0.0], s.e[1:]]), p["tau"]))


@form("permanent_set", "with_travel", "kinematics", 0.15, travel=(5, 40))
def set_with_travel(s: Scene, a: float, p: Shape) -> None:
    _lengthened(s, a * -np.expm1(-s.path() / p["travel"]))


@form("clamp_slip", "jumps_at_high_strain", "kinematics", 0.05, often=(3, 12), level=(0.6, 0.9))
def slip_jumps(s: Scene, a: float, p: Shape) -> None:
    rng = s.rng()
    count = int(p["often"])
    top = s.e.max()
    levels = top * rng.uniform(p["level"], 0.98, count)
    s.e = s.e - ratchet_slips(s.e, levels, a * rng.uniform(0.5, 1.5, count), 0.5 * top)


@form("clamp_slip", "few_big_jumps", "kinematics", 0.1)
def slip_few(s: Scene, a: float, p: Shape) -> None:
    rng = s.rng()
    starts = np.sort(rng.uniform(0.1, 0.8, 2)) * s.t[-1]
    slipped = np.zeros_like(s.e)
    for start, share in zip(starts, rng.uniform(0.5, 1, 2), strict=True):
        later = np.flatnonzero((s.t > start) & (s.e > 0.75 * s.e.max()))
        if later.size:
            slipped[later[0] :] += a * share
    s.e = s.e - slipped


@form("clamp_slip", "slides_above_threshold", "kinematics", 0.2, threshold=(0.55, 0.85))
def slip_slides(s: Scene, a: float, p: Shape) -> None:
    level = p["threshold"] * s.e.max()
    over = np.maximum(s.e - level, 0) / max(s.e.max() - level, 1e-6)
    slid = np.concatenate([[0.0], np.cumsum(over[1:] * np.diff(s.t))])
    s.e = s.e - a * slid / (30 + slid)


def _lost_motion(x: np.ndarray, gap: float) -> np.ndarray:
    """Output of a drive with play `gap`, zeroed at the start."""
    return x - stop(x, gap / 2)


@form("actuator_backlash", "dead_zone", "kinematics", 0.1)
def dead_zone(s: Scene, a: float, p: Shape) -> None:
    s.e = _lost_motion(s.e, a)


@form("actuator_backlash", "two_gaps", "kinematics", 0.1, second=(0.2, 0.6))
def two_gaps(s: Scene, a: float, p: Shape) -> None:
    s.e = _lost_motion(_lost_motion(s.e, a), a * p["second"])


@form("actuator_backlash", "wound_up_drive", "kinematics", 0.1, travel=(0.002, 0.01))
def wound_up(s: Scene, a: float, p: Shape) -> None:
    """After each reversal the drive winds up elastically over a short travel."""
    turn = last_turning_point(s.e, 1e-4).astype(np.int64)
    since = s.e - s.e[turn]
    sign = np.sign(since)
    before = np.where(turn > 0, -sign, 0.0)
    wound = before + (sign - before) * -np.expm1(-np.abs(since) / p["travel"])
    s.e = s.e - 0.5 * a * wound
