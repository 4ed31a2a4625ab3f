"""Campaigns of one specimen long after the one that a compensator learned from."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from compensation.paper.paper_campaigns import GAUGE_LENGTH_MM, SEEDS_A_SET
from gcode.programs.make import make
from gcode.support.files import make_folder
from gcode.trajectories.presets import preset as trajectory
from testbench.campaigns.campaign import Plan, matches, simulate_campaign
from testbench.campaigns.clearing import vacant
from testbench.knit.presets import preset
from testbench.recordings.files import read_recording
from testbench.recordings.recording import Recording
from testbench.rig.simulation.played import played

TRAJECTORIES = ("paper-1", "paper-2", "paper-3")
FIRST_SEED = 500


def campaign(folder: Path, sensor: str, number: int, which: int) -> Recording:
    """The `which`-th campaign (from 1 on) of specimen `number`; those before it are its past."""
    programs = [_program(folder, number, index) for index in range(1, which + 1)]
    target = folder / f"{sensor}-age{which}-{number}"
    named = f"{sensor}@{number}"
    motion, gauge_length_mm = played(programs[-1])
    seed = FIRST_SEED + which + SEEDS_A_SET * number
    plan = Plan(programs[-1], preset(named), gauge_length_mm, seed, named, past=tuple(programs[:-1]))
    if not matches(target, plan):
        vacant(target, overwrite=True)
        simulate_campaign(plan, target, motion)
    return read_recording(target)


def chain(folder: Path, sensor: str, number: int, wanted: Sequence[int]) -> dict[int, Recording]:
    """Several of them."""
    return {which: campaign(folder, sensor, number, which) for which in wanted}


def _program(folder: Path, number: int, which: int) -> Path:
    target = folder / f"trajectory-age{which}-{number}"
    if not (target / "program.tap").exists():
        make_folder(target)
        seed = FIRST_SEED + which + SEEDS_A_SET * number
        make(trajectory(TRAJECTORIES[(which - 1) % len(TRAJECTORIES)]), seed, GAUGE_LENGTH_MM).write(target)
    return target / "program.tap"
