"""A foreign file becomes a recording: columns and units as the file or a person says, never as we would like them.

The pieces are in `testbench.recordings`: how the file is written (`sheet`, `layout`), which column is what
(`choice`), its numbers in our units (`columns`), zero and sign (`signs`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from gcode.support.errors import UserError
from gcode.support.files import make_folder, sha256_of
from testbench.importing.choice import ELECTRICAL, FLAGS, NAMED, NOT_THERE, Choice, Said, choose, in_words
from testbench.importing.columns import Read, on_main_clock, read_columns
from testbench.importing.gauge import gauge_doubt
from testbench.importing.layout import Column, misfit
from testbench.importing.notation import numbers
from testbench.importing.opening import open_sheet
from testbench.importing.repeats import repeats_of
from testbench.importing.sheet import Hints, Sheet
from testbench.importing.signs import SIGNED, TURNED, doubts, zero_of
from testbench.importing.units import units_spelt
from testbench.importing.words import STRETCH, counts_repeats, speaks_about
from testbench.recordings.channels import DISPLACEMENT, FORCE, RESISTANCE, TEMPERATURE, TIME
from testbench.recordings.checks import such
from testbench.recordings.files import write_recording_csv
from testbench.recordings.manifest import Campaign, write_manifest
from testbench.recordings.recording import Recording
from testbench.recordings.versions import software_versions

SLOWEST_HZ = 0.1
MANY_TIMES = 6.0  # R0; a change of 5 % that was read as 5. Cracked films do go further, so it is only said
MOSTLY = 0.5  # of the rows negative: the resistance has the wrong sign, and no bad rows


@dataclass(frozen=True)
class Wish:
    """What a person says about a foreign file; all else is read from it.

    Attributes
    ----------
    gauge_length_mm : float or None
        Needed where the file has a displacement or strain.
    columns : mapping of str to str
        By role (`testbench.importing.words.ROLES`): the column's name, or its number from 1; ``none``: not there.
    units : mapping of str to str
        By role, in place of what the file says; ``date`` for a time of dates.
    rate_hz : float, optional
        Sampling rate of a file without a time column.
    time_of : mapping of str to str
        By role: the column of its own times, where the file has several clocks.
    r0_ohm : float, optional
        R0 of ``relative`` (R/R0) and ``relative_change`` ((R - R0)/R0).
    negate : frozenset of str
        Roles whose sign is turned.
    zero : mapping of str to (str or None)
        Roles that are counted from their first sample (None), or from a value in the file's unit (or with its own).
    repeat : int, optional
        Of several repeats in the file, this one.
    sort : bool
        Put rows in the order of time and drop repeated times.
    drop_bad : bool
        Leave out rows with a value that cannot be used.
    hints : Hints
        How the file is written.
    """

    gauge_length_mm: float | None = None
    columns: Mapping[str, str] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    rate_hz: float | None = None
    time_of: Mapping[str, str] = field(default_factory=dict)
    r0_ohm: float | None = None
    negate: frozenset[str] = frozenset()
    zero: Mapping[str, str | None] = field(default_factory=dict)
    repeat: int | None = None
    sort: bool = False
    drop_bad: bool = False
    hints: Hints = field(default_factory=Hints)

    def said(self) -> Said:
        """What it says about columns."""
        return Said(self.columns, self.units, self.time_of, self.rate_hz is not None, self.r0_ohm is not None)

    def names(self) -> list[str]:
        """Columns that were given by name."""
        every = [*self.columns.values(), *self.time_of.values()]
        return [name for name in dict.fromkeys(every) if name != NOT_THERE and not name.strip().isdigit()]


@dataclass
class Imported:
    """A recording, and what was done to get it.

    Attributes
    ----------
    recording : Recording
    label : str
        Number of the repeat, where the file has several; else empty.
    dropped : int
        Rows left out because of a value that cannot be used.
    moved, repeated : int
        Rows that were out of order; rows whose time came twice.
    time_offset_s : float
        Subtracted from the file's times, so that the first sample is at 0.
    taken : dict of str to str
        What was taken for what, with the conversion shown.
    doubts : list of str
        What looks wrong, with the remedy.
    notes : list of str
        What else was done or left out.
    details : dict
        For the manifest.
    """

    recording: Recording
    label: str = ""
    dropped: int = 0
    moved: int = 0
    repeated: int = 0
    time_offset_s: float = 0.0
    taken: dict[str, str] = field(default_factory=dict)
    doubts: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    details: dict[str, Any] = field(default_factory=dict)


def look(path: Path, wish: Wish) -> tuple[Sheet, Choice]:
    """What the file looks like, and what each column would be taken for, troubles included.

    Raises
    ------
    UserError
        If the file cannot be read, or a column or unit that `wish` names is not there.
    """
    sheet = open_sheet(path, wish.names(), wish.hints)
    if shifted := misfit(sheet.head, sheet.layout):
        raise UserError(
            f"{path}: {shifted}: which name belongs to which column cannot be told; mend the file, or say "
            "--header-row 0 and --units-row 0 and give columns by number"
        )
    try:
        return sheet, choose(sheet.layout, sheet.head, wish.said())
    except UserError as error:
        raise UserError(f"{path}: {error}") from None


def import_file(path: Path, wish: Wish) -> list[Imported]:
    """Read a foreign file: one recording, or one a repeat.

    Raises
    ------
    UserError
        If a column or its unit is not clear, or a row cannot be used and `wish` does not say to drop it. The message
        names file, row and remedy.
    """
    sheet, choice = look(path, wish)
    if choice.troubles:
        first = sheet.head[sheet.layout.first_row - 1]
        raise UserError(f"{path}: {in_words(choice.troubles, sheet.layout, first)}")
    if wish.gauge_length_mm is None and STRETCH & set(choice.taken):
        raise UserError(
            f"{path}: the gauge length is not known: say --gauge-length-mm, the length between the clamps at rest"
        )
    read = read_columns(sheet, choice, wish.hints.thousands)
    if read.wrong and not wish.drop_bad:
        raise UserError(f"{path}: {read.wrong[0]}")
    time_s = read.values.get("time", (read.rows - read.rows[0]) / float(wish.rate_hz or 1.0))
    parts = _parts(sheet, choice, wish, read, time_s)
    labels = {role: choice.taken[role].column.label for role in choice.taken}
    inside = on_main_clock(sheet, read, time_s, labels, wish.sort)
    return [_recorded(sheet, choice, wish, read, time_s, rows[inside[rows]], label) for label, rows in parts]


def import_csv(path: Path, wish: Wish) -> Imported:
    """Read a foreign file that holds one recording.

    Raises
    ------
    UserError
        As `import_file`; or if the file holds several repeats.
    """
    done = import_file(path, wish)
    if len(done) > 1:
        raise UserError(f"{path}: holds {len(done)} repeats; say which one with --repeat N")
    return done[0]


def _parts(sheet: Sheet, choice: Choice, wish: Wish, read: Read, time_s: np.ndarray) -> list[tuple[str, np.ndarray]]:
    """The repeats that a column numbers, where the time starts again with each; else the whole."""
    whole = [("", np.arange(len(time_s)))]
    restarts = bool((np.diff(time_s) < 0).any())
    counters = [column for column in choice.unused if counts_repeats(column.heading.base)]
    if not counters or (wish.repeat is None and (wish.sort or not restarts)):
        if wish.repeat is not None:
            raise UserError(f"{sheet.path}: no column numbers repeats; leave --repeat out")
        return whole
    for column in counters:
        frame = sheet.body([column.number])
        counter, _ = numbers(frame[column.number], sheet.decimal)
        parts = repeats_of(counter[read.rows - sheet.layout.first_row], time_s)
        if parts and wish.repeat is None:
            return parts
        chosen = [part for part in parts if part[0] == str(wish.repeat)]
        if chosen:
            return chosen
    if wish.repeat is not None:
        raise UserError(f"{sheet.path}: no repeat {wish.repeat} with a time of its own")
    return whole


def _recorded(
    sheet: Sheet, choice: Choice, wish: Wish, read: Read, time_s: np.ndarray, rows: np.ndarray, label: str
) -> Imported:
    """One recording from some of the rows."""
    path = sheet.path
    numbers_of = read.rows[rows]
    scaled = {role: values[rows] for role, values in read.values.items()}
    if not wish.drop_bad:
        _check_change(path, numbers_of, choice, scaled)
    channels = _channels(scaled, wish)
    kept = _usable(path, numbers_of, time_s[rows], channels, wish.drop_bad)
    order, moved, repeated = _in_order(path, numbers_of[kept], time_s[rows][kept], wish.sort)
    index = np.flatnonzero(kept)[order]
    if len(index) < 2:
        raise UserError(f"{path}: {len(index)} of {len(rows)} rows can be used, a recording needs at least 2")
    when_s = time_s[rows][index]
    picked = {name: values[index] for name, values in channels.items()}
    told = _zeroed(picked, choice, wish)
    told += _turned(picked, choice, wish)
    recording = Recording(when_s - when_s[0], picked, _gauge_mm(wish, picked), str(path))
    done = Imported(recording, label, int((~kept).sum()), moved, repeated, float(when_s[0]), dict(read.words))
    strained = gauge_doubt(sheet, choice, read, wish.gauge_length_mm)
    done.doubts = [*_doubts(choice, recording, wish), *([strained] if strained else [])]
    done.notes = [*choice.notes, *told, *_remarks(choice, recording)]
    done.details = _details(sheet, choice, wish, done)
    return done


def _gauge_mm(wish: Wish, channels: Mapping[str, np.ndarray]) -> float:
    return float(wish.gauge_length_mm) if wish.gauge_length_mm and DISPLACEMENT in channels else np.nan


def _signed(flag: str, role: str, allowed: Sequence[str], choice: Choice) -> None:
    if role not in allowed or role not in choice.taken:
        have = ", ".join(one for one in allowed if one in choice.taken) or "nothing that has a sign"
        raise UserError(f"{flag} can be said of {have}, got {role}")


def _turned(picked: dict[str, np.ndarray], choice: Choice, wish: Wish) -> list[str]:
    """Turn the signs that `wish` says, in place (a resistance was turned as it was read); what was done, in words."""
    for role in wish.negate:
        _signed("--negate", role, TURNED, choice)
        if role in SIGNED:
            name = DISPLACEMENT if role in STRETCH else FORCE
            picked[name] = 0.0 - picked[name]
    return [f"the sign of {role} was turned" for role in sorted(wish.negate)]


def _zeroed(picked: dict[str, np.ndarray], choice: Choice, wish: Wish) -> list[str]:
    """Count displacement and force from where `wish` says, in place; what was done, in words."""
    told = []
    for role, text in wish.zero.items():
        _signed("--zero", role, SIGNED, choice)
        name = DISPLACEMENT if role in STRETCH else FORCE
        unit = choice.taken[role].unit
        assert unit is not None
        if text is None:
            zero = float(picked[name][0])
            told.append(f"{role} is counted from its first sample, {zero:.6g} {name.rpartition('_')[2]}")
        else:
            zero, words = zero_of(role, text, unit)
            zero *= float(wish.gauge_length_mm or 1.0) if role == "strain" else 1.0
            told.append(words)
        picked[name] = picked[name] - zero
    return told


def _doubts(choice: Choice, recording: Recording, wish: Wish) -> list[str]:
    """What looks wrong, or cannot be seen in such a recording."""
    said = doubts(recording.channels, wish.negate)
    if recording.mean_rate_hz < SLOWEST_HZ:
        said.append(
            f"one sample in {1 / recording.mean_rate_hz:.0f} s: models are tried down to one in "
            f"{1 / SLOWEST_HZ:.0f} s, and what is faster than the samples cannot be seen"
        )
    one = choice.taken.get("relative_change")
    if one is not None and one.unit_from == NAMED and recording[RESISTANCE].max() > MANY_TIMES * (wish.r0_ohm or 1.0):
        times = recording[RESISTANCE].max() / (wish.r0_ohm or 1.0)
        said.append(f"{one.column.label} reaches {times:.0f} times R0; if it is in %, say --relative-unit %")
    return [*said, *_overlooked(choice)]


def _overlooked(choice: Choice) -> list[str]:
    """Columns of no known name (``DMM [kΩ]``) whose unit is that of something which was not found."""
    missing = {"force": ("force",), "resistance": ("resistance", "conductance")}
    said = []
    for role, quantities in missing.items():
        if set(choice.taken) & ({role} if role == "force" else set(ELECTRICAL)):
            continue
        for column in choice.unused:
            units = {unit.quantity: unit for unit in units_spelt(column.unit_text)}
            fits = [quantity for quantity in quantities if quantity in units]
            if len(units) == 1 and fits and not speaks_about(column.heading.whole):
                said.append(
                    f"no {role} was found by its name, and {column.label} is in {units[fits[0]].symbol}: "
                    f"if it is the {fits[0]}, say {FLAGS[fits[0]]} {column.number}"
                )
    return said


def _remarks(choice: Choice, recording: Recording) -> list[str]:
    """What was not there, and what was not used."""
    said = []
    missing = [name for name in (DISPLACEMENT, FORCE, RESISTANCE) if not recording.has(name)]
    if missing:
        said.append(f"without {' and '.join(missing)}: no column was found for it")
    if choice.unused:
        said.append(f"not used: {', '.join(column.label for column in choice.unused[:12])}")
    return said


def _details(sheet: Sheet, choice: Choice, wish: Wish, done: Imported) -> dict[str, Any]:
    columns = {
        role: {
            "column": _named(one.column),
            "number": one.column.number,
            "unit": one.unit.symbol if one.unit else "date",
            "factor": one.unit.factor if one.unit else 1.0,
            "offset": one.unit.offset if one.unit else 0.0,
        }
        | ({"clock": _named(one.clock)} if one.clock else {})
        for role, one in choice.taken.items()
    }
    details: dict[str, Any] = {"file": sheet.path.name, "sha256": sha256_of(sheet.path), "columns": columns}
    details |= {"r0_ohm": wish.r0_ohm, **sheet.details, "header_row": sheet.layout.header_row}
    details |= {"units_row": sheet.layout.units_row, "negate": sorted(wish.negate), "zero": dict(wish.zero)}
    return details | ({"repeat": done.label} if done.label else {}) | {"doubts": done.doubts, "notes": done.notes}


def _named(column: Column) -> str:
    """A column's name, or its number; names longer than a line are cut."""
    return (column.heading.text or str(column.number))[:300]


def place_of(out: Path, label: str) -> Path:
    """Where a repeat goes: ``knit-3`` for ``knit``, ``knit-3.csv`` for ``knit.csv``."""
    return out.with_name(f"{out.stem}-{label}{out.suffix}") if label else out


def write_import(imported: Imported, out: Path) -> None:
    """Write a plain ``.csv``, or a campaign folder."""
    if out.suffix.lower() == ".csv":
        write_recording_csv(out, imported.recording)
        return
    make_folder(out)
    write_recording_csv(out / "recording.csv", imported.recording)
    recipe = {"import": imported.details, "time_offset_s": imported.time_offset_s}
    counts = {"samples": len(imported.recording), "dropped": imported.dropped}
    counts |= {"moved": imported.moved, "repeated": imported.repeated}
    gauge = imported.recording.gauge_length_mm
    campaign = Campaign(gauge, "imported", "complete", recipe, counts, software_versions())
    write_manifest(out, campaign, ["recording.csv"])


def _channels(scaled: Mapping[str, np.ndarray], wish: Wish) -> dict[str, np.ndarray]:
    channels = {}
    if "displacement" in scaled:
        channels[DISPLACEMENT] = scaled["displacement"]
    elif "strain" in scaled:
        channels[DISPLACEMENT] = scaled["strain"] * float(wish.gauge_length_mm or 1.0)
    if "force" in scaled:
        channels[FORCE] = scaled["force"]
    resistance = _resistance(scaled, wish.r0_ohm or np.nan)
    if resistance is not None:
        channels[RESISTANCE] = -resistance if "resistance" in wish.negate else resistance
    if "temperature" in scaled:
        channels[TEMPERATURE] = scaled["temperature"]
    return channels


def _resistance(scaled: Mapping[str, np.ndarray], r0_ohm: float) -> np.ndarray | None:
    if "resistance" in scaled:
        return scaled["resistance"]
    if "conductance" in scaled:
        with np.errstate(divide="ignore"):
            return 1.0 / scaled["conductance"]
    if "relative" in scaled:
        return scaled["relative"] * r0_ohm
    if "relative_change" in scaled:
        return (1.0 + scaled["relative_change"]) * r0_ohm
    return None


def _check_change(path: Path, rows: np.ndarray, choice: Choice, scaled: Mapping[str, np.ndarray]) -> None:
    """A resistance cannot fall by more than itself: percent were taken for shares."""
    change = scaled.get("relative_change", np.zeros(0))
    below = np.flatnonzero(change <= -1)
    one = choice.taken.get("relative_change")
    if below.size and one is not None and one.unit is not None and one.unit.symbol == "1":
        raise UserError(
            f"{path}: row {rows[below[0]]}: {one.column.label} is {change[below[0]]:g}, and no resistance falls by "
            "more than itself (-1); if the column is in %, say --relative-unit %"
        )


def _usable(
    path: Path, rows: np.ndarray, time_s: np.ndarray, channels: Mapping[str, np.ndarray], drop_bad: bool
) -> np.ndarray:
    good = np.ones(len(rows), dtype=bool)
    for name, values in {TIME: time_s, **channels}.items():
        fine = np.isfinite(values)
        if name == RESISTANCE:
            fine &= values > 0
        if not fine.all() and not drop_bad:
            first = int(np.flatnonzero(~fine)[0])
            want = "positive and finite" if name == RESISTANCE else "a finite number"
            remedy = "--drop-bad leaves them out"
            if name == RESISTANCE and (values < 0).mean() > MOSTLY:
                remedy = "if its leads were the other way round, add --negate resistance"
            raise UserError(
                f"{path}: row {rows[first]}: {name} must be {want}, got {values[first]:g} "
                f"({such(int((~fine).sum()))}); {remedy}"
            )
        good &= fine
    return good


def _in_order(path: Path, rows: np.ndarray, time_s: np.ndarray, sort: bool) -> tuple[np.ndarray, int, int]:
    steps = np.diff(time_s)
    if (steps > 0).all():
        return np.arange(len(time_s)), 0, 0
    if not sort:
        at = int(np.flatnonzero(steps <= 0)[0]) + 1
        raise UserError(
            f"{path}: row {rows[at]}: time must increase, got {time_s[at]:g} s after {time_s[at - 1]:g} s; "
            + _about_time(time_s, at)
        )
    order = np.argsort(time_s, kind="stable")
    moved = int((order != np.arange(len(order))).sum())
    first = np.concatenate([[True], np.diff(time_s[order]) > 0])
    return order[first], moved, int((~first).sum())


def _about_time(time_s: np.ndarray, at: int) -> str:
    """Rows out of order, or a second recording below the first?"""
    if at > 10 and time_s[at] - time_s[0] < 0.01 * (time_s[at - 1] - time_s[0]):
        return "the time starts again there, so the file holds several recordings: part it into one file each"
    return "--sort puts rows in order and drops repeated times"
