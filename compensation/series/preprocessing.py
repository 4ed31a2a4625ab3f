"""A recording becomes the arrays that are learned from."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from gcode.support.arrays import FloatArray
from gcode.support.errors import UserError
from testbench.recordings.channels import DISPLACEMENT, FORCE, RESISTANCE
from testbench.recordings.doubts import say_once, slow
from testbench.recordings.recording import Recording, recorded_duration_s

TARGETS = {"force": (FORCE, "N"), "displacement": (DISPLACEMENT, "mm")}
SHORTEST_RECORDING_S = 10.0
# Readings in a row that two recordings do not share by chance, where so many of them are new.
PASSAGE, LEAST_NEW = 64, 12


@dataclass(frozen=True)
class Series:
    """One recording as input and target, each (n,)."""

    time_s: FloatArray
    conductance_S: FloatArray
    truth: FloatArray  # force (N) or displacement (mm)
    source: str  # where it came from
    passages: NDArray[np.uint64] = field(default_factory=lambda: np.empty(0, np.uint64))  # of the whole recording
    passage_ends_s: FloatArray = field(default_factory=lambda: np.empty(0))

    def __len__(self) -> int:
        return len(self.time_s)

    @property
    def digest(self) -> str:
        """SHA-256 of conductance and target: the same under whatever path."""
        return hashlib.sha256(np.stack([self.conductance_S, self.truth]).tobytes()).hexdigest()

    @property
    def marks(self) -> list[int]:
        """Some of its passages, by which any part of the recording that is five times as long is known again."""
        return self.passages[:: 4 * PASSAGE].tolist()

    def holds_any(self, marks: Sequence[int]) -> bool:
        return not set(marks).isdisjoint(self.passages.tolist())

    def rows(self, rows: NDArray[np.intp]) -> Series:
        return replace(self, time_s=self.time_s[rows], conductance_S=self.conductance_S[rows], truth=self.truth[rows])


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
    """Conductance and one channel of a recording on a grid (None: as sampled), without points in a gap.

    Raises
    ------
    UserError
        If the recording is too slow to be put on a grid.
    """
    if rate_hz is not None and (said := slow(recording)):
        raise UserError(f"{recording.source}: {said} At {rate_hz:g} Hz nearly all of it would be straight lines")
    gaps, readings = recording.gaps, recording[RESISTANCE]
    passages, ends_s = passages_of(readings), recording.time_s[PASSAGE - 1 :][moving(readings)]
    if rate_hz is not None:
        # Resistance is what was measured: interpolate it, then invert, as the paper does.
        recording = recording.resampled(rate_hz)
    whole = Series(recording.time_s, recording.conductance_S, recording[channel], recording.source, passages, ends_s)
    recorded = np.ones(len(whole), dtype=bool)
    for start_s, end_s in gaps:
        recorded &= (whole.time_s <= start_s) | (whole.time_s >= end_s)
    return whole.rows(np.flatnonzero(recorded))


def passages_of(readings: FloatArray) -> NDArray[np.uint64]:
    """A number for each `PASSAGE` readings in a row, as they were measured; for none at rest, which are alike."""
    found, length = pd.util.hash_array(np.ascontiguousarray(readings)), 1
    while length < PASSAGE:
        found = found[:-length] * np.uint64(pow(0x9E3779B97F4A7C15, length, 2**64)) + found[length:]
        length *= 2
    return found[moving(readings)]


def moving(readings: FloatArray) -> NDArray[np.bool_]:
    """Which `PASSAGE` readings in a row are more than a rest, beginning with the first."""
    new = np.zeros(len(readings) + 1, dtype=int)
    new[3:] = np.cumsum((readings[2:] != readings[1:-1]) & (readings[2:] != readings[:-2]))
    return new[PASSAGE:] - new[:-PASSAGE] >= LEAST_NEW


def apart(series: Sequence[Series], why: str) -> list[Series]:
    """The recordings, each without a beginning that it has in common with an earlier one.

    Programs that begin alike, played on one simulated sensor from one seed, give the same samples until they part,
    and these must not be learned from and predicted. A recording that is given twice, or another part of it beside
    it, is refused; `why` is the end of the sentence.
    """
    found = []
    for count, one in enumerate(series):
        new_from_s = max((_new_from_s(one, before, why) for before in series[:count]), default=-np.inf)
        found.append(one.rows(np.flatnonzero(one.time_s > new_from_s)))
    return found


def _new_from_s(one: Series, before: Series, why: str) -> float:
    """When it parts from another recording that began alike; both must go on."""
    alike = one.digest == before.digest
    if not alike and not np.isin(one.passages, before.passages).any():
        return -np.inf
    ends_s = [_last_shared_s(one, before), _last_shared_s(before, one)]
    elapsed_s = [end_s - part.time_s[0] for end_s, part in zip(ends_s, (one, before), strict=True)]
    left_s = [part.time_s[-1] - end_s for end_s, part in zip(ends_s, (one, before), strict=True)]
    if alike or not np.isclose(*elapsed_s) or min(left_s) < SHORTEST_RECORDING_S:
        raise UserError(f"{one.source}: holds the same samples as {before.source}, or some of them; {why}")
    say_once(f"{one.source}: its first {elapsed_s[0]:.0f} s are those of {before.source}")
    return ends_s[0]


def _last_shared_s(one: Series, other: Series) -> float:
    """When the last passage ends that another recording has as well."""
    return float(np.max(one.passage_ends_s[np.isin(one.passages, other.passages)], initial=-np.inf))


def stands_still(values: FloatArray) -> bool:
    """Whether a signal is constant, but for rounding: nothing can be learned from it."""
    return bool(np.ptp(values) <= 1e-12 * np.abs(values).max())
