"""How strong an effect is: what the sensor's own base laws cannot absorb of it, in noise floors.

The base is linearised around the drawn sensor (finite differences of every parameter), with a static shape over
strain and one over elapsed time for each channel. The strength is the root mean square of what is left of the
effect's change after a least-squares fit of all of these, over all samples of the recorded channels.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from worlds_second.kernels import Array

STEP = 1e-3
SHAPE_DEGREE = 3
ONSET_S = 10.0
CLOSE = 0.03  # the search ends within this share of the strength asked for
TRIALS = 30
START = 1e-2  # of the largest magnitude
LARGEST_STEP = 1.8  # upwards, while all was too weak
DEEPEST_STEP = 250.0  # downwards, while all was too strong
CONDITION = 1e-9  # of the largest eigenvalue; what lies below is a copy of other columns

Channels = Mapping[str, Array]


@dataclass(frozen=True)
class Absorber:
    """The base's linear span over the recorded channels, in noise floors."""

    basis: Array
    floors: Mapping[str, float]

    def left(self, change: Channels) -> dict[str, float]:
        """Root mean square in floors of what remains of a change, by channel and (``both``) over all samples."""
        parts = [np.asarray(change[name]) / floor for name, floor in self.floors.items()]
        stacked = np.concatenate(parts)
        rest = stacked - self.basis @ (self.basis.T @ stacked)
        split = np.split(rest, np.cumsum([len(part) for part in parts])[:-1])
        out = {name: float(np.sqrt(np.mean(part**2))) for name, part in zip(self.floors, split, strict=True)}
        return {**out, "both": float(np.sqrt(np.mean(rest**2)))}


def make_absorber(
    base: Channels, moved: list[tuple[Channels, float]], x: Array, time_s: Array, floors: Mapping[str, float]
) -> Absorber:
    """The absorber of a sensor from its own run and from the runs with one parameter moved."""
    columns = [
        np.concatenate([(run[name] - base[name]) / step / floor for name, floor in floors.items()])
        for run, step in moved
    ]
    late = np.log1p(time_s / ONSET_S)
    shapes = [x**k for k in range(SHAPE_DEGREE + 1)] + [(late / late[-1]) ** k for k in range(1, SHAPE_DEGREE + 1)]
    count = len(x)
    for index in range(len(floors)):
        for shape in shapes:
            column = np.zeros(count * len(floors))
            column[index * count : (index + 1) * count] = shape
            columns.append(column)
    return Absorber(_span(np.stack(columns, axis=1)), floors)


def _span(columns: Array) -> Array:
    """Orthonormal basis of what the columns span, without those that say nothing of their own."""
    size = np.linalg.norm(columns, axis=0)
    scaled = columns[:, size > 0] / size[size > 0]
    values, vectors = np.linalg.eigh(scaled.T @ scaled)
    keep = values > CONDITION * values[-1]
    return np.asarray(scaled @ (vectors[:, keep] / np.sqrt(values[keep])))


def reach(strength: float, largest: float, left: Callable[[float], float]) -> float:
    """The smallest magnitude found whose strength is the one asked for, or the nearest tried up to `largest`.

    It climbs by at most `LARGEST_STEP` at a time: past some magnitude a few effects grow weaker again (a read-out
    that is clipped everywhere is as smooth as any).
    """
    low, high = 0.0, np.inf
    magnitude = largest * START
    best, best_off = magnitude, np.inf
    for _ in range(TRIALS):
        got = max(left(magnitude), 1e-12)
        off = abs(np.log(got / strength))
        if off < best_off:
            best, best_off = magnitude, off
        if off < CLOSE or (magnitude >= largest and got < strength):
            break
        low, high = (magnitude, high) if got < strength else (low, magnitude)
        magnitude = _next(magnitude * strength / got, low, min(high, largest), found=bool(np.isfinite(high)))
    return best


def _next(guess: float, low: float, high: float, *, found: bool) -> float:
    """The next magnitude to try, given a guess and the limits known so far."""
    if not found:
        return min(guess, LARGEST_STEP * low, high)
    if low == 0.0:
        return max(guess, high / DEEPEST_STEP)
    return guess if low < guess < high else float(np.sqrt(low * high))
