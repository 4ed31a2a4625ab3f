"""Small rigs and motions that the tests share."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from testbench.campaigns.plan import Plan
from testbench.knit.catalogue import baseline
from testbench.rig.simulation.simulated import SIMULATED_HZ, Motion, SimulatedRig

PROGRAM_TEXT = """(TWO TRIANGLES)
G90
G21
G94
G1 X5 F300
G1 X0 F300
G1 X5 F300
G1 X0 F300
M30
"""


def triangle(duration_s: float = 20.0, top_mm: float = 7.5, period_s: float = 10.0) -> Motion:
    """A triangle from 0 to `top_mm`."""
    time_s = np.arange(int(duration_s * SIMULATED_HZ) + 1) / SIMULATED_HZ
    return Motion(time_s, top_mm * (1 - np.abs(2 * ((time_s / period_s) % 1) - 1)))


def rig(seed: int = 1, duration_s: float = 20.0) -> SimulatedRig:
    """The baseline knit on a triangle."""
    return SimulatedRig(baseline(), triangle(duration_s), 25.0, seed)


def program(folder: Path) -> Path:
    """A small program on disk."""
    path = folder / "two_triangles.tap"
    path.write_text(PROGRAM_TEXT)
    return path


def plan(folder: Path, seed: int = 1) -> Plan:
    """A plan for the small program."""
    return Plan(program(folder), baseline(), 25.0, seed, "baseline")
