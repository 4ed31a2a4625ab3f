"""The designed pieces of an experiment: hold, ramp, triangle, staircase, rate sweep, return to zero, multisine.

Pieces speak of strain (percent of the gauge length) and of speed (mm/s). They are chained with ``+``::

    Hold(duration_s=5) + Triangle(high_percent=30, speed_mm_per_s=2, cycles=3) + Noise(duration_s=600)

Each piece turns itself into a `Path`, a chain of straight segments that says where to be and how long to take; the
limits of the machine are applied later, to the whole chain at once (`gcode.motion.limits`).
"""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from gcode.motion.path import Frame, Path, join, rest, way
from gcode.trajectories.natural import Noise
from gcode.trajectories.protocol import Piece, RangedPiece
from gcode.trajectories.quantities import Count, Duration, Percent, Positive, Rest


class Hold(Piece):
    """Stand still where you are.

    Attributes
    ----------
    duration_s : float

    Examples
    --------
    >>> import gcode
    >>> gcode.generate(gcode.Ramp(to_percent=10, speed_mm_per_s=1) + gcode.Hold(duration_s=5), seed=0)
    <Made trajectory, seed 0: 10.2 s, 0 to 2.5 mm>
    """

    kind: Literal["hold"] = "hold"
    duration_s: Duration

    def path(self, start_mm: float, frame: Frame) -> Path:
        return Path(np.full(2, start_mm), np.array([self.duration_s]))


class Ramp(Piece):
    """Move to a strain at a constant speed.

    Attributes
    ----------
    to_percent : float
        Where to, as a strain.
    speed_mm_per_s : float

    Examples
    --------
    >>> import gcode
    >>> round(gcode.generate(gcode.Ramp(to_percent=20, speed_mm_per_s=2), seed=0).statistics.x_max_mm, 2)
    5.0
    """

    kind: Literal["ramp"] = "ramp"
    to_percent: Percent
    speed_mm_per_s: Positive

    def path(self, start_mm: float, frame: Frame) -> Path:
        return way([start_mm, frame.mm(self.to_percent)], self.speed_mm_per_s)


class ReturnToZero(Piece):
    """Move back to zero strain and rest there.

    Attributes
    ----------
    speed_mm_per_s : float
    rest_s : float
        How long it rests there.

    Examples
    --------
    >>> import gcode
    >>> there_and_back = gcode.Ramp(to_percent=20, speed_mm_per_s=2) + gcode.ReturnToZero(speed_mm_per_s=2)
    >>> gcode.generate(there_and_back, seed=0).trajectory.position_mm[-1].item()
    0.0
    """

    kind: Literal["return_to_zero"] = "return_to_zero"
    speed_mm_per_s: Positive = 1.0
    rest_s: Rest = 0.0

    def path(self, start_mm: float, frame: Frame) -> Path:
        return way([start_mm, frame.mm(0.0)], self.speed_mm_per_s, self.rest_s)


class Triangle(RangedPiece):
    """Go up and down between two strains at a constant speed, with a rest at the lower one if wanted.

    Attributes
    ----------
    low_percent, high_percent : float
        Strains between which it moves.
    speed_mm_per_s : float
    cycles : int
    rest_s : float
        After each cycle.

    Examples
    --------
    >>> import gcode
    >>> triangles = gcode.Triangle(high_percent=20, speed_mm_per_s=1, cycles=3)
    >>> round(gcode.generate(triangles, seed=0).statistics.v_max_mm_per_s, 2)
    1.0
    """

    kind: Literal["triangle"] = "triangle"
    speed_mm_per_s: Positive
    cycles: Count = 1
    rest_s: Rest = 0.0

    @property
    def strokes(self) -> int:
        return 3 * self.cycles

    def path(self, start_mm: float, frame: Frame) -> Path:
        low, high = frame.mm(self.low_percent), frame.mm(self.high_percent)
        cycle = join(way([low, high, low], self.speed_mm_per_s), rest(low, self.rest_s))
        return join(*[cycle] * self.cycles)


class Staircase(Piece):
    """Go to one strain after the other and hold each.

    Attributes
    ----------
    levels_percent : tuple of float
        The strains, in order.
    speed_mm_per_s : float
        From one to the next.
    hold_s : float
        At each.

    Examples
    --------
    >>> import gcode
    >>> stairs = gcode.Staircase(levels_percent=(10, 20, 10), speed_mm_per_s=2, hold_s=10)
    >>> gcode.generate(stairs, seed=0).trajectory.duration_s > 30
    True
    """

    kind: Literal["staircase"] = "staircase"
    levels_percent: tuple[Percent, ...] = Field(min_length=1)
    speed_mm_per_s: Positive
    hold_s: Duration

    @property
    def strokes(self) -> int:
        return 2 * len(self.levels_percent)

    def path(self, start_mm: float, frame: Frame) -> Path:
        stops = [start_mm, *(float(frame.mm(level)) for level in self.levels_percent)]
        steps = [way(stops[i : i + 2], self.speed_mm_per_s, self.hold_s) for i in range(len(stops) - 1)]
        return join(*steps)


class RateSweep(RangedPiece):
    """The same triangle at one speed after the other.

    Attributes
    ----------
    low_percent, high_percent : float
        Strains between which it moves.
    speeds_mm_per_s : tuple of float
    cycles : int
        At each speed.
    rest_s : float
        After each cycle.

    Examples
    --------
    >>> import gcode
    >>> sweep = gcode.RateSweep(high_percent=20, speeds_mm_per_s=(0.5, 1, 2))
    >>> round(gcode.generate(sweep, seed=0).statistics.v_max_mm_per_s, 2)
    2.0
    """

    kind: Literal["rate_sweep"] = "rate_sweep"
    speeds_mm_per_s: tuple[Positive, ...] = Field(min_length=1)
    cycles: Count = 1
    rest_s: Rest = 0.0

    @property
    def strokes(self) -> int:
        return 3 * self.cycles * len(self.speeds_mm_per_s)

    def path(self, start_mm: float, frame: Frame) -> Path:
        shared = {"low_percent": self.low_percent, "high_percent": self.high_percent, "rest_s": self.rest_s}
        triangles = [Triangle(speed_mm_per_s=v, cycles=self.cycles, **shared) for v in self.speeds_mm_per_s]
        return join(*(triangle.path(start_mm, frame) for triangle in triangles))


class Multisine(RangedPiece):
    """A sum of sines that fills the range, with phases drawn from the seed.

    Attributes
    ----------
    low_percent, high_percent : float
        Strains between which it moves.
    duration_s : float
    frequencies_hz : tuple of float
    amplitudes : tuple of float, optional
        Relative to each other, one a frequency; default: all alike.

    Examples
    --------
    >>> import gcode
    >>> wave = gcode.Multisine(high_percent=10, duration_s=30, frequencies_hz=(0.05, 0.11))
    >>> gcode.generate(wave, seed=1).statistics.x_max_mm <= 2.5
    True
    """

    kind: Literal["multisine"] = "multisine"
    duration_s: Duration
    frequencies_hz: tuple[Positive, ...] = Field(min_length=1, max_length=100)
    amplitudes: tuple[Positive, ...] | None = None

    @model_validator(mode="after")
    def _matched(self) -> Multisine:
        if self.amplitudes is not None and len(self.amplitudes) != len(self.frequencies_hz):
            raise ValueError(
                f"amplitudes must be as many as frequencies_hz ({len(self.frequencies_hz)}), "
                f"got {len(self.amplitudes)}"
            )
        return self

    def path(self, start_mm: float, frame: Frame) -> Path:
        steps = int(np.ceil(self.duration_s * frame.rate_hz - 1e-9))
        time_s = np.arange(steps + 1) / frame.rate_hz
        phases = np.random.default_rng(frame.seed).uniform(0, 2 * np.pi, len(self.frequencies_hz))
        amplitudes = self.amplitudes or (1.0,) * len(phases)
        waves = zip(amplitudes, self.frequencies_hz, phases, strict=True)
        signal = sum((a * np.sin(2 * np.pi * f * time_s + phase) for a, f, phase in waves), np.zeros(steps + 1))
        lowest, highest = float(signal.min()), float(signal.max())
        level = (signal - lowest) / max(highest - lowest, 1e-12)
        position = frame.mm(self.low_percent + (self.high_percent - self.low_percent) * level)
        return Path(position, np.full(steps, 1.0 / frame.rate_hz))


AnyPiece = Annotated[
    Noise | Hold | Ramp | ReturnToZero | Triangle | Staircase | RateSweep | Multisine, Field(discriminator="kind")
]
