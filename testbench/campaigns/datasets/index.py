"""``dataset.json``: the list of a data set's campaigns, with the checksum of each one's manifest."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from gcode.support.errors import UserError
from gcode.support.files import sha256_of, write_json
from gcode.support.strict import read_json, validated
from testbench.recordings import manifest
from testbench.recordings.stored import StoredIndex

INDEX = "dataset.json"
FORMAT, FORMAT_VERSION = "knitbench-dataset", 1


def write_entries(out: Path, entries: list[dict[str, Any]]) -> None:
    """Write the list; each entry names its ``campaign`` and the ``manifest_sha256``."""
    write_json(out / INDEX, {"format": FORMAT, "version": FORMAT_VERSION, "campaigns": entries})


def index_problems(out: Path) -> tuple[list[Path], list[str]]:
    """The campaigns in the folder of a data set, itself if it is one, and what does not agree with its list.

    Raises
    ------
    UserError
        If the list is not one.
    """
    index = _read(out)
    there, found = [out] if is_campaign(out) else [], []
    for entry in index.campaigns:
        folder = out / entry.campaign
        if not (folder / manifest.NAME).is_file():
            found.append(f"{folder}: missing; run `testbench dataset` again")
            continue
        there.append(folder)
        if sha256_of(folder / manifest.NAME) != entry.manifest_sha256:
            found.append(f"{folder / manifest.NAME}: not the one that {INDEX} lists; run `testbench dataset` again")
    others = sorted({path.parent for path in out.glob(f"*/{manifest.NAME}")} - set(there))
    unlisted = f"{INDEX} does not list it; move it away, or name its seed in the data set's spec"
    return [*there, *others], [*found, *(f"{folder}: {unlisted}" for folder in others)]


def is_campaign(out: Path) -> bool:
    """Whether the folder of a data set is itself a campaign, whole or damaged."""
    return manifest.is_campaign(out) or all((out / name).is_file() for name in (manifest.NAME, manifest.CSV))


def listed(out: Path) -> list[dict[str, Any]]:
    """The entries of a data set's list, a campaign each.

    Raises
    ------
    UserError
        If the list is not there or is not one.
    """
    return [entry.model_dump() for entry in _read(out).campaigns]


def _read(out: Path) -> StoredIndex:
    data = read_json(out / INDEX, "list of campaigns")
    if not isinstance(data, dict) or data.get("format") != FORMAT or data.get("version") != FORMAT_VERSION:
        raise UserError(f"{out / INDEX}: not a list of {FORMAT} {FORMAT_VERSION}; make the data set again")
    return validated(data, StoredIndex, out / INDEX, "list of campaigns")
