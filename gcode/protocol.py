"""The pieces of a designed experiment: noise, hold, ramp, triangle, staircase, rate sweep, return to zero, multisine.

Pieces speak of strain (percent of the gauge length) and of speed (mm/s). They are chained with ``+``::

    Hold(duration_s=5) + Triangle(high_percent=30, speed_mm_per_s=2, cycles=3) + Noise(duration_s=600)

Each piece turns itself into a `Path`, a chain of straight segments that says where to be and how long to take; the
limits of the machine are applied later, to the whole chain at once (`gcode.limits`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator

from gcode.perlin import MAX_OCTAVES, perlin_signal

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
Duration = Annotated[float, Field(gt=0, le=48 * 3600, allow_inf_nan=False)]
Percent = Annotated[float, Field(ge=-100, le=1000, allow_inf_nan=False)]
Count = Annotated[int, Field(ge=1, le=100_000)]
SOFT_FROM = 0.9  # noise beyond this part of the half range is bent smoothly, so that it never passes the end


@dataclass(frozen=True)
class Frame:
    """What a piece must know to become millimetres.

    `offset_mm` is the pre-tension offset: the machine position of zero strain. `seed` is for this piece alone.
    """

    gauge_length_mm: float
    offset_mm: float
    rate_hz: float
    seed: Any

    def mm(self, strain_percent: Any) -> Any:
        """Machine position (mm) of a strain in percent."""
        return self.offset_mm + np.multiply(strain_percent, self.gauge_length_mm / 100.0)


class Path(NamedTuple):
    """n + 1 positions and the n durations between them. Equal positions in a row mean standing still."""

    position_mm: np.ndarray
    duration_s: np.ndarray


class Piece(BaseModel):
    """One piece of a protocol. Subclasses say where to be and when, from the position they are entered at."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    def path(self, start_mm: float, frame: Frame) -> Path:
        """The piece's path; its first position may differ from `start_mm`, then an approach is put before it."""
        raise NotImplementedError

    def __add__(self, other: Piece | Protocol) -> Protocol:
        return Protocol(pieces=(self,)) + other


class _Ranged(Piece):
    low_percent: Percent = 0.0
    high_percent: Percent = 30.0

    @model_validator(mode="after")
    def _ordered(self) -> Any:
        if not self.low_percent < self.high_percent:
            raise ValueError(
                f"low_percent must be below high_percent, got {self.low_percent:g} and {self.high_percent:g}"
            )
        return self


class Noise(_Ranged):
    """Pseudo-natural motion: Perlin noise over a strain range.

    `peak` is the noise level that reaches the ends of the range (a smaller one moves more). `min_speed_mm_per_s` is
    the least feed of a point-to-point move: where the noise is slower the points are reached early, which turns
    the soft reversals of the noise into the brisk ones of the paper's trajectories.
    """

    kind: Literal["noise"] = "noise"
    duration_s: Duration = 1380.0
    cells_per_s: Positive = 0.32
    octaves: int = Field(2, ge=1, le=MAX_OCTAVES)
    persistence: float = Field(0.15, gt=0, le=1)
    peak: float = Field(0.7, ge=0.1, le=2.0)
    min_speed_mm_per_s: float = Field(0.0, ge=0, allow_inf_nan=False)

    def path(self, start_mm: float, frame: Frame) -> Path:
        # The minimum speed shortens the run, so the source is longer than asked for and cut to length.
        source_s, path = self.duration_s, None
        while path is None or path.duration_s.sum() < self.duration_s:
            source_s *= 1.15
            path = self._whole(source_s, frame)
        keep = int(np.searchsorted(np.cumsum(path.duration_s), self.duration_s - 1e-9)) + 1
        return Path(path.position_mm[: keep + 1], path.duration_s[:keep])

    def _whole(self, source_s: float, frame: Frame) -> Path:
        time_s = np.arange(int(np.ceil(source_s * frame.rate_hz)) + 1) / frame.rate_hz
        signal = perlin_signal(time_s, frame.seed, self.cells_per_s, self.octaves, self.persistence)
        middle = (self.low_percent + self.high_percent) / 2
        half = (self.high_percent - self.low_percent) / 2
        position = frame.mm(middle + half * bend(signal / self.peak))
        step = np.abs(np.diff(position))
        duration = np.full(len(step), 1.0 / frame.rate_hz)
        if self.min_speed_mm_per_s > 0:
            duration = np.minimum(duration, step / self.min_speed_mm_per_s)
        return Path(position, duration)


def bend(level: np.ndarray) -> np.ndarray:
    """Keep a level within -1 to 1: unchanged up to SOFT_FROM, then smoothly (C2) towards the end."""
    size, room = np.abs(level), 1.0 - SOFT_FROM
    beyond = SOFT_FROM + room * np.tanh(np.maximum(size - SOFT_FROM, 0.0) / room)
    return np.sign(level) * np.minimum(size, beyond)


class Hold(Piece):
    """Stand still where you are."""

    kind: Literal["hold"] = "hold"
    duration_s: Duration

    def path(self, start_mm: float, frame: Frame) -> Path:
        return Path(np.full(2, start_mm), np.array([self.duration_s]))


class Ramp(Piece):
    """Move to a strain at a constant speed."""

    kind: Literal["ramp"] = "ramp"
    to_percent: Percent
    speed_mm_per_s: Positive

    def path(self, start_mm: float, frame: Frame) -> Path:
        return way([start_mm, frame.mm(self.to_percent)], self.speed_mm_per_s)


class ReturnToZero(Piece):
    """Move back to zero strain and rest there."""

    kind: Literal["return_to_zero"] = "return_to_zero"
    speed_mm_per_s: Positive = 1.0
    rest_s: float = Field(0.0, ge=0, le=48 * 3600)

    def path(self, start_mm: float, frame: Frame) -> Path:
        return way([start_mm, frame.mm(0.0)], self.speed_mm_per_s, self.rest_s)


class Triangle(_Ranged):
    """Go up and down between two strains at a constant speed, with rests at zero strain's end if wanted."""

    kind: Literal["triangle"] = "triangle"
    speed_mm_per_s: Positive
    cycles: Count = 1
    rest_s: float = Field(0.0, ge=0, le=48 * 3600)

    def path(self, start_mm: float, frame: Frame) -> Path:
        low, high = frame.mm(self.low_percent), frame.mm(self.high_percent)
        cycle = join(way([low, high, low], self.speed_mm_per_s), _rest(low, self.rest_s))
        return join(*[cycle] * self.cycles)


class Staircase(Piece):
    """Go to one strain after the other and hold each."""

    kind: Literal["staircase"] = "staircase"
    levels_percent: tuple[Percent, ...] = Field(min_length=1)
    speed_mm_per_s: Positive
    hold_s: Duration

    def path(self, start_mm: float, frame: Frame) -> Path:
        stops = [start_mm, *(float(frame.mm(level)) for level in self.levels_percent)]
        steps = [way(stops[i : i + 2], self.speed_mm_per_s, self.hold_s) for i in range(len(stops) - 1)]
        return join(*steps)


class RateSweep(_Ranged):
    """The same triangle at one speed after the other."""

    kind: Literal["rate_sweep"] = "rate_sweep"
    speeds_mm_per_s: tuple[Positive, ...] = Field(min_length=1)
    cycles: Count = 1
    rest_s: float = Field(0.0, ge=0, le=48 * 3600)

    def path(self, start_mm: float, frame: Frame) -> Path:
        shared = {"low_percent": self.low_percent, "high_percent": self.high_percent, "rest_s": self.rest_s}
        triangles = [Triangle(speed_mm_per_s=v, cycles=self.cycles, **shared) for v in self.speeds_mm_per_s]
        return join(*(triangle.path(start_mm, frame) for triangle in triangles))


class Multisine(_Ranged):
    """A sum of sines that fills the range, with phases drawn from the seed."""

    kind: Literal["multisine"] = "multisine"
    duration_s: Duration
    frequencies_hz: tuple[Positive, ...] = Field(min_length=1)
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


def way(stops_mm: list[float], speed_mm_per_s: float, rest_s: float = 0.0) -> Path:
    """Straight moves through `stops_mm` at one speed, then a rest; moves of no length are left out."""
    stops = np.array(stops_mm, dtype=float)
    stops = stops[np.concatenate(([True], np.abs(np.diff(stops)) > 1e-9))]
    moves = Path(stops, np.abs(np.diff(stops)) / speed_mm_per_s)
    return join(moves, _rest(stops[-1], rest_s))


def _rest(at_mm: float, rest_s: float) -> Path:
    return Path(np.full(2, at_mm), np.array([rest_s])) if rest_s > 0 else Path(np.array([at_mm]), np.zeros(0))


def join(*paths: Path) -> Path:
    """Chain paths whose ends meet."""
    positions = [paths[0].position_mm, *(path.position_mm[1:] for path in paths[1:])]
    return Path(np.concatenate(positions), np.concatenate([path.duration_s for path in paths]))


AnyPiece = Annotated[
    Noise | Hold | Ramp | ReturnToZero | Triangle | Staircase | RateSweep | Multisine, Field(discriminator="kind")
]


class Protocol(BaseModel):
    """Pieces in a row."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    pieces: tuple[AnyPiece, ...] = Field(min_length=1)

    def __add__(self, other: Piece | Protocol) -> Protocol:
        more = other.pieces if isinstance(other, Protocol) else (other,)
        return Protocol(pieces=(*self.pieces, *more))
