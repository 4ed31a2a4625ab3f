"""What makes a sound recording useless to a model, or its result doubtful: gaps, and a force of the other sign."""

from __future__ import annotations

import logging

import numpy as np

from gcode.support.errors import UserError
from testbench.recordings.channels import FORCE
from testbench.recordings.recording import Recording

ABRUPT = 10.0  # times the steps beside it: where sampling is slowed down in a hold, steps grow little by little
LEAST_RECORDED = 2e-3  # of the time: a grid of 200,000 points then has 400 with samples, in two parts
MOST_HELD_OUT_POINTS = 5_000_000  # 55 h at 25 Hz
AGAINST = -0.5  # correlation of force and displacement below which one of them runs the wrong way
_SAID: set[str] = set()


def check_gap(recording: Recording) -> None:
    """Refuse a recording that is nearly nothing but one gap; say so where a gap is longer than all that was recorded.

    Raises
    ------
    UserError
        If no grid that fits into the memory could show the motion on both sides of the gap.
    """
    gap = longest_gap(recording)
    if gap is None:
        return
    start_s, length_s = gap
    rest_s = recording.duration_s - length_s
    what = f"{recording.source}: nothing was recorded for {length_s:.4g} s after {start_s:.4g} s"
    if rest_s < LEAST_RECORDED * recording.duration_s:
        raise UserError(
            f"{what}, beside {rest_s:.4g} s that were: too long a gap for one model run over it; cut the recording "
            "there and use the parts, one of them as --held-out"
        )
    if length_s > rest_s:
        say_once(f"{what}; a model is compared with a straight line there: better cut the recording there")


def longest_gap(recording: Recording) -> tuple[float, float] | None:
    """Last time before the longest step and its length, in s; None if it is not much longer than its neighbours."""
    steps_s = np.diff(recording.time_s)
    row = int(np.argmax(steps_s))
    beside = steps_s[max(row - 1, 0) : row + 2]
    others = beside[beside < steps_s[row]]
    if len(others) == 0 or steps_s[row] < ABRUPT * others.max():
        return None
    return float(recording.time_s[row]), float(steps_s[row])


def check_grid(held_out: Recording, recording: Recording, most_hz: float) -> None:
    """Refuse a held-out recording that is too long for a grid as fine as the calibration's.

    Parameters
    ----------
    most_hz : float
        The finest grid that is used.
    """
    rate_hz = min(most_hz, recording.mean_rate_hz)
    if held_out.duration_s * rate_hz > MOST_HELD_OUT_POINTS:
        raise UserError(
            f"{held_out.source}: {held_out.duration_s:.4g} s at the {rate_hz:.3g} Hz of {recording.source} are more "
            f"than {MOST_HELD_OUT_POINTS / 1e6:g} million points; cut it, and hold out a part"
        )


def say_sign(recording: Recording) -> None:
    """Say where the force falls as the sensor is stretched: no law of a knit does that."""
    if not recording.has(FORCE) or np.ptp(recording[FORCE]) == 0 or np.ptp(recording.strain) == 0:
        return
    related = float(np.corrcoef(recording.strain, recording[FORCE])[0, 1])
    if related < AGAINST:
        say_once(
            f"{recording.source}: force falls as the displacement rises (correlation {related:.2f}): does one of "
            "them run the wrong way? `testbench import --negate force` turns it"
        )


def say_once(text: str) -> None:
    """Say it where warnings go (stderr, unless a program listens), once in the life of this process."""
    if text not in _SAID:
        _SAID.add(text)
        logging.getLogger("knitbench").warning(text)
