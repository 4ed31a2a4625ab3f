"""NI TDMS files (LabVIEW, FlexLogger), read by npTDMS: channels with units of their own and clocks of their own."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gcode.support.errors import UserError
from testbench.importing.layout import find_layout
from testbench.importing.sheet import HEAD_ROWS, Hints, Sheet

if TYPE_CHECKING:
    import pandas as pd

MOST_WORDS = 200  # of what npTDMS objects to
Channel = tuple[str, str, np.ndarray]  # name, unit, values
Clock = tuple[float, float, np.datetime64 | None, int]  # step and offset in s, start, samples
_UNIT_PROPERTIES = ("unit_string", "NI_UnitDescription", "Unit", "unit")


@dataclass(frozen=True)
class ColumnSheet(Sheet):
    """Columns of which each is there as a whole: the channels of a TDMS file side by side."""

    columns: Sequence[np.ndarray]

    def body(self, numbers: Sequence[int]) -> pd.DataFrame:
        """The columns with these numbers; what ends earlier is filled up with nothing."""
        import pandas as pd

        return pd.DataFrame({number: pd.Series(self.columns[number - 1]) for number in sorted(set(numbers))})


def open_tdms(path: Path, hints: Hints) -> ColumnSheet:
    """Read a TDMS file. A waveform's clock becomes a column of its own, left of the channels that it times.

    Raises
    ------
    UserError
        If it is no TDMS file, holds no numbers, or has several groups and none was named.
    """
    channels = _channels(path, hints.sheet)
    shown = zip_longest(
        *([name, unit, *map(str, values[:HEAD_ROWS])] for name, unit, values in channels), fillvalue=""
    )
    head = [list(row) for row in shown]
    layout = find_layout(head, (), 1, 2)
    if layout is None:
        raise UserError(f"{path}: no channel of it holds numbers")
    columns = [values for _, _, values in channels]
    return ColumnSheet(path, head, layout, ".", "\t", {"group": hints.sheet or ""}, columns)


def _channels(path: Path, group: str | None) -> list[Channel]:
    # What npTDMS remarks about a broken file is bytes of that file.
    logging.getLogger("nptdms").setLevel(logging.CRITICAL)
    try:
        return _read(path, group)
    except UserError:
        raise
    except Exception as error:  # npTDMS raises whatever a broken file leads it to, running out of memory included
        reason = f"{type(error).__name__}: {error}"[:MOST_WORDS]
        raise UserError(f"{path}: not a TDMS file that can be read ({reason})") from None


def _read(path: Path, group: str | None) -> list[Channel]:
    import nptdms

    file = nptdms.TdmsFile.read(path)
    groups = [one for one in file.groups() if any(len(channel) for channel in one.channels())]
    if not groups:
        raise UserError(f"{path}: a TDMS file without a channel that holds numbers, or none at all")
    if group is not None:
        groups = [one for one in groups if one.name == group]
    if len(groups) != 1:
        have = ", ".join(repr(one.name) for one in file.groups())
        raise UserError(f"{path}: it has the groups {have}; say which one with --sheet NAME")
    return _side_by_side([channel for channel in groups[0].channels() if len(channel)])


def _side_by_side(channels: Sequence[Any]) -> list[Channel]:
    found: list[Channel] = []
    last_clock: Clock | None = None
    starts = [start for start in (_start(channel) for channel in channels) if start is not None]
    for channel in channels:
        values = np.asarray(channel[:])
        if values.dtype.kind not in "fiuM":
            continue
        clock = _clock(channel)
        if clock is not None and clock != last_clock:
            found.append(("Time", "s", _times_s(clock, min(starts, default=None))))
            last_clock = clock
        found.append((channel.name, _unit(channel), values))
    return found


def _unit(channel: Any) -> str:
    return next((str(channel.properties[key]) for key in _UNIT_PROPERTIES if channel.properties.get(key)), "")


def _start(channel: Any) -> np.datetime64 | None:
    start = channel.properties.get("wf_start_time")
    return None if start is None else np.datetime64(start)


def _clock(channel: Any) -> Clock | None:
    """The clock of a waveform; None where the channel is none."""
    step_s = channel.properties.get("wf_increment")
    if not step_s:
        return None
    return float(step_s), float(channel.properties.get("wf_start_offset", 0.0)), _start(channel), len(channel)


def _times_s(clock: Clock, first: np.datetime64 | None) -> np.ndarray:
    step_s, offset_s, start, count = clock
    later_s = 0.0 if start is None or first is None else (start - first) / np.timedelta64(1, "s")
    return later_s + offset_s + step_s * np.arange(count)
