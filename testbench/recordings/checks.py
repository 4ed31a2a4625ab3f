"""What makes a recording usable, checked once, in words that name the row and the remedy."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from gcode.support.arrays import FloatArray
from gcode.support.errors import UserError
from gcode.support.kinds import is_number
from testbench.recordings.channels import DISPLACEMENT, FORCE, RESISTANCE, TEMPERATURE, TIME

# Far beyond any tester: what lies outside is another unit, or a broken file, and would only overflow later.
LONGEST_GAUGE_MM = 1e6
LIMITS = {
    TIME: (-1e11, 1e11),  # 3,000 years; the s since 1970 lie inside, the ms do not
    DISPLACEMENT: (-1e6, 1e6),  # 1 km
    FORCE: (-1e6, 1e6),
    RESISTANCE: (1e-12, 1e18),
    TEMPERATURE: (-273.15, 1e4),
}
NO_LIMITS = (-np.inf, np.inf)
MOST_STRAIN = 20.0  # 2,000 %; the softest rubber tears at 10
DROP = "`testbench import --drop-bad` leaves them out (in a data frame, select the others)"
HEADER_ROWS = 2  # rows of a file count from 1 and the header is row 1

RowWords = Callable[[int], str]


def row_of_table(place: int) -> str:
    """A row of a table in memory, which counts from 0 as pandas and numpy do."""
    return f"row {place} (counting from 0)"


def row_of_file(place: int) -> str:
    """The same row where the table is a file with a header."""
    return f"row {place + HEADER_ROWS}"


def check(
    source: str,
    time_s: FloatArray,
    channels: Mapping[str, FloatArray],
    gauge_length_mm: float,
    row: RowWords = row_of_table,
    found: str = "",
) -> None:
    """Raise `UserError` unless time increases, every value is finite and within `LIMITS`, and lengths agree.

    Parameters
    ----------
    source : str
        Named in the message.
    time_s : ndarray, shape (n,)
    channels : mapping of str to ndarray, each shape (n,)
    gauge_length_mm : float
    row : callable
        What a message calls the row of a sample: `row_of_table` or `row_of_file`.
    found : str
        The columns that there are, for a message; default: the channels.
    """
    if DISPLACEMENT in channels:
        check_gauge_length(gauge_length_mm, source)
    if len(time_s) < 2:
        raise UserError(f"{source}: a recording needs at least 2 samples, got {len(time_s)}")
    if DISPLACEMENT not in channels and not _goes_without_displacement(channels):
        have = found or ", ".join(channels) or "none"
        raise UserError(f"{source}: no column displacement_mm (found: {have}); name yours with `testbench import`")
    _check_time(source, time_s, row)
    for name, values in channels.items():
        if len(values) != len(time_s):
            raise UserError(f"{source}: {name} has {len(values)} samples, time_s has {len(time_s)}")
        _check_finite(source, name, values, row)
        if name == RESISTANCE:
            _refuse(source, values, values <= 0, f"{name} must be positive, got", f"; {DROP}", row)
        _check_within(source, name, values, row)
    if DISPLACEMENT in channels:
        check_strain(source, channels[DISPLACEMENT], gauge_length_mm, row)


def known_length(gauge_length_mm: float | None, source: str) -> float:
    """A gauge length that was given, in mm; NaN where none was.

    Raises
    ------
    UserError
        That names `source`, if it is none that a sample can have.
    """
    if gauge_length_mm is None:
        return float("nan")
    check_gauge_length(gauge_length_mm, source)
    return float(gauge_length_mm)


def check_gauge_length(gauge_length_mm: float, source: str) -> None:
    """Raise `UserError`, which names `source`, unless it is a length that a sample can have."""
    if not is_number(gauge_length_mm):
        kind = type(gauge_length_mm).__name__
        raise UserError(f"{source}: the gauge length must be a number of mm, got {gauge_length_mm!r} ({kind})")
    if not 0 < gauge_length_mm <= LONGEST_GAUGE_MM:
        raise UserError(
            f"{source}: the gauge length must be a positive number of mm, at most {LONGEST_GAUGE_MM:.0f}, "
            f"got {gauge_length_mm:g}"
        )


def _goes_without_displacement(channels: Mapping[str, FloatArray]) -> bool:
    """Whether force and resistance are there, and no column that may be a displacement under another name or unit."""
    overlooked = any(name.lower().startswith(("displ", "strain", "extension")) for name in channels)
    return not overlooked and {FORCE, RESISTANCE} <= set(channels)


def _check_time(source: str, time_s: FloatArray, row: RowWords) -> None:
    _check_finite(source, TIME, time_s, row)
    _check_within(source, TIME, time_s, row)
    backwards = np.flatnonzero(np.diff(time_s) <= 0)
    if backwards.size:
        place = int(backwards[0]) + 1
        came = f"{time_s[place]:g} s after {time_s[place - 1]:g} s"
        raise UserError(
            f"{source}: {row(place)}: time must increase, got {came}; "
            "`testbench import --sort` puts rows in order and drops repeated times (a data frame has sort_values)"
        )


def _check_finite(source: str, name: str, values: FloatArray, row: RowWords) -> None:
    _refuse(source, values, ~np.isfinite(values), f"{name} is", f"; {DROP}", row)


def _check_within(source: str, name: str, values: FloatArray, row: RowWords) -> None:
    low, high = LIMITS.get(name, NO_LIMITS)
    remedy = f"check its unit (`testbench import` turns units into ours); where single rows are wrong, {DROP}"
    _refuse(
        source, values, ~within(name, values), f"{name} is", f", and {low:g} to {high:g} is allowed; {remedy}", row
    )


def within(name: str, values: FloatArray) -> np.ndarray:
    """Which values of a channel lie within `LIMITS`, as booleans of shape (n,)."""
    low, high = LIMITS.get(name, NO_LIMITS)
    return (values >= low) & (values <= high)


def _refuse(source: str, values: FloatArray, bad: np.ndarray, what: str, remedy: str, row: RowWords) -> None:
    """Name the first of the bad values, its row, and how many there are; nothing where none is."""
    places = np.flatnonzero(bad)
    if places.size:
        place = int(places[0])
        raise UserError(f"{source}: {row(place)}: {what} {values[place]:g} ({such(places.size)}){remedy}")


def check_strain(source: str, displacement_mm: FloatArray, gauge_length_mm: float, row: RowWords) -> None:
    """Raise `UserError`, which names `source` and the row, where the stretch is more than a sample can have."""
    furthest = int(np.argmax(np.abs(displacement_mm)))
    strain = abs(float(displacement_mm[furthest])) / gauge_length_mm
    if strain > MOST_STRAIN:
        raise UserError(
            f"{source}: {row(furthest)}: a displacement of {displacement_mm[furthest]:g} mm at a gauge "
            f"length of {gauge_length_mm:g} mm is a strain of {strain:.3g}, and at most {MOST_STRAIN:g} is allowed; "
            "check the gauge length and the unit of the displacement"
        )


def such(count: int) -> str:
    """``1 such row``, ``2 such rows``."""
    return f"{count} such row{'s' if count > 1 else ''}"
