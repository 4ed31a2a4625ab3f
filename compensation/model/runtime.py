"""Rules of a compensator in use: which samples it leaves out, what it was never trained on, how its memories begin.

A worn sensor is read through loose contacts and switched on at any moment. The stream, the C header and the ONNX
model follow the same three rules:

- *A faulty sample changes nothing*: a reading that is not finite or not positive, or a time step that is not within
  `STEPS_S`, leaves the state as it was, repeats the last value and says so.
- *What was not seen in training is said*: a conductance, or a memory, outside the range of the training sets a
  status. The conductance that goes into the memories is held within one width of that range to either side, so that
  a single spike cannot fill them for minutes.
- *Where to begin*: the first reading says something about what the memories would hold had they been running. Their
  expected values given it, learned by linear regression over the training, are what they start from.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from enum import IntFlag

import numpy as np
from numpy.typing import NDArray

from compensation.memories.ema import start_steps
from compensation.model.compensator import Beginning, Fitted, Seen, TrainedCompensator, trained
from compensation.series.preprocessing import Series
from gcode.support.arrays import FloatArray
from gcode.support.errors import UserError

# Limits are numbers that single and double precision hold alike, so that all runtimes refuse the same samples.
# About a microsecond, and an hour: a longer pause is a new start.
STEPS_S = (2.0**-20, 3600.0)
# Of a compensator: the step from one sample to the next is neither of these.
SMALLEST_RATE_HZ, LARGEST_RATE_HZ = 1 / STEPS_S[1], 1 / STEPS_S[0]
# What single precision holds as a normal number (about 1e-37 to 1.7e38).
READINGS_S = (2.0**-123, 2.0**127)
# Where no range is known: standard deviations that a float32 can square.
UNKNOWN_LIMIT = 1e6


class Status(IntFlag):
    """What is wrong with a prediction; 0 where nothing is."""

    GOOD = 0
    BAD_READING = 1
    BAD_STEP = 2
    UNSEEN_READING = 4
    UNSEEN_HISTORY = 8
    STARTING = 16


MEANING = {
    Status.BAD_READING: "not finite or not positive: left out, the last value repeated",
    Status.BAD_STEP: "time step not finite, below about 1 us or above an hour: left out likewise",
    Status.UNSEEN_READING: "conductance outside the range of the training",
    Status.UNSEEN_HISTORY: "a memory outside the range of the training",
    Status.STARTING: "the first samples, from which the memories' start is taken",
}


def streamable(compensator: TrainedCompensator | Fitted) -> TrainedCompensator:
    """What was learned, unless it must know a whole recording before its first sample, or knows no conductance."""
    compensator = trained(compensator)
    if compensator.per_recording:
        raise UserError("a compensator trained with --per-recording needs the whole recording; train without it")
    seen = compensator.seen
    # Recalibration moves what was seen to where another sensor may never be.
    if seen is None or "recalibrated" in compensator.recipe:
        return compensator
    low, high = (compensator.scaling_in.invert(np.array(end)) for end in (seen.low, seen.high))
    if not (low >= READINGS_S[0] and high <= READINGS_S[1]):
        raise UserError(
            f"the compensator was trained on values from {low:.4g} to {high:.4g}; a stream, a file and a chip take "
            f"conductances in S, from {READINGS_S[0]:.2g} to {READINGS_S[1]:.2g}: train on these, "
            "without a logarithm or a scaler before it"
        )
    return compensator


def limits_of(compensator: TrainedCompensator) -> tuple[float, float]:
    """Low and high limit to which the standardised conductance is clipped."""
    low, high = ranges_of(compensator).held(np.array([-np.inf, np.inf])).tolist()
    return low, high


def ranges_of(compensator: TrainedCompensator) -> Seen:
    """The ranges seen, or ranges that nothing leaves."""
    if compensator.seen is not None:
        return compensator.seen
    wide = np.full(compensator.input_count, 4 * UNKNOWN_LIMIT)
    return Seen(-UNKNOWN_LIMIT, UNKNOWN_LIMIT, -wide, wide)


def fault_of(conductance_S: float, step_s: float) -> Status:
    """What is wrong with a sample itself."""
    fault = Status.GOOD
    # Comparisons with a NaN are false.
    if not READINGS_S[0] <= conductance_S <= READINGS_S[1]:
        fault |= Status.BAD_READING
    if not STEPS_S[0] <= step_s <= STEPS_S[1]:
        fault |= Status.BAD_STEP
    return fault


def unseen(seen: Seen, reading: FloatArray, features: FloatArray) -> NDArray[np.int64]:
    """Flags of what the training did not have, of standardised readings (n,) and the networks' inputs (n, k)."""
    strange = (reading < seen.low) | (reading > seen.high)
    unknown = ((features < seen.inputs_low) | (features > seen.inputs_high)).any(axis=1)
    return strange * int(Status.UNSEEN_READING) + unknown * int(Status.UNSEEN_HISTORY)


def ready_for_use(compensator: TrainedCompensator, series: Sequence[Series]) -> TrainedCompensator:
    """The compensator with what it has seen and where to begin, both from its training recordings."""
    if compensator.per_recording:
        return compensator
    unlimited = replace(compensator, seen=None, beginning=None)
    features = [unlimited.features(part.time_s, part.conductance_S) for part in series]
    signals = [compensator.scaling_in.apply(part.conductance_S) for part in series]
    everything, x = np.concatenate(features), np.concatenate(signals)
    seen = Seen(float(x.min()), float(x.max()), everything.min(axis=0), everything.max(axis=0))
    return replace(compensator, seen=seen, beginning=_expected_memories(compensator, series, features, signals))


def _expected_memories(
    compensator: TrainedCompensator,
    series: Sequence[Series],
    features: Sequence[FloatArray],
    signals: Sequence[FloatArray],
) -> Beginning:
    """Regression of every memory on the mean of the reading over as long as its start is taken from."""
    lasting = np.zeros(compensator.input_count)
    lasting[: len(compensator.alphas)] = start_steps(compensator.alphas, compensator.rate_hz)
    steps = [(part.time_s - part.time_s[0]) * compensator.rate_hz for part in series]
    gains, offsets = np.zeros(compensator.input_count), np.zeros(compensator.input_count)
    for column, long in enumerate(lasting):
        # Where it has been running for that long, but for a step; a shorter recording has its last sample only.
        ready = [elapsed >= min(long - 1.0, elapsed[-1]) for elapsed in steps]
        means = [_trailing_mean(x, elapsed, long) for x, elapsed in zip(signals, steps, strict=True)]
        told = np.concatenate([mean[rows] for mean, rows in zip(means, ready, strict=True)])
        held = np.concatenate([part[rows, column] for part, rows in zip(features, ready, strict=True)])
        spread = float(np.var(told))
        gains[column] = float(np.mean((told - told.mean()) * (held - held.mean()))) / spread if spread > 0 else 0.0
        offsets[column] = held.mean() - gains[column] * told.mean()
    return Beginning(gains, offsets)


def _trailing_mean(x: FloatArray, steps: FloatArray, long: float) -> FloatArray:
    """Mean of the samples of the last so many steps, at each sample; of itself at least."""
    own = np.arange(len(x))
    begins = np.minimum(np.searchsorted(steps, steps - long, side="right"), own)
    sums = np.cumsum(np.concatenate([[0.0], x]))
    return (sums[1:] - sums[begins]) / (own + 1 - begins)
