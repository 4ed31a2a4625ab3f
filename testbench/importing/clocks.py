"""Several clocks in one file: each channel has its own times, and all come onto those of one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from gcode.support.errors import UserError
from testbench.importing.layout import Column
from testbench.importing.vocabulary.roles import words_of

_TIME_WORDS = {"t", "time", "zeit", "timestamp", "s", "时间"}


def own_clocks(times: Sequence[Column], channels: Mapping[str, Column]) -> dict[str, Column] | None:
    """Each channel's own time column, by its name (``t_F`` beside ``F``), else by its place (left of its channel).

    None where neither tells.
    """
    found = {role: _by_name(times, role, column) for role, column in channels.items()}
    if all(found.values()) and found and len(set(map(id, found.values()))) > 1:
        return {role: column for role, column in found.items() if column is not None}
    if len({column.heading.base for column in times}) > 1 or not channels:
        return None
    left = {
        role: max((time for time in times if time.number < column.number), key=lambda time: time.number, default=None)
        for role, column in channels.items()
    }
    if None in left.values() or len({id(time) for time in left.values()}) != len(times):
        return None
    return {role: time for role, time in left.items() if time is not None}


def _by_name(times: Sequence[Column], role: str, channel: Column) -> Column | None:
    """The one time column whose other words are of the channel's name, or begin that of its role."""
    names = {*words_of(channel.heading.whole), role}
    fitting = []
    for time in times:
        others = [word for word in words_of(time.heading.whole) if word not in _TIME_WORDS]
        if others and all(any(name.startswith(word) for name in names) for word in others):
            fitting.append(time)
    return fitting[0] if len(fitting) == 1 else None


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
