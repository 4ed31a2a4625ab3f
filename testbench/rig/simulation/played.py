"""The stage's motion: what a controller makes of a Mach4 program, and of those that a sensor went through before."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from gcode.support.errors import UserError
from testbench.knit.effect import FloatArray
from testbench.recordings.checks import check_gauge_length, check_strain
from testbench.rig.simulation.simulated import SIMULATED_HZ, Motion

DEFAULT_GAUGE_LENGTH_MM = 25.0
DEFAULT_REST_S, LONGEST_REST_S = 600.0, 1e5
RETURN_MM_PER_S = 1.0


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


def past_displacement(
    motions: Sequence[Motion], rest_s: float | Sequence[float], begins_mm: float = 0.0
) -> FloatArray:
    """The stage's displacement up to a recording: all `motions`, each with a rest after it, shape (n,).

    A knit remembers: its largest stretch, its set, how long its contacts have settled. The second recording of one
    sensor is therefore not the first one again. The rig plays the earlier programs first and records only the last.

    Parameters
    ----------
    motions : sequence of Motion
        In the order in which they were played.
    rest_s : float or sequence of float
        Rest after each, where the next motion begins; one that ends elsewhere is brought there at 1 mm/s, which may
        take longer than the rest.
    begins_mm : float
        Where the recorded motion begins.
    """
    if not motions:
        return np.zeros(0)
    parts = []
    next_mm = [*(float(motion.displacement_mm[0]) for motion in motions[1:]), begins_mm]
    for motion, begin_mm, after_s in zip(motions, next_mm, np.broadcast_to(rest_s, len(motions)), strict=True):
        end_mm = float(motion.displacement_mm[-1])
        way_back_s = abs(end_mm - begin_mm) / RETURN_MM_PER_S
        taken_s = max(after_s, way_back_s + 1 / SIMULATED_HZ)
        times_s = np.arange(1, round(taken_s * SIMULATED_HZ)) / SIMULATED_HZ
        parts += [motion.displacement_mm, np.interp(times_s, [0.0, max(way_back_s, 1e-9)], [end_mm, begin_mm])]
    return np.concatenate(parts)
