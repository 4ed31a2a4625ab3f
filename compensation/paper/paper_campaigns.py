"""The campaigns behind `compensation table`: the paper's trajectories on the simulated sensors, one after another.

T is the first stretch of a new sensor; A, B and the two fast runs follow, each after a rest.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from gcode.support.files import make_folder
from testbench.recordings.recording import Recording

GAUGE_LENGTH_MM = 25.0
# In the order in which a sensor goes through them: name of the run -> (trajectory preset, trajectory seed, rig seed)
RUNS = {
    "T": ("paper-1", 51, 1),
    "A": ("paper-2", 52, 2),
    "B": ("paper-3", 53, 3),
    "fast-T": ("fast", 54, 4),
    "fast-A": ("fast", 55, 5),
}
TAB = ("T", "A", "B")
SEEDS_A_SET = 100


def campaigns(
    folder: Path,
    sensor: str,
    progress: Callable[[str], None] = lambda note: None,
    runs: Sequence[str] = tuple(RUNS),
    number: int = 0,
) -> dict[str, Recording]:
    """Recordings of one sensor, simulated where `folder` does not hold them yet.

    `runs` are the first ones of `RUNS`; another `number` is another specimen of the preset `sensor`, other
    trajectories, other noise.
    """
    found: dict[str, Recording] = {}
    past: tuple[Path, ...] = ()
    for name in runs:
        program = program_of(folder, name, number)
        seed = RUNS[name][2] + SEEDS_A_SET * number
        found[name] = recorded(folder / f"{sensor}-{name}{_suffix(number)}", program, sensor, number, seed, past)
        past = (*past, program)
        progress(f"{sensor} {name}")
    return found


def recorded(target: Path, program: Path, sensor: str, number: int, seed: int, past: tuple[Path, ...]) -> Recording:
    """The campaign of a specimen that went through the `past` programs, simulated where `target` does not hold it."""
    from testbench.campaigns.campaign import Plan, matches, simulate_campaign
    from testbench.campaigns.clearing import vacant
    from testbench.knit.presets import preset
    from testbench.recordings.files import read_recording
    from testbench.rig.simulation.played import played

    named = f"{sensor}@{number}" if number else sensor
    motion, gauge_length_mm = played(program)
    plan = Plan(program, preset(named), gauge_length_mm, seed, named, past=past)
    if not matches(target, plan):
        vacant(target, overwrite=True)
        simulate_campaign(plan, target, motion)
    return read_recording(target)


def program_of(folder: Path, name: str, number: int = 0) -> Path:
    """The run's Mach4 program, written where it is missing."""
    trajectory, seed, _ = RUNS[name]
    return planned(folder / f"trajectory-{name}{_suffix(number)}", trajectory, seed + SEEDS_A_SET * number)


def planned(target: Path, trajectory: str, seed: int) -> Path:
    """The Mach4 program of a trajectory preset, written where `target` does not hold it."""
    from gcode.programs.make import make
    from gcode.trajectories.presets import preset

    if not (target / "program.tap").exists():
        make_folder(target)
        make(preset(trajectory), seed, GAUGE_LENGTH_MM).write(target)
    return target / "program.tap"


def _suffix(number: int) -> str:
    return f"-{number}" if number else ""
