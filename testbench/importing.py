"""A foreign CSV becomes a recording: columns and units by name, rows that cannot be used named or left out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from gcode.support.errors import UserError
from gcode.support.files import make_folder, sha256_of
from testbench.foreign import layout_of, read_foreign
from testbench.manifest import Campaign, write_manifest
from testbench.recording import DISPLACEMENT, FORCE, RESISTANCE, TEMPERATURE, TIME, Recording
from testbench.recording_checks import such
from testbench.recording_files import write_recording_csv
from testbench.versions import software_versions

TIME_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0, "h": 3600.0}
LENGTH_UNITS = {"mm": 1.0, "um": 1e-3, "cm": 10.0, "m": 1e3, "in": 25.4}
FORCE_UNITS = {"N": 1.0, "mN": 1e-3, "cN": 1e-2, "kN": 1e3, "gf": 9.80665e-3, "kgf": 9.80665, "lbf": 4.4482216152605}
RESISTANCE_UNITS = {"ohm": 1.0, "mohm": 1e-3, "kohm": 1e3, "Mohm": 1e6}
CONDUCTANCE_UNITS = {"S": 1.0, "mS": 1e-3, "uS": 1e-6, "nS": 1e-9}
STRAIN_UNITS = {"1": 1.0, "%": 0.01}


@dataclass(frozen=True)
class Source:
    """One column of the file: its name there, and the factor that brings it to our unit."""

    column: str
    factor: float = 1.0


@dataclass(frozen=True)
class Wish:
    """What a foreign file means.

    Attributes
    ----------
    time : Source or None
        None with `rate_hz` where the file has no time column.
    time_is_date : bool
        The time column holds dates and times.
    displacement or strain : Source
        One of the two.
    resistance, conductance, relative, relative_change : Source
        At most one: R, G, R/R0 or (R - R0)/R0; the last two need `r0_ohm`.
    force, temperature : Source
    gauge_length_mm : float
    sort : bool
        Put rows in the order of time and drop repeated times.
    drop_bad : bool
        Leave out rows with a value that cannot be used.
    """

    gauge_length_mm: float
    time: Source | None = None
    rate_hz: float | None = None
    displacement: Source | None = None
    strain: Source | None = None
    force: Source | None = None
    resistance: Source | None = None
    conductance: Source | None = None
    relative: Source | None = None
    relative_change: Source | None = None
    temperature: Source | None = None
    time_is_date: bool = False
    r0_ohm: float = 1.0
    sort: bool = False
    drop_bad: bool = False
    separator: str | None = None
    decimal: str | None = None

    def sources(self) -> dict[str, Source]:
        """The columns that are wanted, by what they mean."""
        roles = ("time", "displacement", "strain", "force", "resistance", "conductance", "relative")
        every = {role: getattr(self, role) for role in (*roles, "relative_change", "temperature")}
        return {role: source for role, source in every.items() if source is not None}


@dataclass
class Imported:
    """The recording, and what was done to get it.

    Attributes
    ----------
    recording : Recording
    dropped : int
        Rows left out because of a value that cannot be used.
    moved, repeated : int
        Rows that were out of order; rows whose time came twice.
    time_offset_s : float
        Subtracted from the file's times, so that the first sample is at 0.
    details : dict
        For the manifest.
    """

    recording: Recording
    dropped: int = 0
    moved: int = 0
    repeated: int = 0
    time_offset_s: float = 0.0
    details: dict[str, Any] = field(default_factory=dict)


def import_csv(path: Path, wish: Wish) -> Imported:
    """Read a foreign CSV.

    Raises
    ------
    UserError
        If a column is missing, or a row cannot be used and `wish` does not say to drop it. The message names file,
        row and remedy.
    """
    sources = wish.sources()
    names = list(dict.fromkeys(source.column for source in sources.values()))
    layout = layout_of(path, names, wish.separator, wish.decimal)
    dates = [wish.time.column] if wish.time and wish.time_is_date else []
    rows, columns, notes = read_foreign(path, layout, names, dates)
    rows, columns, notes = _without_units_row(rows, columns, notes)
    if notes and not wish.drop_bad:
        raise UserError(f"{path}: {notes[0]}; --drop-bad leaves such rows out")
    scaled = {role: columns[source.column] * source.factor for role, source in sources.items()}
    time_s = scaled["time"] if "time" in scaled else (rows - rows[0]) / float(wish.rate_hz or 1.0)
    channels = _channels(scaled, wish)
    kept = _usable(path, rows, time_s, channels, wish.drop_bad)
    order, moved, repeated = _in_order(path, rows[kept], time_s[kept], wish.sort)
    index = np.flatnonzero(kept)[order]
    if len(index) < 2:
        raise UserError(f"{path}: {len(index)} of {len(rows)} rows can be used, a recording needs at least 2")
    offset_s = float(time_s[index[0]])
    picked = {name: values[index] for name, values in channels.items()}
    recording = Recording(time_s[index] - offset_s, picked, wish.gauge_length_mm, str(path))
    details = {"file": path.name, "sha256": sha256_of(path), "columns": _described(sources), "r0_ohm": wish.r0_ohm}
    details |= {"separator": layout.separator, "decimal": layout.decimal, "header_row": layout.header_row}
    return Imported(recording, int((~kept).sum()), moved, repeated, offset_s, details)


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


def _described(sources: Mapping[str, Source]) -> dict[str, dict[str, Any]]:
    return {role: {"column": source.column, "factor": source.factor} for role, source in sources.items()}


def _without_units_row(rows: np.ndarray, columns: dict[str, np.ndarray], notes: list[str]):
    """Many machines write the units below the names: a first row without a single number is no data."""
    first = f"row {rows[0]}:" if len(rows) else ""
    if len(rows) and len(notes) == len(columns) and all(note.startswith(first) for note in notes):
        rest = {name: values[1:] for name, values in columns.items()}
        return rows[1:], rest, []
    return rows, columns, notes


def _channels(scaled: Mapping[str, np.ndarray], wish: Wish) -> dict[str, np.ndarray]:
    channels = {}
    if "displacement" in scaled:
        channels[DISPLACEMENT] = scaled["displacement"]
    else:
        channels[DISPLACEMENT] = scaled["strain"] * wish.gauge_length_mm
    if "force" in scaled:
        channels[FORCE] = scaled["force"]
    with np.errstate(divide="ignore"):
        if "resistance" in scaled:
            channels[RESISTANCE] = scaled["resistance"]
        elif "conductance" in scaled:
            channels[RESISTANCE] = 1.0 / scaled["conductance"]
        elif "relative" in scaled:
            channels[RESISTANCE] = scaled["relative"] * wish.r0_ohm
        elif "relative_change" in scaled:
            channels[RESISTANCE] = (1.0 + scaled["relative_change"]) * wish.r0_ohm
    if "temperature" in scaled:
        channels[TEMPERATURE] = scaled["temperature"]
    return channels


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
            raise UserError(
                f"{path}: row {rows[first]}: {name} must be {want}, got {values[first]:g} "
                f"({such(int((~fine).sum()))}); --drop-bad leaves them out"
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
            "--sort puts rows in order and drops repeated times"
        )
    order = np.argsort(time_s, kind="stable")
    moved = int((order != np.arange(len(order))).sum())
    first = np.concatenate([[True], np.diff(time_s[order]) > 0])
    return order[first], moved, int((~first).sum())
