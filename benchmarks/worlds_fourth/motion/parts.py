"""Holds, rests and triangles that are put into the noise where it turns; each begins and ends at the same place."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from worlds_fourth.motion.plan import STEP_S, Plan
from worlds_fourth.randoms import Rng
from worlds_fourth.signals import Array

Part = tuple[int, Array]  # sample of the noise, and what is put in there
ACCELERATION = 36.0  # mm/s^2 of a ramp, about


def ramp(start_mm: float, end_mm: float, speed_mm_s: float) -> Array:
    """Half a cosine from one place to another, without its last point."""
    way = abs(end_mm - start_mm)
    seconds = max(way * math.pi / 2 / speed_mm_s, math.pi * math.sqrt(way / ACCELERATION))
    count = max(8, int(seconds / STEP_S))
    return start_mm + (end_mm - start_mm) * 0.5 * (1 - np.cos(np.pi * np.arange(count) / count))


def turns_of(y: Array) -> Array:
    """Samples at which the motion turns, away from both ends."""
    speed = np.gradient(y, STEP_S)
    turns = np.where(np.sign(speed[1:]) != np.sign(speed[:-1]))[0] + 1
    return turns[(turns > 200) & (turns < len(y) - 400)]


def draw_parts(rng: Rng, plan: Plan, y: Array, turns: Array) -> list[Part]:
    """What is put in, in the order of time."""
    parts = _holds(rng, plan, y, turns)
    if plan.rest and len(turns):
        parts.append(_rest(rng, plan, y, turns))
    if plan.triangles and len(turns):
        parts.append(_triangles(rng, plan, y, turns))
    return sorted(parts, key=lambda part: part[0])


def _holds(rng: Rng, plan: Plan, y: Array, turns: Array) -> list[Part]:
    high = turns[y[turns] > 0.35 * plan.top_mm]
    count = min(plan.holds, len(high))
    chosen: Iterable[int] = rng.choice(high, count, replace=False) if count else []
    return [(int(k), np.full(int(plan.hold_s / STEP_S), y[k])) for k in chosen]


def _rest(rng: Rng, plan: Plan, y: Array, turns: Array) -> Part:
    k = int(turns[np.argmin(y[turns] + 0.2 * plan.top_mm * rng.random(len(turns)))])
    down, up = ramp(y[k], 0, 3.0), ramp(0, y[k], 3.0)
    return k, np.r_[down, np.zeros(int(plan.rest_s / STEP_S)), up]


def _triangles(rng: Rng, plan: Plan, y: Array, turns: Array) -> Part:
    k = int(rng.choice(turns))
    low, high = plan.top_mm * rng.uniform(0, 0.1), plan.triangle_mm
    count = int((high - low) / plan.triangle_mm_s / STEP_S) + 1
    one = np.r_[np.linspace(low, high, count), np.linspace(high, low, count)[1:-1]]
    all_of_them = np.r_[np.full(200, low), np.tile(one, plan.triangles), np.full(200, low)]
    width = int(2.2 * plan.triangle_mm_s / plan.hardest_mm_s2 / STEP_S) | 1  # rounds the corners
    rounded = np.convolve(np.pad(all_of_them, width // 2, mode="edge"), np.ones(width) / width, "valid")
    return k, np.r_[ramp(y[k], low, 4.0), rounded, ramp(low, y[k], 4.0)]
