"""plan(): from a spec, a seed and a gauge length to a trajectory within its limits."""

from __future__ import annotations

from dataclasses import replace
from numbers import Integral

import numpy as np

from gcode.motion.blocks import LOOK_AHEAD_BLOCKS, drive
from gcode.motion.limits import drive_within, path_blocks, sampled_positions
from gcode.motion.path import Frame, Path, join, way
from gcode.support.errors import UserError
from gcode.support.kinds import is_number
from gcode.trajectories.bounds import Limits, excesses
from gcode.trajectories.quantities import LARGEST_SEED, MAX_SAMPLES
from gcode.trajectories.trajectory import Trajectory, TrajectorySpec, position_decimals, sampled

MOST_STROKES = 2_000_000
LONGEST_MEAN_S = 5.0  # by which a jerk limit rounds the turns
# Finite differences of rounded positions, and the executed motion's own deviations, need some room.
_MARGINS = (0.95, 0.9, 0.8, 0.6)
# A controller that has twice the acceleration of a plan follows straight strokes within micrometres; with less, turns
# that lie between two samples are cut or passed by tenths of a millimetre.
_FOLLOWED = 0.5
# Shorter than a fibre or longer than a house is a mistake of units, and would take for ever to plan.
SHORTEST_GAUGE_MM, LONGEST_GAUGE_PLANNED_MM = 1e-3, 10_000.0


def plan(spec: TrajectorySpec, seed: int, gauge_length_mm: float, *, reserve: float = 1.0) -> Trajectory:
    """Plan a trajectory.

    Parameters
    ----------
    spec : TrajectorySpec
        What is wanted; `gcode.trajectories.presets.preset(name)` has the paper's.
    seed : int
        From 0 to 2^53 - 1; other seeds give independent trajectories of the same statistics.
    gauge_length_mm : float
        Length of the sample between the grips; strains are relative to it.
    reserve : float
        Part of the acceleration limit that the plan may use, at most 1; the rest is for the controller's deviations.

    Returns
    -------
    Trajectory
        Starts and ends at machine position 0, sampled at ``spec.rate_hz``, rounded to the program's decimals.

    Raises
    ------
    UserError
        If the gauge length or the seed is unusable, or the limits cannot be met.
    """
    check_request(spec, seed, gauge_length_mm)
    _check_jerk(spec)
    for margin in _MARGINS:
        trajectory = _within(spec, seed, gauge_length_mm, margin * reserve)
        beyond = excesses(trajectory.position_mm, spec.rate_hz, spec.limits)
        if not beyond:
            return trajectory
    told = f"limits: {beyond[0].at(spec.rate_hz)}"
    raise UserError(f"{told}; raise that limit, lower the spec's rate_hz, or ask for a slower motion")


def _within(spec: TrajectorySpec, seed: int, gauge_length_mm: float, margin: float) -> Trajectory:
    decimals = position_decimals(spec.rate_hz)
    usable = _usable_speed(spec)
    v_max = max(usable - 10.0**-decimals * spec.rate_hz, 0.9 * usable)
    a_max = _usable_acceleration(spec) * margin
    path = whole_path(spec, seed, gauge_length_mm, v_max, a_max)
    _check_samples(float(path.duration_s.sum()) * spec.rate_hz)
    check_travel(path, spec.limits)
    if not np.diff(np.round(path.position_mm, decimals)).any():
        raise UserError(f"{spec.name}: this protocol never moves; add a piece that does")
    sight = f"lower the spec's rate_hz (a controller sees {LOOK_AHEAD_BLOCKS} samples ahead)"
    motion = drive_within(path, v_max, a_max, "raise them" if usable == spec.limits.v_max_mm_per_s else sight)
    j_max = None if spec.limits.j_max_mm_per_s3 is None else spec.limits.j_max_mm_per_s3 * margin
    position = sampled_positions(motion, spec.rate_hz, a_max, j_max)
    return sampled(np.round(position, decimals) + 0.0, spec.rate_hz)


def _usable_acceleration(spec: TrajectorySpec) -> float:
    return min(spec.limits.a_max_mm_per_s2, _FOLLOWED * spec.controller_acceleration_mm_per_s2)


def _usable_speed(spec: TrajectorySpec) -> float:
    """The limit, or the speed from which the controller can stop within the blocks that it sees, one a sample.

    These grow shorter while the plan slows down at its acceleration a. In T s of sight lie v T - a T^2 / 2, and a
    controller of acceleration A needs v^2 / (2 A).
    """
    controller = spec.controller_acceleration_mm_per_s2
    in_sight = controller * LOOK_AHEAD_BLOCKS / spec.rate_hz
    return min(spec.limits.v_max_mm_per_s, in_sight * (1.0 + np.sqrt(1.0 - _usable_acceleration(spec) / controller)))


def _check_jerk(spec: TrajectorySpec) -> None:
    """Refuse a jerk limit that would round the turns for many seconds."""
    a_max, j_max = _usable_acceleration(spec), spec.limits.j_max_mm_per_s3
    least = 2.0 * a_max / LONGEST_MEAN_S
    if j_max is not None and j_max < least:
        raise UserError(
            f"limits: j max {j_max:g} mm/s3 is too low for a max {a_max:g} mm/s2 (at least {least:.3g}); raise it or "
            "lower a max"
        )


def whole_path(
    spec: TrajectorySpec, seed: int, gauge_length_mm: float, v_max_mm_per_s: float, a_max_mm_per_s2: float
) -> Path:
    """All pieces from machine position 0 and back to it, with an approach to each piece that starts elsewhere."""
    paths, here = [Path(np.zeros(1), np.zeros(0))], 0.0
    for index, piece in enumerate(spec.pieces):
        frame = Frame(gauge_length_mm, spec.offset_mm, spec.rate_hz, (seed, index), v_max_mm_per_s, a_max_mm_per_s2)
        if index == 0 and spec.offset_mm:
            paths.append(way([here, spec.offset_mm], spec.approach_mm_per_s))
            here = spec.offset_mm
        part = piece.path(here, frame)
        paths += [way([here, float(part.position_mm[0])], spec.approach_mm_per_s), part]
        here = float(part.position_mm[-1])
    return join(*paths, way([here, 0.0], spec.approach_mm_per_s))


def slowest_stroke(spec: TrajectorySpec, gauge_length_mm: float) -> tuple[float, float]:
    """The speed asked for, and the one that the limits allow (mm/s), where these are furthest apart."""
    v_max, a_max = _usable_speed(spec), spec.limits.a_max_mm_per_s2
    blocks = path_blocks(whole_path(spec, 0, gauge_length_mm, v_max, a_max), np.inf)
    moving = blocks.length_mm != 0
    if not moving.any():
        return v_max, v_max
    asked = blocks.speed_mm_per_s[moving]
    driven = drive(replace(blocks, speed_mm_per_s=np.minimum(blocks.speed_mm_per_s, v_max)), a_max)
    reached = np.abs(driven.velocity_mm_per_s[1::3][moving])
    worst = int((reached / asked).argmin())
    return float(asked[worst]), float(reached[worst])


def check_gauge_length(gauge_length_mm: float) -> None:
    """Refuse a gauge length that cannot be planned."""
    is_length = is_number(gauge_length_mm) and np.isfinite(gauge_length_mm)
    if not (is_length and SHORTEST_GAUGE_MM <= gauge_length_mm <= LONGEST_GAUGE_PLANNED_MM):
        came = f"{gauge_length_mm:g} mm" if is_length else repr(gauge_length_mm)
        allowed = f"{SHORTEST_GAUGE_MM:g} to {LONGEST_GAUGE_PLANNED_MM:g} mm"
        raise UserError(f"gauge length must be {allowed}, got {came}")


def check_request(spec: TrajectorySpec, seed: int, gauge_length_mm: float) -> None:
    """Refuse a gauge length, a seed or a length of run that cannot be planned."""
    check_gauge_length(gauge_length_mm)
    if not (is_number(seed, Integral) and 0 <= seed <= LARGEST_SEED):
        raise UserError(f"seed must be a whole number from 0 to {LARGEST_SEED}, got {seed!r}")
    _check_samples(sum(getattr(piece, "duration_s", 0.0) for piece in spec.pieces) * spec.rate_hz)
    strokes = sum(piece.strokes for piece in spec.pieces)
    if strokes > MOST_STROKES:
        raise UserError(
            f"a trajectory may have {MOST_STROKES} strokes and rests, this one would have {strokes}; lower the cycles"
        )


def _check_samples(samples: float) -> None:
    """Refuse a run that takes too long, before it is planned."""
    if not samples <= MAX_SAMPLES:
        raise UserError(
            f"a trajectory may have {MAX_SAMPLES} samples, this one would have {samples:.3g}; "
            "lower rate_hz or the durations, or ask for faster moves"
        )


def check_travel(path: Path, limits: Limits) -> None:
    """Refuse a path that leaves the machine's travel."""
    low, high = float(path.position_mm.min()), float(path.position_mm.max())
    if low < limits.x_min_mm - 1e-9 or high > limits.x_max_mm + 1e-9:
        raise UserError(
            f"travel: this motion needs {low:.4g} to {high:.4g} mm, the machine allows {limits.x_min_mm:g} to "
            f"{limits.x_max_mm:g} mm; lower the strain, the gauge length or the offset"
        )
