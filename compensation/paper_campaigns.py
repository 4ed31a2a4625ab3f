"""The campaigns behind `compensation table`: the paper's trajectories on the simulated sensors."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from gcode.support.files import make_folder
from testbench.recording import Recording

GAUGE_LENGTH_MM = 25.0
# name of the run -> (trajectory preset, trajectory seed, seed of the rig)
RUNS = {
    "T": ("paper-1", 51, 1),
    "A": ("paper-2", 52, 2),
    "B": ("paper-3", 53, 3),
    "fast-T": ("fast", 54, 4),
    "fast-A": ("fast", 55, 5),
}


def campaigns(folder: Path, sensor: str, progress: Callable[[str], None] = lambda note: None) -> dict[str, Recording]:
    """Recordings of one sensor, simulated where `folder` does not hold them yet."""
    from testbench.campaign import Plan, matches, simulate_campaign
    from testbench.knit.presets import preset
    from testbench.recording import read_recording
    from testbench.rig.motion import played

    found = {}
    for name, (_, _, seed) in RUNS.items():
        target = folder / f"{sensor}-{name}"
        program = program_of(folder, name)
        motion, gauge_length_mm = played(program)
        plan = Plan(program, preset(sensor), gauge_length_mm, seed, sensor)
        if not matches(target, plan):
            simulate_campaign(plan, target, motion)
        found[name] = read_recording(target)
        progress(f"{sensor} {name}")
    return found


def program_of(folder: Path, name: str) -> Path:
    """The run's Mach4 program, written where it is missing."""
    from gcode.output import make
    from gcode.presets import preset

    trajectory, seed, _ = RUNS[name]
    target = folder / f"trajectory-{name}"
    if not (target / "program.tap").exists():
        make_folder(target)
        make(preset(trajectory), seed, GAUGE_LENGTH_MM).write(target)
    return target / "program.tap"
