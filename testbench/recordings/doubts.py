"""What makes a sound recording useless to a model, or its result doubtful: gaps, and a force of the other sign."""

from __future__ import annotations

import logging
from collections.abc import Sequence

import numpy as np

from gcode.support.arrays import FloatArray
from gcode.support.errors import UserError
from testbench.recordings.channels import DISPLACEMENT, FORCE
from testbench.recordings.recording import Recording

ABRUPT = 10.0  # times the steps beside it: where sampling is slowed down in a hold, steps grow little by little
LEAST_RECORDED = 2e-3  # of the time: a grid of 200,000 points then has 400 with samples, in two parts
MOST_POINTS = 5_000_000  # 55 h at 25 Hz
AGAINST = -0.5  # correlation of force and displacement below which one of them runs the wrong way
MUCH_MISSING = 0.02  # of the time
SLOWEST_HZ = 0.1  # of recordings that models are tried on
_SAID: set[str] = set()


def check_gap(recording: Recording) -> None:
    """Refuse a recording that is nearly nothing but one gap; say so where a gap is longer than all that was recorded.

    Raises
    ------
    UserError
        If no grid that fits into the memory could show the motion on both sides of the gap.
    """
    steps_s = np.diff(recording.time_s)
    row = int(np.argmax(steps_s))
    length_s = float(steps_s[row])
    beside = steps_s[max(row - 1, 0) : row + 2]
    others = beside[beside < length_s]
    if len(others) == 0 or length_s < ABRUPT * others.max():  # as where sampling is slowed down
        return
    rest_s = recording.duration_s - length_s
    what = f"{recording.source}: nothing was recorded for {length_s:.4g} s after {recording.time_s[row]:.4g} s"
    if rest_s < LEAST_RECORDED * recording.duration_s:
        raise UserError(
            f"{what}, beside {rest_s:.4g} s that were: too long a gap for one model run over it; cut the recording "
            "there and use the parts, one of them as `held_out`"
        )
    if length_s > rest_s:
        say_once(f"{what}; a model is compared with a straight line there: better cut the recording there")


def check_grid(
    others: Sequence[Recording], recording: Recording, most_hz: float, fewest: int, rest_s: float = 0.0
) -> None:
    """Refuse recordings that are too long, or too short, for a grid as fine as that of the first one.

    Parameters
    ----------
    others : sequence of Recording
        What is put on the grid of `recording`: held-out ones, or those that follow it.
    most_hz : float
        The finest grid that is used.
    fewest : int
        Grid points that each of them needs.
    rest_s : float
        Before each of them; it is on the grid, too.

    Raises
    ------
    UserError
    """
    # A grid is as fine as the mean rate, or as that of the quicker part where sampling was slowed down in a hold.
    coarsest_hz = min(most_hz, recording.mean_rate_hz)
    finest_hz = min(most_hz, 1 / float(np.quantile(np.diff(recording.time_s), 0.25)))
    for other in others:
        if other.duration_s * coarsest_hz < fewest:
            raise UserError(
                f"{other.source}: {other.duration_s:.4g} s at the {coarsest_hz:.3g} Hz of {recording.source} are "
                f"fewer than the {fewest} points that are needed; give a longer one"
            )
    total_s = sum(other.duration_s + rest_s for other in others)
    if total_s * finest_hz > MOST_POINTS:
        longest = max(others, key=lambda other: other.duration_s)
        raise UserError(
            f"{longest.source}: {total_s:.4g} s at the {finest_hz:.3g} Hz of {recording.source} are more than "
            f"{MOST_POINTS / 1e6:g} million points; cut it, and use a part"
        )


def check_same_gauge_length(one: Recording, other: Recording) -> None:
    """Refuse two recordings that were not taken at the same gauge length.

    Raises
    ------
    UserError
    """
    if abs(one.gauge_length_mm - other.gauge_length_mm) > 1e-3 * other.gauge_length_mm:
        raise UserError(
            f"{one.source}: gauge length {one.gauge_length_mm:g} mm, but {other.source} has "
            f"{other.gauge_length_mm:g} mm; give recordings of the same set-up"
        )


def same(one: Recording, other: Recording) -> bool:
    """Whether two recordings hold the same samples, under whatever names."""
    if one.channels.keys() != other.channels.keys():
        return False
    pairs = [(one.time_s, other.time_s), *((one[name], other[name]) for name in one.channels)]
    return all(np.array_equal(mine, theirs) for mine, theirs in pairs)


def check_distinct(recordings: Sequence[Recording], why: str) -> None:
    """Refuse a recording that is given twice.

    Parameters
    ----------
    recordings : sequence of Recording
    why : str
        What would be wrong with it, and what to do: the end of the sentence.

    Raises
    ------
    UserError
        With the two sources that hold the same samples.
    """
    for count, one in enumerate(recordings):
        for before in recordings[:count]:
            if same(one, before):
                raise UserError(f"{one.source}: holds the same samples as {before.source}; {why}")


def say_if_same(held_out: Recording, recording: Recording) -> None:
    """Warn where the held-out recording is the one that is fitted on: its error is not that of a prediction."""
    if same(held_out, recording):
        say_once(
            f"{held_out.source}: holds the same samples as what is fitted on, so its errors are not held out; give "
            "another recording, or none (the last third is held out then)"
        )


def correlation(one: FloatArray, other: FloatArray) -> float:
    """Pearson's, of two arrays of shape (n,); 0 where one of them is constant."""
    return 0.0 if np.ptp(one) == 0 or np.ptp(other) == 0 else float(np.corrcoef(one, other)[0, 1])


def say_sign(recording: Recording) -> None:
    """Warn where the force falls as the sensor is stretched: no law of a knit does that."""
    if recording.has(FORCE) and (related := correlation(recording.strain, recording[FORCE])) < AGAINST:
        say_once(
            f"{recording.source}: force falls as the displacement rises (correlation {related:.2f}): does one of "
            f"them run the wrong way? `testbench import --negate {_below_zero(recording)}` turns it"
        )


def slow(recording: Recording) -> str:
    """What is said of a recording that is slower than models are tried on; nothing of others."""
    if len(recording) < 2 or recording.mean_rate_hz >= SLOWEST_HZ:
        return ""
    return (
        f"one sample in {1 / recording.mean_rate_hz:.0f} s: models are tried down to one in {1 / SLOWEST_HZ:.0f} s, "
        "and what is faster than the samples cannot be seen; is its time in s?"
    )


def say_slow(recording: Recording) -> None:
    """Warn where a recording is slower than models are tried on."""
    if said := slow(recording):
        say_once(f"{recording.source}: {said}")


def say_gaps(recording: Recording) -> None:
    """Warn where much of a recording that is learned from, or scored, was not recorded."""
    if recording.missing_s > MUCH_MISSING * recording.duration_s:
        say_once(
            f"{recording.source}: nothing was recorded in {recording.missing_s:.4g} of {recording.duration_s:.4g} s, "
            "which is left out"
        )


def _below_zero(recording: Recording) -> str:
    """The channel that is turned, for it lies below zero the more: a knit is stretched, and pulls.

    A raw file has zeros of its own: there `importing.signs` asks where a signal goes from its first sample.
    """
    lowest = {name: np.min(recording[name]) / np.max(np.abs(recording[name])) for name in (FORCE, DISPLACEMENT)}
    return "displacement" if lowest[DISPLACEMENT] < min(lowest[FORCE], -0.5) else "force"


def say_once(text: str) -> None:
    """Log a warning (to stderr, unless a program listens), once in the life of this process."""
    if text not in _SAID:
        _SAID.add(text)
        logging.getLogger("knitbench").warning(text)
