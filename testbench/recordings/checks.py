"""What makes a recording usable, checked once, in words that name the row and the remedy."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gcode.support.errors import UserError

if TYPE_CHECKING:
    from testbench.recordings.recording import Recording

HEADER_ROWS = 2  # row numbers in messages count from 1 and the header is row 1


def check_recording(recording: Recording) -> None:
    """Raise `UserError` unless time increases, every value is finite and lengths agree."""
    source = recording.source
    gauge_mm = recording.gauge_length_mm
    if "displacement_mm" in recording.channels and not (np.isfinite(gauge_mm) and gauge_mm > 0):
        raise UserError(f"{source}: the gauge length must be a positive number of mm, got {gauge_mm}")
    if len(recording.time_s) < 2:
        raise UserError(f"{source}: a recording needs at least 2 samples, got {len(recording.time_s)}")
    if "displacement_mm" not in recording.channels and not _goes_without_displacement(recording):
        have = ", ".join(recording.channels) or "none"
        raise UserError(f"{source}: no column displacement_mm (found: {have}); name yours with `testbench import`")
    _check_time(source, recording.time_s)
    for name, values in recording.channels.items():
        if len(values) != len(recording.time_s):
            raise UserError(f"{source}: {name} has {len(values)} samples, time_s has {len(recording.time_s)}")
        _check_finite(source, name, values)
    if "resistance_ohm" in recording.channels:
        _check_positive(source, "resistance_ohm", recording.channels["resistance_ohm"])


def _goes_without_displacement(recording: Recording) -> bool:
    """Whether force and resistance are there, and no column that may be a displacement under another name or unit."""
    overlooked = any(name.lower().startswith(("displ", "strain", "extension")) for name in recording.channels)
    return not overlooked and {"force_N", "resistance_ohm"} <= set(recording.channels)


def check_displacement(recording: Recording) -> None:
    """Raise `UserError` where a displacement is needed and was not recorded."""
    if not recording.has("displacement_mm"):
        have = ", ".join(recording.channels)
        raise UserError(
            f"{recording.source}: no displacement was recorded, and a model of the sensor needs it; it has {have}, "
            "which is enough for `compensation train --target force`"
        )


def _check_time(source: str, time_s: np.ndarray) -> None:
    _check_finite(source, "time_s", time_s)
    backwards = np.flatnonzero(np.diff(time_s) <= 0)
    if backwards.size:
        row = int(backwards[0]) + 1
        came = f"{time_s[row]:g} s after {time_s[row - 1]:g} s"
        raise UserError(
            f"{source}: row {row + HEADER_ROWS}: time must increase, got {came}; "
            "`testbench import --sort` puts rows in order and drops repeated times"
        )


def _check_finite(source: str, name: str, values: np.ndarray) -> None:
    bad = np.flatnonzero(~np.isfinite(values))
    if bad.size:
        row = int(bad[0]) + HEADER_ROWS
        raise UserError(
            f"{source}: row {row}: {name} is {values[bad[0]]} ({such(bad.size)}); "
            "`testbench import --drop-bad` leaves them out"
        )


def _check_positive(source: str, name: str, values: np.ndarray) -> None:
    bad = np.flatnonzero(values <= 0)
    if bad.size:
        row = int(bad[0]) + HEADER_ROWS
        raise UserError(
            f"{source}: row {row}: {name} must be positive, got {values[bad[0]]:g} ({such(bad.size)}); "
            "`testbench import --drop-bad` leaves them out"
        )


def such(count: int) -> str:
    """``1 such row``, ``2 such rows``."""
    return f"{count} such row{'s' if count > 1 else ''}"
