"""A recording becomes the arrays that are learned from."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gcode.support.arrays import FloatArray
from gcode.support.errors import UserError
from testbench.recordings.channels import DISPLACEMENT, FORCE, RESISTANCE
from testbench.recordings.doubts import slow
from testbench.recordings.recording import Recording, recorded_duration_s

TARGETS = {"force": (FORCE, "N"), "displacement": (DISPLACEMENT, "mm")}
SHORTEST_RECORDING_S = 10.0


@dataclass(frozen=True)
class Series:
    """One recording as input and target, each (n,)."""

    time_s: FloatArray
    conductance_S: FloatArray
    truth: FloatArray  # force (N) or displacement (mm)
    source: str  # where it came from

    def __len__(self) -> int:
        return len(self.time_s)

    @property
    def digest(self) -> str:
        """SHA-256 of conductance and target: the same under whatever path."""
        return hashlib.sha256(np.stack([self.conductance_S, self.truth]).tobytes()).hexdigest()

    @property
    def reading_digest(self) -> str:
        """SHA-256 of the conductance: the same whatever the target was, or was said to be, as at rest."""
        return hashlib.sha256(self.conductance_S.tobytes()).hexdigest()

    def rows(self, rows: NDArray[np.intp]) -> Series:
        return Series(self.time_s[rows], self.conductance_S[rows], self.truth[rows], self.source)


def series_of(recording: Recording, target: str, rate_hz: float | None) -> Series:
    """Input and target of a recording that is learned from or scored.

    It is resampled by linear interpolation to `rate_hz` (the paper: 20 Hz); None keeps the samples as they are. Gaps
    stay gaps: nobody has measured a straight line there.

    Raises
    ------
    UserError
        If a channel is missing or constant, or the recording is too short, or too slow to be put on a grid.
    """
    channel = _present(recording, target)
    duration_s = recorded_duration_s(recording.time_s)
    if duration_s < SHORTEST_RECORDING_S:
        raise UserError(
            f"{recording.source}: {duration_s:.1f} s long; a compensator needs at least {SHORTEST_RECORDING_S:.0f} s"
        )
    if rate_hz is not None and (said := slow(recording)):
        raise UserError(f"{recording.source}: {said} At {rate_hz:g} Hz nearly all of it would be straight lines")
    series = sampled(recording, channel, rate_hz)
    for name, values in ((RESISTANCE, series.conductance_S), (channel, series.truth)):
        if stands_still(values):
            absent = "" if values.any() else " (zero throughout, as where the file has no such column)"
            raise UserError(f"{recording.source}: {name} is constant{absent}, so there is nothing to learn from it")
    return series


def reference_of(recording: Recording, target: str, rate_hz: float | None) -> Series:
    """As `series_of`, of a reference to recalibrate by: it may be short and stand still, but not be zero."""
    channel = _present(recording, target)
    if not recording[channel].any():
        raise UserError(
            f"{recording.source}: {channel} is zero throughout, as where the file has no such column; if the sensor "
            "rests without load there, say so with --rest"
        )
    return sampled(recording, channel, rate_hz)


def _present(recording: Recording, target: str) -> str:
    """Channel of the target, which the recording has, and a resistance beside it."""
    channel, _ = TARGETS[target]
    for name in (RESISTANCE, channel):
        if not recording.has(name):
            have = ", ".join(recording.channels)
            raise UserError(f"{recording.source}: no {name}, which --target {target} needs; it has {have}")
    return channel


def sampled(recording: Recording, channel: str, rate_hz: float | None) -> Series:
    """Conductance and one channel of a recording on a grid (None: as sampled), without points in a gap."""
    gaps = recording.gaps
    if rate_hz is not None:
        # Resistance is what was measured: interpolate it, then invert, as the paper does.
        recording = recording.resampled(rate_hz)
    whole = Series(recording.time_s, recording.conductance_S, recording[channel], recording.source)
    recorded = np.ones(len(whole), dtype=bool)
    for start_s, end_s in gaps:
        recorded &= (whole.time_s <= start_s) | (whole.time_s >= end_s)
    return whole.rows(np.flatnonzero(recorded))


def stands_still(values: FloatArray) -> bool:
    """Whether a signal is constant, but for rounding: nothing can be learned from it."""
    return bool(np.ptp(values) <= 1e-12 * np.abs(values).max())
