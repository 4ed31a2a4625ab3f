"""Band-limited noise that uses the whole stroke evenly and stays within the limits of the carriage."""

from __future__ import annotations

import math

import numpy as np
from scipy.special import erf

from worlds_fourth.motion.plan import STEP_S, Plan
from worlds_fourth.randoms import Rng
from worlds_fourth.signals import Array

SINES = 60
TRIES = 4  # to bring it to the limits of the carriage by its pace


def noise_motion(rng: Rng, plan: Plan, minutes: float) -> Array:
    """Displacement in mm every `STEP_S`: sines squashed towards an even distribution over the stroke."""
    hz = np.sort(rng.uniform(0.02, rng.uniform(1.0, 3.0), SINES))
    phases = rng.uniform(0, 2 * np.pi, SINES)
    heights = np.sqrt(1 / (1 + (hz / rng.uniform(0.4, 2.0)) ** 2)) * rng.uniform(0.3, 1, SINES)
    time_s = np.arange(0, max(30.0, _left_s(plan, minutes)) + 25.0, STEP_S)
    squash = rng.uniform(0.9, 2.2)
    pace = 0.4
    for _ in range(TRIES):
        y = np.zeros_like(time_s)
        for height, f, phase in zip(heights, hz, phases, strict=True):
            y += height * np.sin(2 * np.pi * f * pace * time_s + phase)
        y = erf(y / (squash * y.std() * 1.414))
        y = (y - y.min()) / np.ptp(y) * plan.top_mm
        share = _share_of_limits(y, plan)
        if 0.97 < share < 1.0:
            break
        pace *= 0.985 / share
    return y


def _left_s(plan: Plan, minutes: float) -> float:
    triangles_s = 0.0
    if plan.triangles:
        triangles_s = plan.triangles * (2 * plan.triangle_mm / plan.triangle_mm_s + 0.6) + plan.top_mm
    rest_s = plan.rest * (plan.rest_s + 2 * plan.top_mm / 3)
    return minutes * 60.0 - plan.holds * plan.hold_s - rest_s - triangles_s


def _share_of_limits(y: Array, plan: Plan) -> float:
    speed = np.gradient(y, STEP_S)
    acceleration = np.gradient(speed, STEP_S)
    return max(np.abs(speed).max() / plan.fastest_mm_s, math.sqrt(np.abs(acceleration).max() / plan.hardest_mm_s2))
