"""What a motion is made of: limits of the carriage, and how many holds, rests and triangles."""

from __future__ import annotations

from dataclasses import dataclass

from worlds_fourth.randoms import Rng

STEP_S = 0.005  # of the motion before it is sampled


@dataclass(frozen=True)
class Plan:
    """Numbers of a motion, drawn.

    Attributes
    ----------
    top_mm : float
        Longest displacement.
    fastest_mm_s, hardest_mm_s2 : float
        Limits of speed and acceleration.
    holds, hold_s : int, float
    rest, rest_s : bool, float
        Whether the carriage goes back to 0 and waits.
    triangles, triangle_mm_s, triangle_mm : int, float, float
        How many, how fast and how far.
    """

    top_mm: float
    fastest_mm_s: float
    hardest_mm_s2: float
    holds: int
    hold_s: float
    rest: bool
    rest_s: float
    triangles: int
    triangle_mm_s: float
    triangle_mm: float


def draw_plan(rng: Rng, longest_mm: float) -> Plan:
    """Draw the numbers of a motion up to nearly `longest_mm`."""
    top_mm = longest_mm * rng.uniform(0.97, 1.0)
    fastest, hardest = rng.uniform(5, 8), rng.uniform(18, 30)
    holds = int(rng.choice([0, 1, 2], p=[0.35, 0.3, 0.35]))
    hold_s = rng.uniform(18, 24)
    rest = bool(rng.random() < 0.35)
    rest_s = rng.uniform(12, 30)
    triangles = int(rng.choice([0, 3, 5], p=[0.5, 0.25, 0.25]))
    speed = rng.uniform(2, min(fastest, 6.0))
    return Plan(
        top_mm, fastest, hardest, holds, hold_s, rest, rest_s, triangles, speed, top_mm * rng.uniform(0.6, 1.0)
    )
