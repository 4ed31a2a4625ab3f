"""Motions put together freely: holds, rests, cycles, steps, sweeps, waves and random motion, of any size and speed.

A motion is a row of genes. A gene is a kind of piece, its share of the time, and three numbers from 0 to 1 for its
levels and speed within the bounds, so that every row is a motion that keeps them, and near rows are near motions.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from gcode.support.errors import UserError
from gcode.trajectories.designed import Hold, Multisine, Ramp, RateSweep, ReturnToZero, Staircase, Triangle
from gcode.trajectories.natural import Noise
from gcode.trajectories.planning import plan
from gcode.trajectories.protocol import Piece
from gcode.trajectories.trajectory import Trajectory, TrajectorySpec
from testbench.design.protocols import Bounds, spec_of

FEWEST, MOST = 2, 7  # genes of a motion
SLOWEST_STROKE_S = 60.0
LEAST_LEVEL = 0.1  # of the largest strain
ROOM = 0.97  # of the time: corners take some
SHRINKS = 4  # trials to fit a motion into its time
STEP = 0.25  # of a gene's numbers, in a variation

Numbers = tuple[float, ...]  # three


@dataclass(frozen=True)
class Gene:
    """One kind of piece: its share of the time (before all are scaled to one), and the numbers that shape it."""

    kind: str
    share: float
    numbers: Numbers


Genes = tuple[Gene, ...]
# For a sensor of which nothing is known yet: what relaxes, what rests, what is quick and what comes again.
SURVEY: Genes = (
    Gene("perlin", 1.0, (1.0, 0.5, 0.3)),
    Gene("hold", 0.5, (1.0, 1.0, 0.0)),
    Gene("rest", 0.5, (0.0, 1.0, 0.0)),
    Gene("cycles", 0.4, (0.4, 1.0, 0.0)),
    Gene("perlin", 0.6, (1.0, 1.0, 0.3)),
)


@dataclass(frozen=True, eq=False)
class Motion:
    """A motion that can be driven.

    Attributes
    ----------
    genes : tuple of Gene
        Empty for a named protocol.
    trajectory : Trajectory
        As planned.
    """

    genes: Genes
    spec: TrajectorySpec
    trajectory: Trajectory


def drawn(rng: np.random.Generator) -> Genes:
    """A random row of genes."""
    return tuple(_gene(rng) for _ in range(int(rng.integers(FEWEST, MOST + 1))))


def varied(genes: Genes, rng: np.random.Generator) -> Genes:
    """A neighbour: one gene changed, exchanged, moved, added or taken out."""
    row = list(genes)
    where = int(rng.integers(len(row)))
    change = rng.choice(["shape", "share", "kind", "move", "more", "less"])
    if change == "more" and len(row) < MOST:
        row.insert(where, _gene(rng))
    elif change == "less" and len(row) > 1:
        row.pop(where)
    elif change == "move":
        row.insert(int(rng.integers(len(row))), row.pop(where))
    elif change == "share":
        row[where] = replace(row[where], share=float(row[where].share * np.exp(rng.normal(0, 0.7))))
    elif change == "kind":
        row[where] = replace(row[where], kind=str(rng.choice(list(KINDS))))
    else:
        numbers = np.clip(np.array(row[where].numbers) + rng.normal(0, STEP, 3), 0, 1)
        row[where] = replace(row[where], numbers=tuple(numbers.tolist()))
    return tuple(row)


def motion_of(genes: Genes, bounds: Bounds, seed: int) -> Motion | None:
    """The motion of a row of genes, made to last `bounds.duration_s` at most; None where it cannot be driven so."""
    budget_s = ROOM * bounds.duration_s
    for _ in range(SHRINKS):
        spec = spec_of("designed", pieces_of(genes, bounds, budget_s), bounds)
        try:
            trajectory = plan(spec, seed, bounds.gauge_length_mm)
        except UserError:
            return None
        if trajectory.duration_s <= bounds.duration_s:
            return Motion(genes, spec, trajectory)
        budget_s *= 0.98 * bounds.duration_s / trajectory.duration_s
    return None


def pieces_of(genes: Genes, bounds: Bounds, seconds: float) -> list[Piece]:
    """The pieces that a row of genes stands for, stretched to about this duration."""
    total = sum(gene.share for gene in genes)
    return [piece for gene in genes for piece in KINDS[gene.kind](gene.numbers, seconds * gene.share / total, bounds)]


def in_words(spec: TrajectorySpec) -> str:
    """The motion in words, piece by piece."""
    return ", ".join(_told(piece) for piece in spec.pieces)


def _gene(rng: np.random.Generator) -> Gene:
    numbers = tuple(rng.uniform(0, 1, 3).tolist())
    return Gene(str(rng.choice(list(KINDS))), float(rng.uniform(0.3, 1.5)), numbers)


Make = Callable[[Numbers, float, Bounds], Sequence[Piece]]


def _level(number: float, bounds: Bounds) -> float:
    """A number from 0 to 1 as a strain in percent; its last fifth or so is all the largest strain."""
    return round(bounds.strain_max_percent * float(np.clip(LEAST_LEVEL + 1.125 * number, LEAST_LEVEL, 1.0)), 3)


def _speed(number: float, bounds: Bounds) -> float:
    slow, fast = bounds.speed(SLOWEST_STROKE_S), bounds.fast_mm_per_s
    return float(f"{slow * (fast / slow) ** number:.3g}") if fast > slow else fast


def _mm(percent: float, bounds: Bounds) -> float:
    return percent * bounds.gauge_length_mm / 100


def _hold(numbers: Numbers, seconds: float, bounds: Bounds) -> Sequence[Piece]:
    level, speed = _level(numbers[0], bounds), _speed(numbers[1], bounds)
    rest_s = max(seconds - 0.5 * _mm(level, bounds) / speed, 1.0)
    return [Ramp(to_percent=level, speed_mm_per_s=speed), Hold(duration_s=round(rest_s, 2))]


def _rest(numbers: Numbers, seconds: float, bounds: Bounds) -> Sequence[Piece]:
    speed = _speed(numbers[1], bounds)
    rest_s = max(seconds - 0.5 * bounds.stroke_mm / speed, 1.0)
    return [ReturnToZero(speed_mm_per_s=speed, rest_s=round(rest_s, 2))]


def _cycles(numbers: Numbers, seconds: float, bounds: Bounds) -> Sequence[Piece]:
    high, speed = _level(numbers[0], bounds), _speed(numbers[1], bounds)
    low = round(0.8 * high * max(numbers[2] - 0.5, 0.0) * 2, 3)  # half of all go back to zero
    cycles = max(int(seconds / (2 * _mm(high - low, bounds) / speed)), 1)
    return [Triangle(low_percent=low, high_percent=high, speed_mm_per_s=speed, cycles=min(cycles, 10_000))]


def _steps(numbers: Numbers, seconds: float, bounds: Bounds) -> Sequence[Piece]:
    """Up or down in steps, each held."""
    top, speed, count = _level(numbers[0], bounds), _speed(0.5 + 0.5 * numbers[1], bounds), 2 + int(4 * numbers[2])
    hold_s = max((seconds - _mm(top, bounds) / speed) / count, 1.0)
    levels = np.linspace(top / count, top, count)
    levels = levels if numbers[1] < 0.5 else levels[::-1]
    return [Staircase(levels_percent=tuple(levels.round(3).tolist()), speed_mm_per_s=speed, hold_s=round(hold_s, 2))]


def _sweep(numbers: Numbers, seconds: float, bounds: Bounds) -> Sequence[Piece]:
    """Triangles of one height, at three speeds."""
    high, fast = _level(numbers[0], bounds), _speed(1.0, bounds)
    slowest = max(0.7 * 2 * _mm(high, bounds) / seconds, _speed(numbers[1], bounds))
    speeds = tuple(float(f"{v:.3g}") for v in np.geomspace(min(slowest, fast), fast, 3))
    takes_s = sum(2 * _mm(high, bounds) / v for v in speeds)
    return [RateSweep(high_percent=high, speeds_mm_per_s=speeds, cycles=max(int(seconds / takes_s), 1))]


def _waves(numbers: Numbers, seconds: float, bounds: Bounds) -> Sequence[Piece]:
    high = _level(numbers[0], bounds)
    top_hz = min(_speed(numbers[1], bounds) / (np.pi * max(_mm(high, bounds), 1e-9)), 2.0)
    waves_hz = np.geomspace(max(top_hz / 10, 1 / max(seconds, 1.0)), max(top_hz, 2 / max(seconds, 1.0)), 4)
    amplitudes = np.sqrt(waves_hz[0] / waves_hz)
    return [
        Multisine(
            duration_s=round(max(seconds, 1.0), 2),
            high_percent=high,
            frequencies_hz=tuple(waves_hz.tolist()),
            amplitudes=tuple(amplitudes.tolist()),
        )
    ]


def _perlin(numbers: Numbers, seconds: float, bounds: Bounds) -> Sequence[Piece]:
    high = _level(numbers[0], bounds)
    pace = 0.5 * _speed(0.5 + 0.5 * numbers[1], bounds) / max(_mm(high, bounds), 1e-9)
    return [
        Noise(
            duration_s=round(max(seconds, 1.0), 2),
            high_percent=high,
            octaves=2,
            persistence=round(0.1 + 0.3 * numbers[2], 3),
            cells_per_s=float(f"{np.clip(pace, 0.02, 2.0):.3g}"),
            peak=0.7,
        )
    ]


KINDS: dict[str, Make] = {
    "hold": _hold,
    "rest": _rest,
    "cycles": _cycles,
    "steps": _steps,
    "sweep": _sweep,
    "waves": _waves,
    "perlin": _perlin,
}


def _told(piece: Piece) -> str:
    if isinstance(piece, Hold):
        return f"hold {piece.duration_s:.0f} s"
    if isinstance(piece, Ramp):
        return f"to {piece.to_percent:.0f} % at {piece.speed_mm_per_s:.2g} mm/s"
    if isinstance(piece, ReturnToZero):
        return f"back to zero at {piece.speed_mm_per_s:.2g} mm/s, rest {piece.rest_s:.0f} s"
    if isinstance(piece, Triangle):
        span = f"{piece.low_percent:.0f} to {piece.high_percent:.0f} %"
        return f"{piece.cycles} triangles {span} at {piece.speed_mm_per_s:.2g} mm/s"
    if isinstance(piece, Staircase):
        levels = " ".join(f"{level:.0f}" for level in piece.levels_percent)
        return f"steps {levels} %, each {piece.hold_s:.0f} s"
    if isinstance(piece, RateSweep):
        speeds = " ".join(f"{v:.2g}" for v in piece.speeds_mm_per_s)
        return f"{piece.cycles} triangles to {piece.high_percent:.0f} % at each of {speeds} mm/s"
    assert isinstance(piece, (Multisine, Noise)), piece
    return f"{piece.kind} {piece.duration_s:.0f} s to {piece.high_percent:.0f} %"
