"""The columns that were taken, as numbers in our units on one clock."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from gcode.support.errors import UserError
from testbench.importing.choice import UNIT_FLAGS, Choice, Taken
from testbench.importing.clocks import SUMMER_TIME_S, counters, on_one_clock, onward, unit_of_part
from testbench.importing.layout import Column, shortened
from testbench.importing.sheet import Sheet
from testbench.importing.tables_below import begins_of, names_again
from testbench.importing.trouble_words import unit_unknown
from testbench.importing.vocabulary.laboratory_units import OURS, Unit, conversion, unit_of
from testbench.importing.vocabulary.notation import (
    may_be_thousands,
    numbers,
    seconds,
    seconds_of_days,
    units_apart,
    whole_clocks,
    why_unclear,
)

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class Read:
    """What stands in the file, row by row.

    Attributes
    ----------
    rows : ndarray of int, shape (n,)
        Row of the file (from 1) that each entry came from; blank rows are left out.
    values : dict of str to ndarray, each shape (n,)
        By role, in our units; NaN where a cell is empty or no number. ``time`` is there unless the file has none.
    clocks : dict of str to ndarray, each shape (n,)
        Own times of the roles that have one, in s.
    wrong : list of str
        The first cell of each column that is no number, in words, with the remedy.
    words : dict of str to str
        What each role was taken from, with the conversion shown.
    notes : list of str
        What else was done.
    begins : list of int
        Entries before which the names stand once more in the file.
    """

    rows: np.ndarray
    values: dict[str, np.ndarray]
    clocks: dict[str, np.ndarray]
    wrong: list[str]
    words: dict[str, str]
    notes: list[str]
    begins: list[int]


def read_columns(sheet: Sheet, choice: Choice, thousands: str | None = None) -> Read:
    """Read and convert everything that was taken.

    Raises
    ------
    UserError
        If there are no rows below the header, another table begins below, or a clock of its own is given as dates.
    """
    needed = [column for one in choice.taken.values() for column in one.columns]
    days = {one.days.number for one in choice.taken.values() if one.days}
    frame = sheet.body([column.number for column in needed])
    rows = np.arange(len(frame)) + sheet.layout.first_row
    blank = sheet.blank(frame.drop(columns=list(days)))
    frame, rows = frame[~blank], rows[~blank]
    if not len(rows):
        raise UserError(f"{sheet.path}: there is nothing below the header in row {sheet.layout.first_row - 1}")
    between = names_again(sheet, choice, frame, rows)
    read = Read(rows[~between], {}, {}, [], {}, [], begins_of(between))
    if between.any():
        read.notes.append(f"no samples: row {rows[between.argmax()]} and others, where the names stand once more")
        frame = frame[~between]
    for role, one in choice.taken.items():
        cells = frame[one.column.number]
        if one.unit is None:
            found = _moments(one, cells, frame, read) + _parts(one, frame, sheet.decimal, read)
        else:
            plain, wrong = _numbers(one, cells, sheet.decimal, thousands)
            read.words[role] = _in_words(one, plain)
            if role == "time":
                plain = _onward(plain, counters(one.unit.factor), one.column, read)
            found = _each_converted(one, plain, frame, read) if one.units else one.unit.converted(plain)
            _note(read, one.column, cells, wrong, "a number", sheet.decimal)
        read.values[role] = found
        if one.clock is not None:
            read.clocks[role] = _own_clock(sheet, choice, one, frame[one.clock.number], thousands, read)
    return read


def _numbers(one: Taken, cells: pd.Series, decimal: str, thousands: str | None) -> tuple[np.ndarray, int | None]:
    """Numbers without the units behind them; ``4.7k`` is a number beneath a unit that has no prefix itself."""
    prefixes = one.unit is not None and one.unit.symbol in ("Ω", "N", "S")
    return numbers(units_apart(cells)[0] if one.units_behind else cells, decimal, thousands, prefixes)


def _each_converted(one: Taken, plain: np.ndarray, frame: pd.DataFrame, read: Read) -> np.ndarray:
    """Numbers in our unit, each from the unit that stands behind or beside it."""
    assert one.unit is not None
    assert one.units is not None
    cells = frame[one.units.number]
    texts = (units_apart(cells)[1] if one.units_behind else cells.astype("string").str.strip()).fillna("")
    found = np.full(len(plain), np.nan)
    for text in texts.unique():
        unit, here = unit_of(text, (one.unit.quantity,)), (texts == text).to_numpy(dtype=bool)
        if unit and (unit == one.unit or one.may_change):
            found[here] = unit.converted(plain[here])
    wrong = np.flatnonzero(np.isnan(found) & np.isfinite(plain))
    want = f"a unit of {one.role}" if one.may_change else f"{one.unit.symbol}, as {one.unit_from} says"
    _note(read, one.units, cells, int(wrong[0]) if wrong.size else None, "a number with " * one.units_behind + want)
    return found


def _moments(one: Taken, cells: pd.Series, frame: pd.DataFrame, read: Read) -> np.ndarray:
    """Dates and times, or times of day with the days beside them, in s."""
    of_days = ""
    if one.short:
        cells = whole_clocks(cells, one.short)
    if one.days is None:
        found, wrong = seconds(cells)
    else:
        found, wrong, wrong_day = seconds_of_days(cells, frame[one.days.number])
        of_days = f" of the days in {one.days.label}"
        _note(read, one.days, frame[one.days.number], wrong_day, "a date")
    _note(read, one.column, cells, wrong, "a date and time" if one.days is None else "a time of day")
    read.words[one.role] = f"{one.column.label}: dates and times{of_days}, in seconds from the first"
    return _onward(found, SUMMER_TIME_S, one.column, read)


def _parts(one: Taken, frame: pd.DataFrame, decimal: str, read: Read) -> np.ndarray | float:
    """The parts of a second that stand beside dates and times, in s; 0 where none do."""
    unit = unit_of_part(one.part) if one.part else None
    if one.part is None or unit is None:
        return 0.0
    parts_s = unit.converted(numbers(frame[one.part.number], decimal)[0])
    good = (parts_s >= 0) & (parts_s < 1)
    read.words[one.role] += f", with the parts of a second in {one.part.label}"
    _note(read, one.part, frame[one.part.number], None if good.all() else int(good.argmin()), "a part of a second")
    return np.where(good, parts_s, np.nan)


def _onward(times: np.ndarray, periods: Mapping[float, str], column: Column, read: Read) -> np.ndarray:
    times, said = onward(times, periods, read.rows)
    read.notes.extend([f"{column.label} {said}"] if said else [])
    return times


def previewed(sheet: Sheet, choice: Choice, thousands: str | None = None) -> dict[str, str]:
    """What each role is taken from, with the conversion of a first value shown, from the top of the file alone."""
    import pandas as pd

    body = sheet.head[sheet.layout.first_row - 1 :]
    words = {}
    for role, one in choice.taken.items():
        cells = [row[one.column.number - 1] if one.column.number <= len(row) else "" for row in body]
        if one.unit is None:
            is_date = one.unit_from and role == "time"
            words[role] = "dates and times, in seconds from the first" if is_date else ""
            continue
        values, _ = _numbers(one, pd.Series(cells, dtype="string"), sheet.decimal, thousands)
        there = np.isfinite(values).any()
        words[role] = conversion(_example(values), one.unit) if there else "no number at the top of the file"
    return words


def _own_clock(sheet: Sheet, choice: Choice, one: Taken, cells, thousands: str | None, read: Read) -> np.ndarray:
    main = choice.taken.get("time")
    assert one.clock is not None
    if main is None or main.unit is None:
        raise UserError(
            f"{sheet.path}: {one.column.label} has a clock of its own, and clocks beside each other must be in s, ms "
            "or the like, not dates; write them so, or leave --time-of out"
        )
    unit = _clock_unit(one.clock, main)
    if unit is None:
        raise UserError(
            f"{sheet.path}: {one.clock.label}, the times of {one.role}: "
            f"{unit_unknown(one.clock)}; say --time-unit, which all clocks that do not say theirs are in"
        )
    values, wrong = numbers(cells, sheet.decimal, thousands)
    _note(read, one.clock, cells, wrong, "a number", sheet.decimal)
    values = _onward(values, counters(unit.factor), one.clock, read)
    read.words[one.role] += (
        f"; its own times: {one.clock.label} in {unit.symbol}, brought to those of {main.column.label}"
    )
    return unit.converted(values)


def _clock_unit(clock: Column, main: Taken) -> Unit | None:
    """What the file says, or a person of all clocks; another clock's own unit says nothing of this one."""
    unit = clock.heading.unit(clock.unit_text)
    if unit is None and main.unit_from == UNIT_FLAGS["time"]:
        return main.unit
    return unit if unit is not None and unit.quantity == "time" else None


def _note(read: Read, column: Column, cells, wrong: int | None, kind: str, decimal: str = "") -> None:
    if wrong is None:
        return
    name, cell = shortened(column.heading.text) or column.label, str(cells.iloc[wrong])
    remedy = "--drop-bad leaves such rows out"
    if not decimal:
        remedy = why_unclear(cell) or remedy
    if decimal and may_be_thousands(cell, decimal):
        mark = "," if decimal == "." else "."
        remedy = f"if {mark!r} parts thousands, say --thousands {mark}; if it is the decimal sign, --decimal {mark}"
    read.wrong.append(f"row {read.rows[wrong]}: {name} must be {kind}, got {shortened(cell)!r}; {remedy}")


def _in_words(one: Taken, values: np.ndarray) -> str:
    """``column 4 'Widerstand' in kΩ (row 2): 439.377 kΩ read as 439 377 Ω``."""
    assert one.unit is not None
    text = f"{one.column.label} in {one.unit.symbol} ({one.unit_from})"
    if one.unit.symbol == "1":
        text = f"{one.column.label}, a ratio ({one.unit_from})"
    return text if one.unit.symbol == OURS[one.unit.quantity] else f"{text}: {conversion(_example(values), one.unit)}"


def _example(values: np.ndarray) -> float:
    """The first value that is not 0, if there is one."""
    return float(next(iter(values[np.isfinite(values) & (values != 0)]), 0.0))


def on_main_clock(sheet: Sheet, read: Read, time_s: np.ndarray, labels: Mapping[str, str], sort: bool) -> np.ndarray:
    """Bring channels with a clock of their own onto the main one, in place.

    Returns
    -------
    inside : ndarray of bool, shape (n,)
        Rows at which every channel has a value; before its first and after its last sample there is none.
    """
    inside = np.ones(len(time_s), dtype=bool)
    if read.clocks:  # below the end of the main clock, rows hold only what other clocks time
        mine = [values for role, values in read.values.items() if role not in read.clocks]
        inside = np.isfinite(np.column_stack([time_s, *mine])).any(axis=1)
    for role, own_s in read.clocks.items():
        read.values[role] = on_one_clock(sheet.path, time_s, own_s, read.values[role], labels[role], sort)
        inside &= np.isfinite(read.values[role]) | ~np.isfinite(time_s)
    return inside
