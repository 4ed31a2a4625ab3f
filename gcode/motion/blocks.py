"""One-axis motion of constant-acceleration phases: the trapezoidal look-ahead rule, without loops.

Both users of this file ask the same question: how fast can a chain of straight blocks be driven, if each block
has a speed of its own and no speed change may exceed an acceleration? `gcode.motion.limits` asks it to keep a plan
within its limits, `gcode.mach4.controller` to predict what a controller does with a program.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gcode.support.errors import UserError

LOOK_AHEAD_BLOCKS = 20  # that a controller sees: Mach4's default
MOST_SAMPLES = 50_000_000  # of a motion: 400 MB a column
_AT_ONCE = 1 << 18  # phases whose speeds are compared at once: a day's program has 5 million


@dataclass(frozen=True)
class Blocks:
    """Straight moves in a row; a block of length zero is a dwell.

    Attributes
    ----------
    length_mm : array (n,)
        Signed lengths.
    speed_mm_per_s : array (n,)
        The speed asked for; ignored for dwells.
    dwell_s : array (n,)
        How long to stand still; zero for moves.
    """

    length_mm: np.ndarray
    speed_mm_per_s: np.ndarray
    dwell_s: np.ndarray


@dataclass(frozen=True)
class Motion:
    """Executed motion: phases of constant acceleration.

    Attributes
    ----------
    time_s, position_mm, velocity_mm_per_s, acceleration_mm_per_s2 : array (m,)
        State at the start of each phase.
    end_s : float
        When the last phase ends.
    block_end_s : array (n,)
        When each block ends.
    """

    time_s: np.ndarray
    position_mm: np.ndarray
    velocity_mm_per_s: np.ndarray
    acceleration_mm_per_s2: np.ndarray
    end_s: float
    block_end_s: np.ndarray

    def position_at(self, time_s: np.ndarray) -> np.ndarray:
        """Position at the given times (mm); the last position is held."""
        at = np.clip(time_s, 0.0, self.end_s)
        phase = np.clip(np.searchsorted(self.time_s, at, side="right") - 1, 0, len(self.time_s) - 1)
        since = at - self.time_s[phase]
        half = 0.5 * self.acceleration_mm_per_s2[phase] * since
        return self.position_mm[phase] + (self.velocity_mm_per_s[phase] + half) * since

    def positions(self, rate_hz: float) -> np.ndarray:
        """Positions at `rate_hz` from the start to the end (mm), two at least.

        Raises
        ------
        UserError
            If they are more than `MOST_SAMPLES`.
        """
        if not self.end_s * rate_hz <= MOST_SAMPLES:
            raise UserError(
                f"program: {self.end_s:.4g} s at {rate_hz:g} Hz are too many samples (at most {MOST_SAMPLES:.0e}); "
                "shorten it, or lower the rate"
            )
        count = max(int(np.ceil(self.end_s * rate_hz - 1e-6)) + 1, 2)
        return self.position_at(np.arange(count) / rate_hz)

    def largest_change(self, within_s: float) -> tuple[float, float]:
        """The most by which the speed differs between two instants that are `within_s` apart, and when (mm/s, s).

        Exact: both speeds are straight lines over time, so their difference is largest where one of them bends.
        """
        rest = self.end_s - self.time_s[-1]
        time_s = np.append(self.time_s, self.end_s)
        speed = np.append(self.velocity_mm_per_s, self.velocity_mm_per_s[-1] + self.acceleration_mm_per_s2[-1] * rest)
        most, when_s = 0.0, 0.0
        for begin in range(0, len(time_s), _AT_ONCE):
            some_s, theirs = time_s[begin : begin + _AT_ONCE], speed[begin : begin + _AT_ONCE]
            for shift_s in (-within_s, within_s):
                change = np.abs(np.interp(some_s + shift_s, time_s, speed, left=0.0, right=0.0) - theirs)
                worst = int(change.argmax())
                if change[worst] > most:
                    most, when_s = float(change[worst]), float(some_s[worst])
        return most, when_s


def drive(
    blocks: Blocks,
    acceleration_mm_per_s2: float,
    *,
    start_mm: float = 0.0,
    look_ahead: int | None = None,
    corner_mm_per_s: float = 0.0,
    stop_after: np.ndarray | None = None,
) -> Motion:
    """Drive a chain of blocks as fast as their speeds and the acceleration allow.

    Parameters
    ----------
    blocks : Blocks
        What to drive.
    acceleration_mm_per_s2 : float
        The axis' acceleration, used for every change of speed.
    start_mm : float
        Position at time zero.
    look_ahead : int or None
        How many blocks the controller sees; it must be able to stop within them. None sees all.
    corner_mm_per_s : float
        Speed step that the controller takes without stopping at a reversal.
    stop_after : array of bool (n,) or None
        Blocks at whose end the axis stops (exact stop, G61).
    """
    speeds = junction_speeds(blocks, acceleration_mm_per_s2, look_ahead, corner_mm_per_s, stop_after)
    return _phases(blocks, speeds, acceleration_mm_per_s2, start_mm)


def junction_speeds(
    blocks: Blocks,
    acceleration_mm_per_s2: float,
    look_ahead: int | None = None,
    corner_mm_per_s: float = 0.0,
    stop_after: np.ndarray | None = None,
) -> np.ndarray:
    """Highest possible speeds (mm/s) at the n + 1 block ends; zero at dwells, first and last.

    With w = v^2 and S the distance travelled, the acceleration a allows |w_i - w_j| <= 2 a |S_i - S_j|. Running
    minima of w + 2 a S (backward) and w - 2 a S (forward) solve it exactly.
    """
    length, speed = blocks.length_mm, blocks.speed_mm_per_s
    cap = np.zeros(len(length) + 1)
    direction = np.sign(length)
    turn = direction[:-1] * direction[1:]
    slower = np.minimum(speed[:-1], speed[1:])
    cap[1:-1] = np.where(turn > 0, slower, np.where(turn < 0, np.minimum(slower, corner_mm_per_s / 2), 0.0))
    if stop_after is not None:
        cap[1:][stop_after] = 0.0
    gain = 2.0 * acceleration_mm_per_s2 * np.concatenate(([0.0], np.cumsum(np.abs(length))))
    square = np.minimum(cap**2, _can_stop(cap**2 + gain, gain, look_ahead) - gain)
    square = np.minimum(square, np.minimum.accumulate(square - gain) + gain)
    return np.sqrt(np.maximum(square, 0.0))


def _can_stop(level: np.ndarray, gain: np.ndarray, look_ahead: int | None) -> np.ndarray:
    """Least of `level` from each junction on; a controller of finite sight must stop where its sight ends."""
    if look_ahead is None or look_ahead >= len(level):
        return np.minimum.accumulate(level[::-1])[::-1]
    least, span = level.copy(), 1
    while span < look_ahead:
        step = min(span, look_ahead - span)
        least[:-step] = np.minimum(least[:-step], least[step:])
        span += step
    least[:-look_ahead] = np.minimum(least[:-look_ahead], gain[look_ahead:])
    return least


def block_ends(blocks: Blocks, acceleration_mm_per_s2: float) -> np.ndarray:
    """When each block ends (s), driven with full sight: `drive` without its phases."""
    junction = junction_speeds(blocks, acceleration_mm_per_s2)
    _, durations = _profile(blocks, junction, acceleration_mm_per_s2)
    return np.cumsum(durations.sum(axis=1))


def _profile(blocks: Blocks, junction: np.ndarray, acceleration: float) -> tuple[np.ndarray, np.ndarray]:
    """Peak speed (n,) of each block, and durations (n, 3) of its speeding up, cruising and slowing down."""
    distance = np.abs(blocks.length_mm)
    entry, leave = junction[:-1], junction[1:]
    # With tiny blocks rounding can leave a peak a hair below the ends' speeds; never below, or times turn negative.
    peak = np.minimum(blocks.speed_mm_per_s, np.sqrt((entry**2 + leave**2) / 2 + acceleration * distance))
    np.maximum(peak, np.maximum(entry, leave), out=peak)
    duration = np.empty((len(distance), 3))
    duration[:, 0] = (peak - entry) / acceleration
    duration[:, 2] = (peak - leave) / acceleration
    cruised = distance - (entry + peak) / 2 * duration[:, 0] - (leave + peak) / 2 * duration[:, 2]
    cruise = np.maximum(cruised, 0.0) / np.where(peak > 0, peak, np.inf)
    duration[:, 1] = np.where(distance > 0, cruise, blocks.dwell_s)
    return peak, duration


def _phases(blocks: Blocks, junction: np.ndarray, acceleration: float, start_mm: float) -> Motion:
    """Speed up, cruise, slow down: three phases a block, some of them empty. Filled in place: a day is long."""
    peak, duration = _profile(blocks, junction, acceleration)
    direction = np.sign(blocks.length_mm)
    size = len(direction)
    speed, push, position = np.empty((size, 3)), np.zeros((size, 3)), np.empty((size, 3))
    speed[:, 0] = junction[:-1] * direction
    speed[:, 1] = speed[:, 2] = peak * direction
    push[:, 0], push[:, 2] = direction * acceleration, -direction * acceleration
    position[:, 0] = start_mm
    position[1:, 0] += np.cumsum(blocks.length_mm)[:-1]
    position[:, 1] = position[:, 0] + (speed[:, 0] + speed[:, 1]) / 2 * duration[:, 0]
    position[:, 2] = position[:, 1] + speed[:, 1] * duration[:, 1]
    ends = np.cumsum(duration.ravel())
    block_end, end = ends[2::3].copy(), float(ends[-1])
    begins = np.subtract(ends, duration.ravel(), out=ends)
    return Motion(begins, position.ravel(), speed.ravel(), push.ravel(), end, block_end)
