"""Several recordings of one specimen as one measurement: one history, with rests that no sample was taken in."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from testbench.knit.effect import FloatArray
from testbench.knit.model import inputs
from testbench.measurements.measurement import Measurement
from testbench.measurements.motion import reading_noise
from testbench.measurements.preparing import prepare
from testbench.recordings.doubts import check_same_gauge_length
from testbench.recordings.recording import Recording


def joined(recordings: Sequence[Recording], rests_s: Sequence[float], clamp_play_mm: float = 0.0) -> Measurement:
    """One measurement of all recordings in turn.

    Parameters
    ----------
    recordings : sequence of Recording
        Of one specimen, in the order in which they were made.
    rests_s : sequence of float
        Rest before each but the first, in which the strain goes from where the one before ended to where it begins.
    clamp_play_mm : float
        See `Measurement`; of each recording but the first.

    Returns
    -------
    Measurement
        On the grid of the recording that was sampled most often, so that the order tells nothing but the history.
        Samples of the rests do not count; a model is simulated through them.

    Raises
    ------
    UserError
        If a recording is too short or too still, or taken at another gauge length.
    """
    for one in recordings[1:]:
        check_same_gauge_length(one, recordings[0])
    alone = [prepare(one) for one in recordings]
    if len(alone) == 1:
        return alone[0]
    finest_s = min(p.dt_s for p in alone)
    rate_hz = 1.0 / finest_s
    parts = [p if p.dt_s == finest_s else prepare(p.recording, rate_hz=rate_hz) for p in alone]
    beyond_s = [one.duration_s - float(p.grid_s[-1]) for one, p in zip(recordings, parts, strict=True)]
    between_s = [over_s + p.start_s for over_s, p in zip(beyond_s[:-1], parts[1:], strict=True)]
    gaps = [0, *(_gap(*both, rate_hz) for both in zip(between_s, rests_s, strict=True))]
    lengths = [0, *(len(p.counts) for p in parts[:-1])]
    starts = np.cumsum([gap + before for gap, before in zip(gaps, lengths, strict=True)])
    strain = _chained([p.signals["strain"] for p in parts], gaps)
    warm = [p.signals["temperature_C"] for p in parts if "temperature_C" in p.signals]
    temperature = _chained(warm, gaps) if len(warm) == len(parts) else None
    channels = [c for c in parts[0].channels if all(c in p.channels for p in parts)]
    measured = {c: _read([p.measured[c] for p in parts], gaps) for c in channels}
    counts = np.concatenate([np.r_[np.zeros(gap, bool), p.counts] for gap, p in zip(gaps, parts, strict=True)])
    signals = inputs(np.arange(len(strain)) / rate_hz, strain, temperature)
    if clamp_play_mm:
        signals["clamping"] = np.searchsorted(starts[1:], np.arange(len(strain)), side="right").astype(float)
    whole = _one_recording(recordings, starts / rate_hz, [p.start_s for p in parts])
    noise = _chained([p.strain_noise for p in parts], gaps)
    averaged = tuple(samples for p in parts for samples in p.averaged)
    start_s, begins_s = parts[0].start_s, tuple((starts[1:] / rate_hz).tolist())
    return Measurement(
        signals, 1 / rate_hz, measured, counts, whole, noise, start_s, averaged, clamp_play_mm, begins_s
    )


def last_of(recordings: Sequence[Recording], rests_s: Sequence[float], clamp_play_mm: float = 0.0) -> Measurement:
    """The last of several recordings, after all that its specimen went through; parameters as of `joined`.

    Only its samples count. What comes before is simulated with the displacement as it was read, whatever its zeros.
    """
    whole, last = joined(recordings, rests_s, clamp_play_mm), recordings[-1]
    counts = whole.counts & (whole.signals["time_s"] >= whole.begins_s[-1])
    return replace(whole, counts=counts, recording=replace(whole.recording, source=last.source), rest_s=rests_s[-1])


def _gap(sampled_s: float, rest_s: float, rate_hz: float) -> int:
    """Grid points between two recordings, such that the samples of one begin a rest after those of the other.

    Parameters
    ----------
    sampled_s : float
        Between the last grid point of the one and the first of the other, in which there are samples.
    """
    least = int(sampled_s * rate_hz)
    return max(round((sampled_s + rest_s) * rate_hz) - 1, least, 1)


def _chained(values: Sequence[FloatArray], gaps: Sequence[int]) -> FloatArray:
    """Arrays in a row, with straight lines over the gaps."""
    parts = [values[0]]
    for before, gap, after in zip(values[:-1], gaps[1:], values[1:], strict=True):
        parts += [np.linspace(before[-1], after[0], gap + 2)[1:-1], after]
    return np.concatenate(parts)


def _read(values: Sequence[FloatArray], gaps: Sequence[int]) -> FloatArray:
    """Readings in a row; over the gaps they carry the noise of the reading, which is measured level by level."""
    rng = np.random.default_rng(0)
    noise = [reading_noise(np.arange(len(one), dtype=float), one) for one in values]
    chained = _chained(values, gaps)
    at = 0
    for one, sd, gap in zip(values, noise, [*gaps[1:], 0], strict=True):
        at += len(one)
        chained[at : at + gap] += sd * rng.standard_normal(gap)
        at += gap
    return chained


def _one_recording(recordings: Sequence[Recording], starts_s: FloatArray, firsts_s: Sequence[float]) -> Recording:
    """All samples as recorded, each recording at the time of its first grid point."""
    zero_s = firsts_s[0]
    moved = [
        one.time_s - one.time_s[0] + start_s - first_s + zero_s
        for one, start_s, first_s in zip(recordings, starts_s, firsts_s, strict=True)
    ]
    shared = [name for name in recordings[0].channels if all(name in one.channels for one in recordings)]
    channels = {name: np.concatenate([one.channels[name] for one in recordings]) for name in shared}
    gauge_mm = recordings[0].gauge_length_mm
    return Recording(np.concatenate(moved), channels, gauge_mm, f"{len(recordings)} recordings")
