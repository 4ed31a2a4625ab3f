"""The stage's motion: what a controller makes of a Mach4 program."""

from __future__ import annotations

from pathlib import Path

from gcode.support.errors import UserError
from testbench.recordings.checks import check_gauge_length, check_strain
from testbench.rig.simulation.simulated import SIMULATED_HZ, Motion

DEFAULT_GAUGE_LENGTH_MM = 25.0


def played(path: Path, gauge_length_mm: float | None = None) -> tuple[Motion, float]:
    """Play a program: the stage's motion from zero strain on, and the gauge length.

    Parameters
    ----------
    path : Path
        Mach4 program.
    gauge_length_mm : float, optional
        Default: the one that the program's header names, else 25 mm.

    Raises
    ------
    UserError
        If the file is not a program that the planner can play, or one that no sample of this gauge length outlives.
    """
    from gcode.mach4.controller import play
    from gcode.mach4.reader import load_program

    try:
        program = load_program(path)
        trajectory = play(program, rate_hz=SIMULATED_HZ)
    except UserError as error:
        raise UserError(f"{path}: {str(error).removeprefix(f'{path}: ')}") from None
    offset_mm = program.header_number("spec.offset_mm") or 0.0
    gauge = gauge_length_mm
    if gauge is None:
        gauge = program.header_number("gauge_length_mm") or DEFAULT_GAUGE_LENGTH_MM
    check_gauge_length(gauge, str(path))
    motion = Motion(trajectory.time_s, trajectory.position_mm - offset_mm)
    check_strain(str(path), motion.displacement_mm, gauge, lambda place: f"at {motion.time_s[place]:.4g} s")
    return motion, float(gauge)
