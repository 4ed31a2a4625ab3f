"""Options that take a number, among them the limits of a motion."""

from __future__ import annotations

import argparse
from typing import Any

# As typed, the parameter that it sets, its unit and what it is.
SPEED = ("--v-max", "v_max_mm_per_s", "MM/S", "speed limit")
ACCELERATION = ("--a-max", "a_max_mm_per_s2", "MM/S2", "acceleration limit")
JERK = ("--j-max", "j_max_mm_per_s3", "MM/S3", "jerk limit")
LOWEST = ("--x-min", "x_min_mm", "MM", "machine travel, lower end")
HIGHEST = ("--x-max", "x_max_mm", "MM", "machine travel, upper end")
LIMITS = (SPEED, ACCELERATION, JERK, LOWEST, HIGHEST)


def number(
    parser: argparse._ActionsContainer, option: str, name: str, unit: str, words: str, **settings: Any
) -> None:
    """Declare an option that takes a number of a unit; `settings` are argparse's own."""
    parser.add_argument(option, dest=name, metavar=unit, help=words, **{"type": float, **settings})
