"""Reading recordings: to learn from, resistance and one target are enough; to be compensated, resistance alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from gcode.support.arrays import FloatArray
from gcode.support.errors import UserError
from testbench.recordings.channels import DISPLACEMENT, FORCE, RESISTANCE, TIME
from testbench.recordings.checks import LONGEST_GAUGE_MM
from testbench.recordings.csv_columns import as_numbers, read_columns, read_frame
from testbench.recordings.files import check_beside, read_recording, verified
from testbench.recordings.recording import Recording

# The longest that a recording may have, so that no displacement is refused as a stretch of it.
UNKNOWN_LENGTH_MM = LONGEST_GAUGE_MM


def read_signals(path: str | Path, gauge_length_mm: float | None = None) -> Recording:
    """Read a recording, a folder or a CSV, of which only time, resistance and a target matter.

    A bare CSV needs no gauge length, for neither force nor displacement is a strain. A CSV of time, resistance and
    force alone is taken as well; its displacement is then zero throughout, so that nothing can be learned of it.
    """
    path = Path(path)
    if not path.is_file():
        return read_recording(path, gauge_length_mm)
    check_beside(path)
    columns = read_columns(path)
    length_mm = UNKNOWN_LENGTH_MM if gauge_length_mm is None else gauge_length_mm
    if RESISTANCE not in columns:
        raise UserError(f"{path}: no {RESISTANCE} (found: {', '.join(columns)}); name yours with `testbench import`")
    if not columns.keys() & {DISPLACEMENT, FORCE}:
        raise UserError(
            f"{path}: neither {FORCE} nor {DISPLACEMENT} (found: {', '.join(columns)}), so there is no reference; "
            "name yours, be it a strain, with `testbench import`; `compensation predict` needs none"
        )
    if DISPLACEMENT in columns or TIME not in columns:
        return read_recording(path, length_mm)
    time_s = columns.pop(TIME)
    return Recording(time_s, {DISPLACEMENT: np.zeros(len(time_s)), **columns}, length_mm, str(path))


def read_samples(path: str | Path) -> tuple[FloatArray, FloatArray]:
    """Time (s) and resistance (ohm) of a recording, faulty rows included.

    Raises
    ------
    UserError
        If the file is missing, malformed or not the one that its manifest describes, or lacks either column.
    """
    place, growing = Path(path), False
    if place.is_dir():
        place, campaign = verified(place)
        growing = campaign.in_progress
    else:
        check_beside(place)
    frame = read_frame(place, growing)
    for name in ("time_s", "resistance_ohm"):
        if name not in frame:
            have = ", ".join(map(str, frame.columns[:8]))
            raise UserError(f"{place}: no column {name} (found: {have}); name yours with `testbench import`")
    if frame.empty:
        raise UserError(f"{place}: no sample in it")
    time_s, resistance_ohm = (
        as_numbers(frame[name]).to_numpy(dtype=np.float64) for name in ("time_s", "resistance_ohm")
    )
    return time_s, resistance_ohm


def without_reference(source: str, time_s: FloatArray, resistance_ohm: FloatArray) -> Recording:
    """Samples of a resistance as a recording; its targets are zero throughout."""
    still = {channel: np.zeros(len(time_s)) for channel in (DISPLACEMENT, FORCE)}
    return Recording(time_s, {**still, RESISTANCE: resistance_ohm}, UNKNOWN_LENGTH_MM, source)


def check_tared(recording: Recording, target: str, reach_N: float | None = None) -> None:
    """Refuse a force that was never zeroed: its smallest value is further off than its whole range.

    Where the target is the displacement, nothing is read from the force, and it may be as it is. Of a reference,
    which may be short or stand still, `reach_N` takes the place of its range: how far from zero the training went.
    """
    if target != "force" or not recording.has(FORCE):
        return
    force_N = recording[FORCE]
    low, high = np.quantile(force_N, [0.01, 0.99])
    nearest = min(abs(low), abs(high)) if low * high > 0 else 0.0
    near = "near zero" if reach_N is None else f"within {reach_N:.3g} N of zero, as far as the training went"
    if nearest > (reach_N or high - low or np.inf):  # a constant is refused as one
        raise UserError(
            f"{recording.source}: force_N lies between {low:.3g} and {high:.3g} N and never comes {near}: it was not "
            "tared; take the reading of the unloaded cell off it (`testbench import`), or correct the column"
        )
