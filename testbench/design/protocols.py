"""Designed protocols within given limits: the menu from which the next experiment is chosen."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from gcode.motion.limits import drive_within
from gcode.motion.path import Frame, join
from gcode.programs.make import Made, make
from gcode.support.errors import UserError
from gcode.support.kinds import number
from gcode.trajectories.designed import Hold, Multisine, Ramp, RateSweep, ReturnToZero, Staircase, Triangle
from gcode.trajectories.natural import Noise
from gcode.trajectories.planning import check_request
from gcode.trajectories.protocol import Piece, Protocol
from gcode.trajectories.trajectory import Limits, TrajectorySpec

RATE_HZ = 20.0
SHORTEST_EXPERIMENT_S, LONGEST_EXPERIMENT_S = 60.0, 24 * 3600.0
SHORTEST_STROKE_S = 2 / RATE_HZ  # a stroke of less than two steps cannot be planned
APPROACHES_S = 12.0  # to the first position of a random motion, and back to zero at the end
NOISE = "noise"  # the protocol that all others are measured against
SHARES = (1.0, 0.9, 0.75, 0.5)  # of the limits that a design uses
_DESIGNS = 4  # of one protocol, each for less time, until its program keeps the time


@dataclass(frozen=True)
class Bounds:
    """What the machine and the sensor allow.

    Attributes
    ----------
    v_max_mm_per_s, a_max_mm_per_s2 : float
    strain_max_percent : float
    duration_s : float
        Of the whole run; every protocol takes as long, so that none wins by being longer.
    gauge_length_mm : float

    Examples
    --------
    >>> import testbench as tb
    >>> tb.Bounds(duration_s=120, strain_max_percent=20).v_max_mm_per_s
    10.0
    """

    v_max_mm_per_s: float = 10.0
    a_max_mm_per_s2: float = 20.0
    strain_max_percent: float = 30.0
    duration_s: float = 600.0
    gauge_length_mm: float = 25.0

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not (np.isfinite(number(name, value)) and value > 0):
                raise UserError(f"{name}: must be a positive number, got {value:g}")

    @property
    def stroke_mm(self) -> float:
        """Travel from zero to the largest strain."""
        return self.strain_max_percent * self.gauge_length_mm / 100

    @property
    def fast_mm_per_s(self) -> float:
        """Fastest useful speed: within the limit, and reached within a quarter of the stroke."""
        reachable = float(np.sqrt(0.5 * self.stroke_mm * self.a_max_mm_per_s2))
        return min(0.95 * self.v_max_mm_per_s, reachable)

    def speed(self, stroke_s: float) -> float:
        """Speed that takes `stroke_s` for the whole stroke, at most the fastest."""
        return min(self.stroke_mm / stroke_s, self.fast_mm_per_s)


# The gauge length is the sensor's, which is said once, beside them.
ALLOWED = tuple(one.name for one in fields(Bounds) if one.name != "gauge_length_mm")


def bounds_with(said: Mapping[str, float], gauge_length_mm: float) -> Bounds:
    """The bounds with the fields that were said, for a sensor of this length.

    Parameters
    ----------
    said : mapping
        Fields of `testbench.Bounds` that differ from its defaults.
    gauge_length_mm : float

    Raises
    ------
    UserError
        If there is no such field, a value is not positive, or another gauge length was said than the sensor has.
    """
    if "gauge_length_mm" in said and said["gauge_length_mm"] != gauge_length_mm:
        raise UserError(
            f"bounds: the gauge length is {gauge_length_mm:g} mm, got {said['gauge_length_mm']!r}; for a sensor of "
            "another length give gauge_length_mm beside bounds"
        )
    if strange := sorted(map(str, set(said) - {*ALLOWED, "gauge_length_mm"})):
        raise UserError(f"bounds: allowed are {', '.join(ALLOWED)}; got {', '.join(strange)}")
    return Bounds(**{**said, "gauge_length_mm": gauge_length_mm})


def menu(bounds: Bounds) -> dict[str, TrajectorySpec]:
    """Every designed protocol by name, each about as long as `bounds` says, the plain noise first.

    Raises
    ------
    UserError
        If the duration is too short for the designs, or longer than a day; or if a stroke to the largest strain takes
        less than two steps of the plan, or there and back more than the whole run.
    """
    _check(bounds)
    return {name: spec_of(name, pieces(bounds), bounds) for name, pieces in MENU.items()}


def drivable(bounds: Bounds, seed: int) -> dict[str, Made]:
    """Every protocol whose program passes its own check and is no longer than `bounds` say.

    Each is designed for as much of the speed and acceleration as it can use.

    Raises
    ------
    UserError
        As `menu`, or for a seed or a gauge length that no trajectory has.
    """
    _check(bounds)
    check_request(spec_of("any", [Hold(duration_s=1.0)], bounds), seed, bounds.gauge_length_mm)
    found: dict[str, Made] = {}
    for share in SHARES:
        for name in [name for name in MENU if name not in found]:
            # A design that cannot be executed within the limits is tried again with more room to them.
            with contextlib.suppress(UserError):
                if made := _in_time(name, bounds, share, seed):
                    found[name] = made
    return {name: found[name] for name in MENU if name in found}


def _in_time(name: str, bounds: Bounds, share: float, seed: int) -> Made | None:
    """The program of a protocol, for a share of the limits, designed for less time as long as it takes too long."""
    eased = replace(
        bounds, v_max_mm_per_s=share * bounds.v_max_mm_per_s, a_max_mm_per_s2=share * bounds.a_max_mm_per_s2
    )
    for _ in range(_DESIGNS):
        made = make(spec_of(name, MENU[name](eased), bounds), seed, bounds.gauge_length_mm)
        over_s = made.trajectory.duration_s - bounds.duration_s
        if over_s <= 0:
            return made
        eased = replace(eased, duration_s=eased.duration_s - over_s - 1 / RATE_HZ)
    return None


def check_duration(name: str, duration_s: float) -> None:
    """Refuse an experiment that is too short for the designs, or longer than a day; `name` is what it was said by."""
    if not SHORTEST_EXPERIMENT_S <= duration_s <= LONGEST_EXPERIMENT_S:
        span = f"{SHORTEST_EXPERIMENT_S / 60:g} min to {LONGEST_EXPERIMENT_S / 3600:g} h"
        raise UserError(f"{name}: an experiment takes {span}, got {duration_s / 60:g} min")


def _check(bounds: Bounds) -> None:
    check_duration("duration_s", bounds.duration_s)
    stroke_s = bounds.stroke_mm / max(bounds.fast_mm_per_s, 1e-300)
    if SHORTEST_STROKE_S <= stroke_s <= bounds.duration_s / 2:
        return
    what = f"{bounds.strain_max_percent:g} % of {bounds.gauge_length_mm:g} mm at up to {bounds.fast_mm_per_s:g} mm/s"
    raise UserError(
        f"a stroke ({what}) must take from {SHORTEST_STROKE_S:g} s to half the run ({bounds.duration_s / 2:g} s), "
        f"not {stroke_s:.3g} s; change the largest strain, or the limits of speed and acceleration"
    )


def spec_of(name: str, pieces: Sequence[Piece], bounds: Bounds) -> TrajectorySpec:
    """Pieces in a row, to be executed within the bounds."""
    limits = Limits(v_max_mm_per_s=bounds.v_max_mm_per_s, a_max_mm_per_s2=bounds.a_max_mm_per_s2)
    protocol = Protocol(pieces=tuple(pieces))
    return TrajectorySpec.of(
        protocol, name=name, limits=limits, rate_hz=RATE_HZ, approach_mm_per_s=bounds.speed(10.0)
    )


def filled(bounds: Bounds, blocks: Callable[[int], Sequence[Piece]]) -> list[Piece]:
    """As many blocks as fit into the duration, then a rest.

    Parameters
    ----------
    blocks : callable
        Pieces of the block of this number; each block starts and ends at zero strain.
    """
    frame = Frame(bounds.gauge_length_mm, 0.0, RATE_HZ, (0,), bounds.v_max_mm_per_s, bounds.a_max_mm_per_s2)
    pieces: list[Piece] = [Hold(duration_s=5.0)]
    left_s = bounds.duration_s - 5.0
    number = 0
    while True:
        block = blocks(number)
        takes_s = _seconds(block, frame)
        if takes_s > left_s and number:
            break
        pieces += block
        left_s, number = left_s - takes_s, number + 1
    return [*pieces, Hold(duration_s=left_s)] if left_s > 1 else pieces


def _seconds(block: Sequence[Piece], frame: Frame) -> float:
    """How long a block takes within the limits."""
    paths, here = [], 0.0
    for piece in block:
        paths.append(piece.path(here, frame))
        here = float(paths[-1].position_mm[-1])
    return drive_within(join(*paths), frame.v_max_mm_per_s, frame.a_max_mm_per_s2).end_s


def _noise(bounds: Bounds) -> list[Piece]:
    """Like the paper's slow random motion."""
    return [_random(bounds, _pace(bounds, 0.316))]


def _fast_noise(bounds: Bounds) -> list[Piece]:
    shape = _pace(bounds, 0.63) | {"persistence": 0.2, "pace_spread": 0.9}
    return [_random(bounds, shape)]


def _random(bounds: Bounds, shape: Mapping[str, Any]) -> Noise:
    return Noise(duration_s=bounds.duration_s - APPROACHES_S, high_percent=bounds.strain_max_percent, **shape)


def _pace(bounds: Bounds, cells_per_s: float) -> dict[str, Any]:
    # Noise crosses about the whole stroke in a cell: slower cells where the speed limit would not allow it.
    slowest = 0.5 * bounds.fast_mm_per_s / bounds.stroke_mm
    return {"octaves": 2, "persistence": 0.12, "cells_per_s": min(cells_per_s, slowest), "peak": 0.7}


def _triangles(bounds: Bounds, speed_mm_per_s: float) -> list[Piece]:
    triangle = Triangle(high_percent=bounds.strain_max_percent, speed_mm_per_s=speed_mm_per_s)
    return filled(bounds, lambda _: [triangle])


def _rate_sweep(bounds: Bounds) -> list[Piece]:
    """Every speed for about as long: one slow triangle, many fast ones."""
    speeds = np.geomspace(bounds.speed(min(40.0, bounds.duration_s / 20)), bounds.fast_mm_per_s, 5)
    cycles = [max(round(float(speed / speeds[0])), 1) for speed in speeds]
    rounds = [
        RateSweep(high_percent=bounds.strain_max_percent, speeds_mm_per_s=(float(speed),), cycles=count, rest_s=2.0)
        for speed, count in zip(speeds, cycles, strict=True)
    ]
    return filled(bounds, lambda number: [rounds[number % len(rounds)]])


def _staircase(bounds: Bounds) -> list[Piece]:
    levels = bounds.strain_max_percent * np.array([0.2, 0.4, 0.6, 0.8, 1.0, 0.8, 0.6, 0.4, 0.2, 0.0])
    hold_s = float(np.clip(bounds.duration_s / 2.2 / len(levels), 1, 120))
    steps = Staircase(levels_percent=tuple(levels.tolist()), speed_mm_per_s=bounds.fast_mm_per_s, hold_s=hold_s)
    return filled(bounds, lambda _: [steps])


def _long_hold(bounds: Bounds) -> list[Piece]:
    """Fast up, hold long, fast back, rest as long: relaxation on the way, recovery afterwards."""
    hold_s, fast = (bounds.duration_s - 10.0) * 0.45, bounds.fast_mm_per_s
    up = Ramp(to_percent=bounds.strain_max_percent, speed_mm_per_s=fast)
    return filled(bounds, lambda _: [up, Hold(duration_s=hold_s), ReturnToZero(speed_mm_per_s=fast, rest_s=hold_s)])


def _return_to_zero(bounds: Bounds) -> list[Piece]:
    """Stretches of many heights, a rest at zero after each."""
    heights = bounds.strain_max_percent * np.array([1.0, 0.4, 0.8, 0.2, 0.6])
    fast = bounds.fast_mm_per_s

    def block(number: int) -> list[Piece]:
        up = Ramp(to_percent=float(heights[number % len(heights)]), speed_mm_per_s=fast)
        return [up, Hold(duration_s=5.0), ReturnToZero(speed_mm_per_s=fast, rest_s=20.0)]

    return filled(bounds, block)


def _growing(bounds: Bounds) -> list[Piece]:
    """Triangles that grow to the full strain over the run."""
    speed = bounds.speed(8.0)
    mean_s = 2 * 0.6 * bounds.stroke_mm / speed
    count = max(int(bounds.duration_s / mean_s), 2)

    def block(number: int) -> list[Piece]:
        share = min(0.2 + 0.8 * number / (count - 1), 1.0)
        return [Triangle(high_percent=share * bounds.strain_max_percent, speed_mm_per_s=speed)]

    return filled(bounds, block)


def _new_heights(bounds: Bounds) -> list[Piece]:
    """Each new height three times, with a rest, then small triangles again: what a first time leaves behind."""
    speed = bounds.speed(6.0)
    sizes = np.linspace(0.3, 1.0, 6)

    def block(number: int) -> list[Piece]:
        top = float(sizes[min(number, len(sizes) - 1)]) * bounds.strain_max_percent
        small = 0.3 * bounds.strain_max_percent
        return [
            Triangle(high_percent=top, speed_mm_per_s=speed, cycles=3),
            Hold(duration_s=15.0),
            Triangle(high_percent=small, speed_mm_per_s=speed, cycles=4),
            Hold(duration_s=15.0),
        ]

    return filled(bounds, block)


def _bursts(bounds: Bounds) -> list[Piece]:
    """Fast work and rests in turn: what comes from the motion goes with it, what comes from the room stays."""
    fast = bounds.fast_mm_per_s
    rest_s = float(np.clip(bounds.duration_s / 8, 10, 150))
    cycles = max(round(rest_s * fast / (2 * bounds.stroke_mm)), 1)
    work = Triangle(high_percent=bounds.strain_max_percent, speed_mm_per_s=fast, cycles=cycles)
    return filled(bounds, lambda _: [work, Hold(duration_s=rest_s)])


def _multisine(bounds: Bounds) -> list[Piece]:
    """Slow to fast sines whose speeds are alike."""
    top_hz = bounds.fast_mm_per_s / (np.pi * bounds.stroke_mm)
    frequencies = np.geomspace(max(top_hz / 30, 2 / bounds.duration_s), top_hz, 6)
    return [
        Hold(duration_s=5.0),
        Multisine(
            duration_s=bounds.duration_s - 5.0 - APPROACHES_S,
            high_percent=bounds.strain_max_percent,
            frequencies_hz=tuple(frequencies.tolist()),
            amplitudes=tuple(np.sqrt(frequencies[0] / frequencies).tolist()),
        ),
    ]


def _mix(bounds: Bounds) -> list[Piece]:
    """A third of noise, a third of steps with holds, a third of returns to zero."""
    third = replace(bounds, duration_s=bounds.duration_s / 3)
    return [*_noise(third), *_staircase(third), *_return_to_zero(third)]


MENU: dict[str, Callable[[Bounds], list[Piece]]] = {
    NOISE: _noise,
    "fast-noise": _fast_noise,
    "slow-triangle": lambda bounds: _triangles(bounds, bounds.speed(25.0)),
    "fast-triangle": lambda bounds: _triangles(bounds, bounds.fast_mm_per_s),
    "rate-sweep": _rate_sweep,
    "staircase": _staircase,
    "long-hold": _long_hold,
    "return-to-zero": _return_to_zero,
    "growing-amplitude": _growing,
    "new-heights": _new_heights,
    "bursts-and-rests": _bursts,
    "multisine": _multisine,
    "mix": _mix,
}
