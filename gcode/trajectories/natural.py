"""Noise: the pseudo-natural piece, Perlin noise shaped to speeds and accelerations that were asked for."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, model_validator

from gcode.motion.limits import drive_within
from gcode.motion.path import Frame, Path
from gcode.motion.perlin import MAX_OCTAVES, perlin_walk
from gcode.motion.statistics import MotionStatistics, motion_statistics
from gcode.support.errors import UserError
from gcode.trajectories.protocol import RangedPiece
from gcode.trajectories.quantities import MAX_SAMPLES, Duration, Positive, SpecModel

NAMES = ("v_mean_mm_per_s", "v_sd_mm_per_s", "a_mean_mm_per_s2", "a_sd_mm_per_s2")
OCTAVE_SD = 0.242  # standard deviation of one octave of noise, mean of 40 runs of 23 min
OCTAVE_PEAK = 0.78  # what one octave reaches in about 23 min
SOFT_FROM = 0.9  # noise beyond this part of the half range is bent smoothly, so that it never passes the end
PACE_RATIO = 0.2  # the pace changes this much slower than the noise itself
SPRINT_HALF_WIDTH_S = 2.0
TELLING_SAMPLES = 100_000  # of noise say how much of it a run will need; a few seconds may be at rest by chance
LONGEST_SOURCE = 20.0  # times the duration: noise so much slower than its least speed is no longer noise
TOO_FAR = 0.25  # a target missed by more than this cannot be met
_CLOSE = np.array([0.004, 0.02, 0.004, 0.02])
_TRIES = 8
# How the logarithms of the four statistics answer to log(cells_per_s), log(peak), log(min_speed) and pace_spread,
# measured as means over eight seeds between the presets paper-1 and fast; good enough to steer by.
_SENSITIVITY = np.array(
    [[0.89, -0.92, 0.06, 0.0], [1.02, -1.03, -0.03, 0.08], [1.88, -0.92, 0.06, 0.06], [1.37, -0.66, 0.3, 0.25]]
)
# The last two parameters act weakly; damping keeps them near what the spec says.
_DAMPING = np.diag([0.0, 0.0, 0.03, 0.02])


class Target(SpecModel):
    """Means and standard deviations of |v| and |a|, by finite differences at `rate_hz`."""

    v_mean_mm_per_s: Positive
    v_sd_mm_per_s: Positive
    a_mean_mm_per_s2: Positive
    a_sd_mm_per_s2: Positive
    rate_hz: Annotated[float, Field(ge=1, le=1000)] = 20.0

    def deviations(self, statistics: MotionStatistics) -> np.ndarray:
        """Relative deviations, in the order of `NAMES`."""
        return np.array([getattr(statistics, name) / getattr(self, name) - 1.0 for name in NAMES])


class Noise(RangedPiece):
    """Pseudo-natural motion: Perlin noise (Perlin, Computer Graphics 19 (1985) 287) over a strain range.

    Attributes
    ----------
    low_percent, high_percent : float
        Strains between which it moves.
    duration_s : float
        Executed duration, the approach not counted.
    cells_per_s : float
        Noise cells per second of the slowest octave: how often the direction changes.
    octaves : int
        How many noises are added, each twice as quick as the one before.
    persistence : float
        Amplitude of each relative to the one before.
    peak : float or None
        Noise level at the ends of the strain range; a smaller one uses the range more. None: what 23 min reach.
    min_speed_mm_per_s : float
        Least feed between two points, as in the paper's point-to-point programs: where the noise is slower the next
        point is reached early. It turns the soft reversals of the noise into brisk ones.
    pace_spread : float
        How much the pace comes and goes (log-normal, in units of the noise); widens the spread of the speeds.
    target : Target or None
        If given, the shape is adjusted for each seed until the executed motion has these statistics.
    sprint_mm_per_s : float or None
        If given, the fastest stroke of the run is brought up to this speed.

    Examples
    --------
    >>> import gcode
    >>> gcode.generate(gcode.Noise(duration_s=60, high_percent=20), seed=1).statistics.x_max_mm <= 5.0
    True
    """

    kind: Literal["noise"] = "noise"
    duration_s: Duration = 1380.0
    cells_per_s: Positive = 0.32
    octaves: int = Field(default=2, ge=1, le=MAX_OCTAVES)
    persistence: float = Field(default=0.3, gt=0, le=1)
    peak: float | None = Field(default=None, ge=0.1, le=2.0)
    min_speed_mm_per_s: float = Field(default=0.0, ge=0, allow_inf_nan=False)
    pace_spread: float = Field(default=0.0, ge=0, le=3)
    target: Target | None = None
    sprint_mm_per_s: Positive | None = None

    @model_validator(mode="after")
    def _consistent(self) -> Any:
        if self.target is not None and self.min_speed_mm_per_s >= self.target.v_mean_mm_per_s:
            raise ValueError(
                f"min_speed_mm_per_s must be below the target's v_mean_mm_per_s ({self.target.v_mean_mm_per_s:g}), "
                f"got {self.min_speed_mm_per_s:g}"
            )
        return self

    @property
    def level_at_end(self) -> float:
        """The noise level that is mapped to the ends of the range."""
        if self.peak is not None:
            return self.peak
        amplitudes = self.persistence ** np.arange(self.octaves)
        return float(OCTAVE_PEAK * np.sqrt((amplitudes**2).sum()) / amplitudes.sum())

    def path(self, start_mm: float, frame: Frame) -> Path:
        """The path that takes `duration_s` once the limits are applied.

        Raises
        ------
        UserError
            If no motion within the limits and this strain range is as fast as asked, or the pace is too high for the
            sample rate.
        """
        self.check_room(frame)
        shape = self if self.target is None else tuned(self, self.target, frame)
        return shape.executed_path(frame)

    def check_room(self, frame: Frame) -> None:
        """Refuse speeds that the strain range has no room for.

        No motion to and fro over a range L at no more than `a_max` has a mean speed above sqrt(a_max L) / 2.
        """
        range_mm = float(frame.mm(self.high_percent) - frame.mm(self.low_percent))
        fastest = min(0.5 * np.sqrt(frame.a_max_mm_per_s2 * range_mm), frame.v_max_mm_per_s)
        if self.target is not None and (1.0 - TOO_FAR) * self.target.v_mean_mm_per_s > fastest:
            raise UserError(
                f"noise: the target cannot be reached: a mean speed of {self.target.v_mean_mm_per_s:g} mm/s over "
                f"{range_mm:.3g} mm, where v max {frame.v_max_mm_per_s:.4g} mm/s and a max "
                f"{frame.a_max_mm_per_s2:.4g} mm/s2 allow at most {fastest:.3g} mm/s; the gauge length is "
                f"{frame.gauge_length_mm:g} mm: is it in mm?"
            )
        if self.min_speed_mm_per_s > fastest:
            raise UserError(
                f"noise: min_speed_mm_per_s: at most {fastest:.3g} mm/s over {range_mm:.3g} mm within v max "
                f"{frame.v_max_mm_per_s:.4g} mm/s and a max {frame.a_max_mm_per_s2:.4g} mm/s2, got "
                f"{self.min_speed_mm_per_s:g}"
            )

    def _check_pace(self, cells_per_s: float, frame: Frame) -> None:
        fastest = cells_per_s * 2.0 ** (self.octaves - 1)
        if fastest > frame.rate_hz / 2:
            raise UserError(
                f"noise: {fastest:.3g} cells/s are too fast for a sample rate of {frame.rate_hz:g} Hz (at most half "
                "of it); lower cells_per_s or octaves"
            )

    def executed_path(self, frame: Frame) -> Path:
        """The path with these very parameters, cut to its executed duration.

        Raises
        ------
        UserError
            If the pace is too high for the sample rate, or the noise far too slow for its least speed.
        """
        self._check_pace(self.cells_per_s, frame)
        source_s, path = 1.15 * self.duration_s, self._whole(1.15 * self.duration_s, frame)
        while (executed_s := float(path.duration_s.sum())) < self.duration_s:
            # The minimum speed shortens the run, so the source is longer than asked for.
            telling = source_s * frame.rate_hz > TELLING_SAMPLES
            needed_s = source_s * self.duration_s / max(executed_s, 1e-300) if telling else 1.15 * source_s
            self._check_source(needed_s, frame)
            source_s *= 1.15
            path = self._whole(source_s, frame)
        motion = drive_within(path, frame.v_max_mm_per_s, frame.a_max_mm_per_s2)
        segments = np.flatnonzero(path.duration_s > 0)
        kept = max(int(np.searchsorted(motion.block_end_s, self.duration_s + 1e-9)), 1)
        last = int(segments[min(kept, len(segments)) - 1]) + 1
        return Path(path.position_mm[: last + 1], path.duration_s[:last])

    def _check_source(self, needed_s: float, frame: Frame) -> None:
        """Refuse a run that needs so much noise, or more; it is always more than what was too little."""
        if needed_s > LONGEST_SOURCE * self.duration_s or needed_s * frame.rate_hz > MAX_SAMPLES:
            raise UserError(
                f"noise: at {self.cells_per_s:.3g} cells/s it is far slower than min_speed_mm_per_s = "
                f"{self.min_speed_mm_per_s:.3g}, so that {self.duration_s:g} s of motion need {needed_s:.3g} s of "
                f"noise or more (at most {LONGEST_SOURCE:g} times as long, and {MAX_SAMPLES} samples); lower "
                "min_speed_mm_per_s, or raise cells_per_s or the strain range"
            )

    def _whole(self, source_s: float, frame: Frame) -> Path:
        """The noise as a path, with points at the sample rate and the minimum speed applied."""
        time_s = np.arange(int(np.ceil(source_s * frame.rate_hz)) + 1) / frame.rate_hz
        pace = self._pace(time_s, frame) * (self.cells_per_s / frame.rate_hz)
        position = self._position(np.cumsum(pace), frame)
        if self.sprint_mm_per_s is not None:
            window = self._sprint(position, frame)
            begin = int(np.argmax(window > 1.0))
            # What lies before the sprint stays; the costly noise is walked again from there on only.
            position[begin:] = self._position(np.cumsum(pace * window)[begin:], frame)
        step = np.abs(np.diff(position))
        duration = np.full(len(step), 1.0 / frame.rate_hz)
        if self.min_speed_mm_per_s > 0:
            with np.errstate(over="ignore"):  # a tiny least speed allows any duration
                duration = np.minimum(duration, step / self.min_speed_mm_per_s)
        return Path(position, duration)

    def _position(self, cells: np.ndarray, frame: Frame) -> np.ndarray:
        level = perlin_walk(cells, frame.seed, self.octaves, self.persistence) / self.level_at_end
        middle, half = (self.low_percent + self.high_percent) / 2, (self.high_percent - self.low_percent) / 2
        return frame.mm(middle + half * bend(level))

    def _pace(self, time_s: np.ndarray, frame: Frame) -> np.ndarray:
        """How fast the noise runs at each moment, as a factor of about one on average."""
        if self.pace_spread == 0:
            return np.ones_like(time_s)
        mood = perlin_walk(time_s * (self.cells_per_s * PACE_RATIO), [*frame.seed, 1], 1, 1.0)
        return np.exp(self.pace_spread * mood - 0.5 * (self.pace_spread * OCTAVE_SD) ** 2)

    def _sprint(self, position_mm: np.ndarray, frame: Frame) -> np.ndarray:
        """A factor on the pace that lifts the fastest stroke to the sprint's speed; one everywhere else."""
        # Only what lies within the duration counts, the source is longer.
        inside = position_mm[: int(self.duration_s * frame.rate_hz)]
        speed = np.abs(np.diff(inside)) * frame.rate_hz
        at = int(speed.argmax()) if len(speed) else 0
        lift = (self.sprint_mm_per_s or 0.0) / max(float(speed[at]), 1e-9) if len(speed) else 1.0
        away = (np.arange(len(position_mm)) - at) / (frame.rate_hz * SPRINT_HALF_WIDTH_S)
        window = np.where(np.abs(away) < 1, 0.5 + 0.5 * np.cos(np.pi * away), 0.0)
        return 1.0 + (min(max(lift, 1.0), 2.5) - 1.0) * window


def bend(level: np.ndarray) -> np.ndarray:
    """Keep a level within -1 to 1: unchanged up to SOFT_FROM, then smoothly (C2) towards the end."""
    size, room = np.abs(level), 1.0 - SOFT_FROM
    beyond = SOFT_FROM + room * np.tanh(np.maximum(size - SOFT_FROM, 0.0) / room)
    return np.sign(level) * np.minimum(size, beyond)


def trial(noise: Noise, target: Target, frame: Frame) -> np.ndarray:
    """Deviations of the noise as executed within the frame's limits."""
    path = noise.executed_path(frame)
    motion = drive_within(path, frame.v_max_mm_per_s, frame.a_max_mm_per_s2)
    position = motion.position_at(np.arange(0.0, motion.end_s, 1.0 / target.rate_hz))
    return target.deviations(motion_statistics(position, target.rate_hz))


def tuned(noise: Noise, target: Target, frame: Frame) -> Noise:
    """The noise with its shape adjusted until this seed's executed motion has the target's statistics.

    Damped Gauss-Newton steps with a fixed sensitivity; the best shape seen is returned. The means are met within
    0.4 % for nearly every seed, the standard deviations as near as the seed allows.

    Raises
    ------
    UserError
        If a mean stays more than a quarter away from its target.
    """
    best, least = noise, np.inf
    step = -np.linalg.inv(_SENSITIVITY.T @ _SENSITIVITY + _DAMPING) @ _SENSITIVITY.T
    for _ in range(_TRIES):
        deviations = trial(noise, target, frame)
        worst = float((np.abs(deviations) / _CLOSE).max())
        if worst < least:
            best, least, reached = noise, worst, deviations
        if worst < 1.0:
            break
        noise = _stepped(noise, step @ np.clip(deviations, -0.5, 0.5), target)
    if np.abs(reached[[0, 2]]).max() > TOO_FAR:
        raise UserError(
            f"noise: the target cannot be reached within v max {frame.v_max_mm_per_s:g} mm/s, a max "
            f"{frame.a_max_mm_per_s2:g} mm/s2 and this strain range; the mean speed comes within {reached[0]:+.0%}, "
            f"the mean acceleration within {reached[2]:+.0%}"
        )
    return best


def _stepped(noise: Noise, change: np.ndarray, target: Target) -> Noise:
    factor = np.exp(np.clip(change, -0.7, 0.7))
    return noise.model_copy(
        update={
            "cells_per_s": float(noise.cells_per_s * factor[0]),
            "peak": float(np.clip(noise.level_at_end * factor[1], 0.1, 2.0)),
            "min_speed_mm_per_s": float(min(noise.min_speed_mm_per_s * factor[2], 0.9 * target.v_mean_mm_per_s)),
            "pace_spread": float(np.clip(noise.pace_spread + change[3], 0.0, 2.0)),
        }
    )
