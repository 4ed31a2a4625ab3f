"""A foreign file becomes a recording: columns and units as the file or a person says, never as we would like them.

Step by step: how the file is written (`sheet`, `layout`), which column is what (`choosing`), its numbers in our units
(`columns`), the rows that can be used and their order (`rows`), zero and sign (`signs`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from gcode.support.errors import UserError
from gcode.support.files import sha256_of
from gcode.support.strict import check_plain
from testbench.importing.choice import ELECTRICAL, FLAGS, NAMED, Choice
from testbench.importing.choosing import choose
from testbench.importing.columns import Read, on_main_clock, read_columns
from testbench.importing.files import first_bytes, json_file, page_file
from testbench.importing.files.cells import sheet_of
from testbench.importing.imported import Imported
from testbench.importing.layout import Column, misfit
from testbench.importing.rows import (
    channels_of,
    check_change,
    in_order,
    labels_in,
    mostly_one_gap,
    repeats_of,
    restarts,
    runs_of,
    usable,
    zero_set_anew,
)
from testbench.importing.sheet import Hints, Sheet
from testbench.importing.side_by_side import specimens
from testbench.importing.signs import doubts, gauge_doubts, turned, zeroed
from testbench.importing.tables_above import left_out, passed_over
from testbench.importing.trouble_words import idle_words, in_words
from testbench.importing.vocabulary.laboratory_units import units_spelt
from testbench.importing.vocabulary.roles import STRETCH, counts_repeats, speaks_about
from testbench.importing.wish import Wish
from testbench.recordings.channels import DISPLACEMENT, FORCE, RESISTANCE
from testbench.recordings.checks import check, known_length
from testbench.recordings.csv_columns import MOST_BYTES
from testbench.recordings.doubts import slow
from testbench.recordings.recording import Recording

MANY_TIMES = 6.0  # R0; a change of 5 % that was read as 5. Cracked films do go further, so it is only said

# Channels, what their columns are measured in, and the roles that give one.
CHANNELS = (
    (DISPLACEMENT, ("length",), STRETCH),
    (FORCE, ("force",), {"force"}),
    (RESISTANCE, ("resistance", "conductance"), set(ELECTRICAL)),
)


def look(path: Path, wish: Wish) -> tuple[Sheet, Choice]:
    """What the file looks like, and what each column would be taken for, troubles included.

    Of specimens side by side, it is the one that `wish` names, or the first.

    Raises
    ------
    UserError
        If the file cannot be read, or a column or unit that `wish` names is not there.
    """
    _, sheet, choice = _looked_at(path, wish)[0]
    return sheet, choice


def _looked_at(path: Path, wish: Wish) -> list[tuple[str, Sheet, Choice]]:
    """As `look`, for each specimen with its number."""
    sheet = _opened(path, wish.names(), wish.hints)
    if shifted := misfit(sheet.head, sheet.layout, whole_names=sheet.separator == "\t"):
        raise UserError(
            f"{path}: {shifted}: which name belongs to which column cannot be told; mend the file, or say "
            "--header-row 0 and --units-row 0 and give columns by number"
        )
    if not wish.hints.header_row and (lost := left_out(sheet.head, sheet.layout)):
        raise UserError(f"{path}: {lost}")
    try:
        found = [
            (label, replace(sheet, layout=layout), choose(layout, sheet.head, wish))
            for label, layout in specimens(sheet.layout, wish)
        ]
    except UserError as error:
        raise UserError(f"{path}: {error}") from None
    for _, one, choice in found:
        choice.notes += passed_over(one.head, one.layout)
    return found


def _opened(path: Path, wanted: Sequence[str], hints: Hints) -> Sheet:
    """Read the top of a file and find its layout.

    Raises
    ------
    UserError
        If it cannot be read, or has no numbers.
    """
    check_plain(path, "table", MOST_BYTES)
    kind = first_bytes.kind_of(path)
    if kind == first_bytes.WORKBOOK:
        from testbench.importing.files.excel_file import open_excel

        return open_excel(path, wanted, hints)
    if kind == first_bytes.TDMS:
        from testbench.importing.files.tdms_file import open_tdms

        return open_tdms(path, hints)
    if kind == first_bytes.PAGE:
        return sheet_of(path, page_file.tables_in(path, hints.encoding), wanted, hints)
    if kind == first_bytes.JSON and (tables := json_file.tables_in(path, hints.encoding)):
        return sheet_of(path, tables, wanted, hints, named=True)
    if hints.sheet:
        raise UserError(
            "`sheet` is of a workbook or a TDMS file (or HTML, JSON), which this is not; leave it out, "
            f"got {hints.sheet!r}"
        )
    if kind == first_bytes.PARQUET:
        from testbench.importing.files.parquet_file import open_parquet

        return open_parquet(path)
    from testbench.importing.files.text_file import open_text

    return open_text(path, wanted, hints)


def import_file(path: Path, wish: Wish) -> list[Imported]:
    """Read a foreign file: one recording, or one a repeat.

    Raises
    ------
    UserError
        If a column or its unit is not clear, or a row cannot be used and `wish` does not say to drop it. The message
        names file, row and remedy.
    """
    found = _looked_at(path, wish)
    if found[0][0]:  # the number of a specimen, which is the repeat that was named
        wish = replace(wish, repeat=None)
    return [one for specimen in found for one in _of_one(*specimen, wish)]


def _of_one(specimen: str, sheet: Sheet, choice: Choice, wish: Wish) -> list[Imported]:
    path = sheet.path
    if choice.troubles:
        first = sheet.head[sheet.layout.first_row - 1]
        said = [in_words(choice.troubles, sheet.layout, first)]
        if any(trouble.kind == "absent" for trouble in choice.troubles):
            said += _overlooked(choice, wish)
        raise UserError(f"{path}: {'; '.join(said)}")
    if idle := idle_words(choice, wish):
        raise UserError(f"{path}: {idle}")
    if wish.gauge_length_mm is None and STRETCH & set(choice.taken):
        raise UserError(
            f"{path}: the gauge length is not known: say --gauge-length-mm, the length between the clamps at rest"
        )
    read = read_columns(sheet, choice, wish.hints.thousands)
    if read.wrong and not wish.drop_bad:
        raise UserError(f"{path}: {read.wrong[0]}")
    change = choice.taken.get("relative_change")
    if change and change.unit and change.unit.quantity == "resistance":
        read.values["relative_change"] /= float(wish.r0_ohm or np.nan)
    time_s = read.values["time"] if "time" in read.values else _at_rate(sheet, read, float(wish.rate_hz or 1.0))
    parts = _parts(sheet, choice, wish, read, time_s)
    labels = {role: choice.taken[role].column.label for role in choice.taken}
    inside = on_main_clock(sheet, read, time_s, labels, wish.sort)
    if read.clocks and not inside.any():
        others = ", ".join(labels[role] for role in read.clocks)
        raise UserError(
            f"{path}: the clocks do not overlap: at no time of {labels['time']} is there a sample of every one of "
            f"{others}; see --time-of, or leave one of them out with none"
        )
    return [
        _recorded(sheet, choice, wish, read, time_s, rows[inside[rows]], "-".join(filter(None, (specimen, label))))
        for label, rows in parts
    ]


def _at_rate(sheet: Sheet, read: Read, rate_hz: float) -> np.ndarray:
    """The times of samples that were taken at a rate, in s: blank lines are none, rows of no use are."""
    if (np.diff(read.rows) == 1).all():
        return (read.rows - read.rows[0]) / rate_hz
    filled = ~sheet.blank(sheet.body([column.number for column in sheet.layout.columns]))
    sample = np.cumsum(filled)[read.rows - sheet.layout.first_row]
    return (sample - sample[0]) / rate_hz


def _parts(sheet: Sheet, choice: Choice, wish: Wish, read: Read, time_s: np.ndarray) -> list[tuple[str, np.ndarray]]:
    """The repeats that a column numbers, where the time starts again with each, or below names; else the whole.

    Where nothing but the time tells them, they are repeats for who names one.
    """
    found = _numbered(sheet, choice, read, time_s) if wish.repeat is not None or not wish.sort else []
    found = found or runs_of(read.begins, time_s)
    if wish.repeat is None:
        return found or [("", np.arange(len(time_s)))]
    found = found or runs_of(restarts(time_s), time_s)
    if chosen := [part for part in found if part[0] == str(wish.repeat)]:
        return chosen
    numbers = f"; it has {', '.join(label for label, _ in found)}" if found else " with a time of its own"
    raise UserError(f"{sheet.path}: no repeat {wish.repeat}{numbers}; leave --repeat out")


def _numbered(sheet: Sheet, choice: Choice, read: Read, time_s: np.ndarray) -> list[tuple[str, np.ndarray]]:
    if (np.diff(time_s) < 0).any():
        for column in (column for column in choice.unused if counts_repeats(column.heading.base)):
            labels = labels_in(sheet.body([column.number])[column.number], sheet.decimal)
            if parts := repeats_of(labels[read.rows - sheet.layout.first_row], time_s):
                return parts
    return []


def _recorded(
    sheet: Sheet, choice: Choice, wish: Wish, read: Read, time_s: np.ndarray, rows: np.ndarray, label: str
) -> Imported:
    """One recording from some of the rows."""
    path = sheet.path
    numbers_of = read.rows[rows]
    scaled = {role: values[rows] for role, values in read.values.items()}
    if not wish.drop_bad:
        check_change(path, numbers_of, choice, scaled)
    channels = channels_of(scaled, wish)
    kept = usable(path, numbers_of, time_s[rows], channels, wish, scaled)
    order, moved, repeated = in_order(path, numbers_of[kept], time_s[rows][kept], wish.sort)
    index = np.flatnonzero(kept)[order]
    if len(index) < 2:
        raise UserError(f"{path}: {len(index)} of {len(rows)} rows can be used, a recording needs at least 2")
    when_s = time_s[rows][index]
    picked = {name: values[index] for name, values in channels.items()}
    told = zeroed(picked, choice, wish)
    told += turned(picked, choice, wish)
    gauge_mm = known_length(wish.gauge_length_mm or None, str(path)) if DISPLACEMENT in picked else np.nan
    check(str(path), when_s - when_s[0], picked, gauge_mm, lambda place: f"row {numbers_of[index[place]]}")
    recording = Recording(when_s - when_s[0], picked, gauge_mm, str(path))
    done = Imported(recording, label, int((~kept).sum()), moved, repeated, float(when_s[0]), dict(read.words))
    done.doubts = [*_doubts(choice, recording, wish), *gauge_doubts(sheet, choice, read, wish.gauge_length_mm)]
    done.doubts += [*mostly_one_gap(when_s, numbers_of[index]), *zero_set_anew(picked, numbers_of[index])]
    done.notes = [*choice.notes, *read.notes, *told, *_remarks(choice, recording, wish)]
    done.details = _details(sheet, choice, wish, done)
    return done


def _doubts(choice: Choice, recording: Recording, wish: Wish) -> list[str]:
    """What looks wrong, or cannot be seen in such a recording."""
    said = doubts(recording.channels, wish.negate)
    if too_slow := slow(recording):
        said.append(too_slow)
    one = choice.taken.get("relative_change")
    if one is not None and one.unit_from == NAMED and recording[RESISTANCE].max() > MANY_TIMES * (wish.r0_ohm or 1.0):
        times = recording[RESISTANCE].max() / (wish.r0_ohm or 1.0)
        said.append(f"{one.column.label} reaches {times:.0f} times R0; if it is in %, say --relative-unit %")
    return [*said, *_overlooked(choice, wish)]


def _overlooked(choice: Choice, wish: Wish) -> list[str]:
    """Columns of no known name (``DMM [kΩ]``) whose unit is that of something which was not found."""
    said = []
    for channel, quantities, alike in CHANNELS:
        if set(choice.taken) & alike or wish.leaves_out(alike):
            continue
        role = channel.partition("_")[0]
        for column in choice.unused:
            units = {unit.quantity: unit for unit in units_spelt(column.unit_text)}
            fits = [quantity for quantity in quantities if quantity in units]
            if len(units) == 1 and fits and not speaks_about(column.heading.whole):
                wanted = "displacement" if fits[0] == "length" else fits[0]
                said.append(
                    f"no {role} was found by its name, and {column.label} is in {units[fits[0]].symbol}: "
                    f"if it is the {wanted}, say {FLAGS[wanted]} {column.number}"
                )
    return said


def _remarks(choice: Choice, recording: Recording, wish: Wish) -> list[str]:
    """What was not there, and what was not used."""
    said = []
    for channel, _, alike in CHANNELS:
        if not recording.has(channel):
            why = "as you said" if wish.leaves_out(alike) else "no column was found for it"
            said.append(f"without {channel}: {why}")
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
        | ({"days": _named(one.days)} if one.days else {})
        | ({"part": _named(one.part)} if one.part else {})
        | ({"units": _named(one.units)} if one.units else {})
        for role, one in choice.taken.items()
    }
    details: dict[str, Any] = {"file": sheet.path.name, "sha256": sha256_of(sheet.path), "columns": columns}
    details |= {"r0_ohm": wish.r0_ohm, **sheet.details, "header_row": sheet.layout.header_row}
    details |= {"units_row": sheet.layout.units_row, "negate": sorted(wish.negate), "zero": dict(wish.zero)}
    return details | ({"repeat": done.label} if done.label else {}) | {"doubts": done.doubts, "notes": done.notes}


def _named(column: Column) -> str:
    """A column's name, or its number; names longer than a line are cut."""
    return (column.heading.text or str(column.number))[:300]
