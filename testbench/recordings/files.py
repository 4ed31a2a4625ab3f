"""Reading and writing ``recording.csv`` and campaign folders as recordings."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gcode.support.errors import UserError
from gcode.support.files import atomic_writer
from gcode.support.kinds import path_of
from gcode.support.strict import json_of, read_bytes, validated
from testbench.recordings.channels import DISPLACEMENT, FORCE, RESISTANCE, TEMPERATURE, TIME, UNITS
from testbench.recordings.checks import check, known_length, row_of_file
from testbench.recordings.csv_columns import MOST_BYTES, columns_of, listed, read_frame
from testbench.recordings.doubts import say_once
from testbench.recordings.manifest import CSV, NAME, Campaign, is_campaign, read_manifest, resource_problems
from testbench.recordings.recording import Recording
from testbench.recordings.stored import EVENTS, Resource, StoredEvent

if TYPE_CHECKING:
    import pandas as pd

ORDER = (TIME, DISPLACEMENT, FORCE, RESISTANCE)
DECIMALS = 6, 5  # µs, nm, µN; digits that are kept of the largest value
TIME_DECIMALS = 6, 2  # digits of the shortest step
RESISTANCE_DECIMALS = 3, 7  # digits of the smallest one: a thread has 1 Ω, a knit 1 MΩ
MOST_DECIMALS = 15
ROWS_AT_ONCE = 100_000


def read_recording(path: str | Path, gauge_length_mm: float | None = None) -> Recording:
    """Read a recording from a CSV or a campaign folder.

    Parameters
    ----------
    path : path
        A CSV, or a campaign: a folder with a ``datapackage.json``, or the ``recording.csv`` in it.
    gauge_length_mm : float, optional
        Needed for a bare CSV. A campaign knows its own, which is used; that another was given is said.

    Raises
    ------
    UserError
        If the file is missing or malformed; the message names the file, the row and the remedy.
    """
    path = path_of(path, "recording")
    if path.is_dir():
        return _load_campaign(path, gauge_length_mm)
    if not path.exists():
        raise UserError(f"{path}: no such recording; give a CSV or a campaign folder")
    if path.name == CSV and is_campaign(path.parent):  # its manifest knows the gauge length and what else was said
        return _load_campaign(path.parent, gauge_length_mm)
    check_beside(path)
    frame = read_frame(path)
    if gauge_length_mm is None and DISPLACEMENT in frame:
        raise UserError(f"{path}: a bare CSV does not know its gauge length; give `gauge_length_mm`")
    return _recording(path, frame, known_length(gauge_length_mm, str(path)))


def _load_campaign(folder: Path, gauge_length_mm: float | None) -> Recording:
    path, campaign = verified(folder)
    frame = read_frame(path, growing=campaign.in_progress)
    own_mm, given_mm = campaign.gauge_length_mm, known_length(gauge_length_mm, str(folder))
    if np.isnan(own_mm):
        own_mm = given_mm
    elif not np.isnan(given_mm) and given_mm != own_mm:
        say_once(f"{folder}: its manifest says a gauge length of {own_mm:g} mm, which is used, not {given_mm:g} mm")
    recording = _recording(path, frame, own_mm, asdict(campaign))
    for when_s in _reboots_s(folder):
        _say_of_reboot(recording, when_s)
    return recording


def _reboots_s(folder: Path) -> list[float]:
    """When the board began anew, as the events of a campaign tell; what cannot be read tells nothing."""
    path = folder / EVENTS
    with suppress(UserError):
        lines = read_bytes(path, "list of events", MOST_BYTES).decode("utf-8", "replace").splitlines()
        reboots = [json_of(line, "event", path) for line in lines if '"reboot"' in line]
        return [validated(event, StoredEvent, path, "event").time_s for event in reboots]
    return []


def _say_of_reboot(recording: Recording, when_s: float) -> None:
    """Say where a board began anew, which may count its displacement from where it stood then."""
    at = int(np.searchsorted(recording.time_s, when_s))
    if recording.has(DISPLACEMENT) and 0 < at < len(recording):
        before_mm, after_mm = recording[DISPLACEMENT][at - 1 : at + 1]
        say_once(
            f"{recording.source}: the board began anew at {when_s:.4g} s, with a displacement of {after_mm:.4g} mm "
            f"after {before_mm:.4g} mm: if its zero is where the board began, give the parts as two recordings"
        )


def verified(folder: Path) -> tuple[Path, Campaign]:
    """The CSV of a campaign, held against its manifest, and what the manifest says.

    Raises
    ------
    UserError
        If it is not the file that the manifest describes. One that is still growing is not verified, which is said.
    """
    campaign, resources = read_manifest(folder)
    path = folder / CSV
    if not campaign.in_progress:
        _verify(folder, path, resources)
    elif not path.is_file():
        raise UserError(f"{folder}: no sample has been recorded yet")
    else:
        say_once(f"{folder}: this recording is unfinished, so it has no checksum yet and is read unverified")
    return path, campaign


def check_beside(path: Path) -> None:
    """Hold a file in the folder of a campaign against the manifest there; say so where that has no checksum of it.

    Raises
    ------
    UserError
        If either was changed.
    """
    if not is_campaign(path.parent):
        return
    campaign, resources = read_manifest(path.parent)
    if campaign.in_progress or path.name not in {resource.path for resource in resources}:
        say_once(f"{path}: the manifest beside it has no checksum of it, so it is read unverified")
    else:
        _verify(path.parent, path, resources)


def _verify(folder: Path, path: Path, resources: Sequence[Resource]) -> None:
    """Refuse a recording that is not the one that the manifest describes."""
    ours = [resource for resource in resources if resource.path == path.name]
    found = [] if ours else [f"{folder / NAME}: does not list {path.name}"]
    for resource in ours:
        found += resource_problems(folder, resource)
    if found:
        raise UserError(f"{found[0]}; restore the file, or import it as a foreign CSV with `testbench import`")


def _recording(
    path: Path, frame: pd.DataFrame, gauge_length_mm: float, metadata: dict[str, Any] | None = None
) -> Recording:
    columns, names = columns_of(path, frame), list(map(str, frame.columns))
    if TIME not in columns:
        raise UserError(
            f"{path}: no column {TIME} (found: {listed(names, columns)}); name yours with `testbench import`"
        )
    _check_names(path, names)
    say_of_temperature(path, columns)
    time_s = columns.pop(TIME)
    others = listed((name for name in names if name != TIME), columns)
    check(str(path), time_s, columns, gauge_length_mm, row_of_file, others)
    return Recording(time_s, columns, gauge_length_mm, str(path), metadata or {})


def _check_names(path: Path, names: list[str]) -> None:
    """Refuse a file without force or resistance that has a column which may be just that under another name or unit.

    Either may be missing from a recording; but one that is overlooked would be missing without a word.
    """
    for channel in SPELLINGS:
        strange = strange_names(names, channel)
        if channel not in names and strange:
            raise UserError(
                f"{path}: no column {channel}, but one called {strange[0]!r}: name it with `testbench import`, "
                "or leave it out"
            )


def say_of_temperature(source: object, names: Iterable[str]) -> None:
    """Say that a column which may be the temperature is not taken for it: drift with it would stay unexplained."""
    named = list(names)
    like = [name for name in named if re.match(r"temp(erature)?(_|$)", name.lower())]
    if like and TEMPERATURE not in named:
        say_once(
            f"{source}: column {like[0]!r} is not taken for the temperature; if it is that of the sensor, call it "
            f"{TEMPERATURE}, in degrees Celsius"
        )


SPELLINGS = {FORCE: ("force", "load", "kraft"), RESISTANCE: ("resist", "widerstand", "ohm")}


def strange_names(names: Iterable[str], channel: str) -> list[str]:
    """Those of the names that may be the channel (one of `SPELLINGS`) under another name or unit."""
    return [name for name in names if name not in UNITS and _may_be(name, channel)]


def _may_be(name: str, channel: str) -> bool:
    """Whether a name speaks of the channel, or ends in its unit; other columns (a cycle number) mean nothing here."""
    unit = channel.rpartition("_")[2].lower()
    return any(word in name.lower() for word in SPELLINGS[channel]) or name.lower().rpartition("_")[2] == unit


def write_recording_csv(path: str | Path, recording: Recording) -> None:
    """Write ``recording.csv`` atomically, known columns first, in fixed decimals (same bytes from same data).

    A resistance has mΩ, and more where it is small; so have times that are close, and small forces and displacements.

    Raises
    ------
    UserError
        If times are too close to be told in 15 decimals.
    """
    columns = {TIME: recording.time_s, **recording.channels}
    names = [name for name in ORDER if name in columns] + sorted(set(columns) - set(ORDER))
    line = ",".join(f"%.{_decimals(name, columns[name])}f" for name in names) + "\n"
    with atomic_writer(path, recorded=True) as write:
        write((",".join(names) + "\n").encode())
        for start in range(0, len(recording), ROWS_AT_ONCE):
            block = np.column_stack([columns[name][start : start + ROWS_AT_ONCE] for name in names])
            write((line * len(block) % tuple(block.ravel().tolist())).encode())


def _decimals(name: str, values: np.ndarray) -> int:
    size = np.abs(np.diff(values) if name == TIME else values)
    size = size[np.isfinite(size) & (size > 0)]
    fewest, digits = {TIME: TIME_DECIMALS, RESISTANCE: RESISTANCE_DECIMALS}.get(name, DECIMALS)
    if not size.size:
        return fewest
    told = size.min() if name in (TIME, RESISTANCE) else size.max()
    if name == TIME and told < 10.0**-MOST_DECIMALS:
        raise UserError(
            f"{name}: a step of {told:.3g} s is too short to be written; is its unit right? (--time-unit)"
        )
    return int(np.clip(digits - 1 - np.floor(np.log10(told)), fewest, MOST_DECIMALS))
