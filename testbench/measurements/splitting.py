"""What is calibrated on, and what is held out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gcode.support.errors import UserError
from testbench.measurements.joining import last_of
from testbench.measurements.measurement import Measurement
from testbench.measurements.preparing import MIN_STRAIN_RANGE, prepare
from testbench.recordings.between import FRESH, Between
from testbench.recordings.doubts import check_same_gauge_length
from testbench.recordings.recording import Recording, recorded_duration_s

MOST_PLAY = 0.1  # of the gauge length: more is another set-up
MIN_PART = 170  # samples that count in each part


def split(
    recording: Recording, held_out: Recording | None = None, held_share: float = 1 / 3, between: Between = FRESH
) -> tuple[Measurement, Measurement]:
    """Calibration and held-out measurements; without `held_out`, the last third of the recording.

    Parameters
    ----------
    recording, held_out : Recording
        Each is measured at its own rate.
    held_share : float
    between : Between
        The recording and the held-out one.

    Raises
    ------
    UserError
        If the two were taken at different gauge lengths or share no channel, or one recording is too short or too
        still in a part of it; if there is play or a rest without a held-out recording, or more play than clamps have.
    """
    check_play(recording, between.clamp_play_mm)
    if held_out is None:
        _check_nothing_between(recording, between)
        cut_s = _recorded_until(recording, 1 - held_share)
        parts = prepare(recording, (0.0, cut_s)), prepare(recording, (cut_s, np.inf))
        _check_parts(*parts, cut_s)
        # Nothing may be started from, or scaled by, what comes after the last sample that counts.
        return parts[0].at(parts[0].seen), parts[1]
    check_same_gauge_length(held_out, recording)
    calibration, held = prepare(recording), prepare(held_out)
    if set(calibration.channels) != set(held.channels):
        raise UserError(
            f"{held_out.source}: measured {', '.join(held.channels)}, but {recording.source} measured "
            f"{', '.join(calibration.channels)}; both need the same channels"
        )
    if between.rest_s is not None:
        return calibration, last_of([recording, held_out], [between.rest_s], between.clamp_play_mm)
    return calibration, replace(held, clamp_play_mm=between.clamp_play_mm)


def _check_nothing_between(recording: Recording, between: Between) -> None:
    if between == FRESH:
        return
    what = "clamp play is that" if between.clamp_play_mm else "a rest comes before that"
    raise UserError(
        f"{recording.source}: {what} of a held-out recording, and none was given; before the last third of one "
        "recording the sensor was neither clamped anew nor at rest"
    )


def _recorded_until(recording: Recording, share: float) -> float:
    """Time after the start at which this share of what was recorded has passed; gaps do not count."""
    until_s = share * recorded_duration_s(recording.time_s)
    for start_s, end_s in recording.gaps:
        if start_s - recording.time_s[0] >= until_s:
            break
        until_s += end_s - start_s
    return until_s


def check_play(recording: Recording, clamp_play_mm: float) -> None:
    """Refuse a play that no clamp has."""
    most_mm = MOST_PLAY * recording.gauge_length_mm
    if not isinstance(clamp_play_mm, int | float) or not 0 <= clamp_play_mm <= most_mm:
        raise UserError(
            f"clamp play: must be from 0 to {most_mm:g} mm ({MOST_PLAY:.0%} of the gauge length), "
            f"got {clamp_play_mm!r}"
        )


def _check_parts(calibration: Measurement, held: Measurement, cut_s: float) -> None:
    source = calibration.recording.source
    fewest = min(int(part.counts.sum()) for part in (calibration, held))
    if fewest < MIN_PART:
        raise UserError(
            f"{source}: too short to fit on one part and judge on the rest: {fewest} samples in the shorter part, "
            f"at least {MIN_PART} are needed; record longer, or give another recording as `held_out`"
        )
    seen = calibration.signals["strain"][calibration.seen]
    if np.ptp(seen) < MIN_STRAIN_RANGE:
        raise UserError(
            f"{source}: too still to identify anything: the strain moves by {np.ptp(seen):.2%} in the first "
            f"{cut_s:.0f} s, on which the model is fitted; give a recording that moves, and this one as `held_out`"
        )
    for channel, values in calibration.measured.items():
        if np.ptp(values[calibration.counts]) == 0:
            raise UserError(
                f"{source}: {channel} is constant in the first {cut_s:.0f} s, on which the model is fitted; "
                "check the wiring or leave it out"
            )
