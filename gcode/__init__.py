"""Plan motion for a tensile tester and write it as a Mach4 program.

Examples
--------
>>> import gcode
>>> made = gcode.generate("paper-1", seed=3, duration_s=60)
>>> round(made.trajectory.duration_s) >= 60
True
>>> gcode.check(made.program, made.spec.limits).ok
True
"""

from typing import TYPE_CHECKING

from gcode.support.lazy import lazy_exports

if TYPE_CHECKING:  # for type checkers and editors; in a running program `_HOMES` says where a name is imported from
    from gcode.mach4.check import CheckResult as CheckResult
    from gcode.mach4.controller import Machine as Machine
    from gcode.mach4.program import Program as Program
    from gcode.programs.api import check as check
    from gcode.programs.api import generate as generate
    from gcode.programs.api import play as play
    from gcode.programs.api import read as read
    from gcode.programs.make import Made as Made
    from gcode.support.errors import UserError as UserError
    from gcode.trajectories.bounds import Limits as Limits
    from gcode.trajectories.designed import Hold as Hold
    from gcode.trajectories.designed import Multisine as Multisine
    from gcode.trajectories.designed import Ramp as Ramp
    from gcode.trajectories.designed import RateSweep as RateSweep
    from gcode.trajectories.designed import ReturnToZero as ReturnToZero
    from gcode.trajectories.designed import Staircase as Staircase
    from gcode.trajectories.designed import Triangle as Triangle
    from gcode.trajectories.natural import Noise as Noise
    from gcode.trajectories.presets import PRESETS as PRESETS
    from gcode.trajectories.presets import preset as preset
    from gcode.trajectories.trajectory import Trajectory as Trajectory
    from gcode.trajectories.trajectory import TrajectorySpec as TrajectorySpec

_HOMES = {
    "gcode.mach4.check": ["CheckResult"],
    "gcode.mach4.controller": ["Machine"],
    "gcode.mach4.program": ["Program"],
    "gcode.programs.api": ["check", "generate", "play", "read"],
    "gcode.programs.make": ["Made"],
    "gcode.support.errors": ["UserError"],
    "gcode.trajectories.bounds": ["Limits"],
    "gcode.trajectories.designed": [
        "Hold",
        "Multisine",
        "Ramp",
        "RateSweep",
        "ReturnToZero",
        "Staircase",
        "Triangle",
    ],
    "gcode.trajectories.natural": ["Noise"],
    "gcode.trajectories.presets": ["PRESETS", "preset"],
    "gcode.trajectories.trajectory": ["Trajectory", "TrajectorySpec"],
}
__all__, __getattr__, __dir__ = lazy_exports(__name__, _HOMES)
