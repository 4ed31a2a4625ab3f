"""The clocks of a file: those that begin anew, and several, of which each channel has its own."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np

from gcode.support.errors import UserError
from testbench.importing.layout import Column
from testbench.importing.vocabulary.laboratory_units import Unit, unit_of, units_spelt
from testbench.importing.vocabulary.roles import words_of

_TIME_WORDS = {"t", "time", "zeit", "timestamp", "s", "时间"}
FAR = 10  # steps: more than a clock goes on by from one row to the next
_WITH_PARTS = re.compile(r":\d{2}[.,]\d|:\d{2}:\d{2}:\d")  # 57.25 or 57:250
SUMMER_TIME_S = {3600.0: "1 h"}  # by which the time of day falls back in autumn


def counters(unit_s: float) -> dict[float, str]:
    """By what a counter of ticks may fall back, in units of `unit_s`: some programs write one of µs in ms or s."""
    return {2.0**16: "2^16", 2.0**32: "2^32", 2.0**32 * 1e-6 / unit_s: "2^32 µs"}


def onward(times: np.ndarray, periods: Mapping[float, str], rows: np.ndarray) -> tuple[np.ndarray, str]:
    """Times that go on where a counter began anew, or a clock was set back; and what was done, in words.

    It did where the time falls back by a period, but for a step such as the others.

    Parameters
    ----------
    times : ndarray, shape (n,)
        As the file has them; NaN where a cell is none.
    periods : mapping of float to str
        By which it may fall back, and how they are called.
    rows : ndarray of int, shape (n,)
        Of the file.
    """
    there = np.flatnonzero(np.isfinite(times))
    steps = np.diff(times[there])
    far = FAR * float(np.median(steps[steps > 0])) if (steps > 0).any() else np.inf
    for period, called in periods.items():
        again = (steps < 0) & (steps + period >= 0) & (steps + period <= far)
        if period > 2 * far and again.any():
            later = np.zeros(len(times))
            later[there[1:]] = period * np.cumsum(again)
            first = rows[there[1:][again][0]]
            return times + later, f"falls back by {called} in row {first}, and was taken to go on"
    return times, ""


def unit_of_part(column: Column) -> Unit | None:
    """The unit of a column that may be of parts of a second: what it says, or s where its name speaks of time."""
    found = [unit for unit in units_spelt(column.unit_text) if unit.quantity == "time"]
    return found[0] if found else unit_of("s", ("time",)) if "time" in column.heading.roles else None


def are_parts(seen: Sequence[tuple[str, str]], unit_s: float) -> bool:
    """Whether numbers beside times in whole seconds are parts of them: they rise until the second is another.

    Parameters
    ----------
    seen : sequence of (str, str)
        A time and the number beside it, row by row.
    unit_s : float
        What the numbers count.
    """
    try:
        parts = np.array([float(part.replace(",", ".")) for _, part in seen]) * unit_s
    except ValueError:
        return False
    if len(parts) < 2 or parts.min() < 0 or parts.max() >= 1 or any(_WITH_PARTS.search(clock) for clock, _ in seen):
        return False
    same = np.array([one[0] == next_one[0] for one, next_one in pairwise(seen)])
    steps = np.diff(parts)
    return bool((steps[same] > 0).all() and (steps < 0).any())


def own_clocks(times: Sequence[Column], channels: Mapping[str, Column]) -> dict[str, Column] | None:
    """Each channel's own time column, by its name (``t_F`` beside ``F``), else by its place (left of its channel).

    None where neither tells, as where a time that has a name of its own is nobody's by name.
    """
    found = {role: _by_name(times, role, column) for role, column in channels.items()}
    if all(found.values()) and found and len(set(map(id, found.values()))) > 1:
        return {role: column for role, column in found.items() if column is not None}
    named = {id(time) for time in found.values() if time is not None}
    if (len({column.heading.base for column in times}) > 1 and len(named) < len(times)) or not channels:
        return None
    left = {
        role: found[role]
        or max((time for time in times if time.number < column.number), key=lambda time: time.number, default=None)
        for role, column in channels.items()
    }
    if None in left.values() or len({id(time) for time in left.values()}) != len(times):
        return None
    return {role: time for role, time in left.items() if time is not None}


def _by_name(times: Sequence[Column], role: str, channel: Column) -> Column | None:
    """The one time column whose other words are of the channel's name, or begin that of its role."""
    names = {*words_of(channel.heading.whole), role}
    others = [[word for word in words_of(time.heading.whole) if word not in _TIME_WORDS] for time in times]
    begun = [bool(words) and all(any(name.startswith(word) for name in names) for word in words) for words in others]
    return times[begun.index(True)] if sum(begun) == 1 else None


def on_one_clock(
    path: object, time_s: np.ndarray, own_s: np.ndarray, values: np.ndarray, label: str, sort: bool
) -> np.ndarray:
    """A channel at the times of the main clock, by linear interpolation; NaN before its first and after its last.

    Parameters
    ----------
    path
        Named in messages.
    time_s : ndarray, shape (n,)
        The main clock.
    own_s, values : ndarray, each shape (m,)
        The channel's own times, and its values; entries where both are missing do not count.
    label : str
        What the channel is called in messages.
    sort : bool
        Put its samples in order and drop repeated times.

    Raises
    ------
    UserError
        If its times do not increase, or nothing is left.
    """
    there = np.isfinite(own_s) & np.isfinite(values)
    own_s, values = own_s[there], values[there]
    if sort:
        own_s, first = np.unique(own_s, return_index=True)
        values = values[first]
    if len(own_s) < 2:
        raise UserError(f"{path}: {label} has fewer than 2 samples with a time of their own")
    if (np.diff(own_s) <= 0).any():
        raise UserError(f"{path}: the times of {label} must increase; --sort puts them in order")
    found = np.interp(time_s, own_s, values)
    return np.where((time_s >= own_s[0]) & (time_s <= own_s[-1]), found, np.nan)
