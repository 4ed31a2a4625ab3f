"""Which rows of a damaged recording to believe: the most that run forward in time."""

from __future__ import annotations

from array import array
from bisect import bisect_left
from collections.abc import Sequence


def running_forward(times_us: Sequence[int]) -> bytearray:
    """One for each time that belongs to the longest run of rising ones, zero for the others.

    One wrong digit makes a row late or early among thousands that agree with each other: that row goes, not they.
    """
    ends_us, ends, before = array("q"), array("q"), array("q")  # the last time and row of the best run of each length
    for row, time_us in enumerate(times_us):
        if not ends or time_us > ends_us[-1]:
            before.append(ends[-1] if ends else -1)
            ends_us.append(time_us)
            ends.append(row)
        else:
            length = bisect_left(ends_us, time_us)
            before.append(ends[length - 1] if length else -1)
            ends_us[length], ends[length] = time_us, row
    kept = bytearray(len(times_us))
    row = ends[-1] if ends else -1
    while row >= 0:
        kept[row] = 1
        row = before[row]
    return kept
