"""``datapackage.json``: a Frictionless Data Package (v2) whose key ``knitbench`` holds the whole recipe.

The manifest carries the SHA-256 of every file and of itself, so that any flipped byte in the folder is found.
"""

from __future__ import annotations

import hashlib
import json
import math
import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gcode.support.errors import UserError
from gcode.support.files import read_json, sha256_of, write_text
from testbench.recording import UNITS

NAME = "datapackage.json"
FORMAT, FORMAT_VERSION = "knitbench-campaign", 1
PROFILE = "https://datapackage.org/profiles/2.0/datapackage.json"
NO_HASH = "0" * 64
IN_PROGRESS = "recording"

_TITLES = {
    "time_s": "Time since the first sample",
    "displacement_mm": "Displacement of the moving clamp",
    "force_N": "Tensile force",
    "resistance_ohm": "Resistance of the sensor",
    "temperature_C": "Temperature",
}
# Only the recording is a table. A validator that is told "jsonl" or "json" looks for a table in the events.
_KINDS = {".csv": ("csv", "text/csv"), ".tap": ("tap", "text/plain"), ".jsonl": ("bin", "application/jsonl")}


@dataclass(frozen=True)
class Campaign:
    """What a manifest says.

    Attributes
    ----------
    gauge_length_mm : float
        NaN where no displacement was recorded; null in the file.
    origin : str
        ``simulated``, ``recorded`` or ``imported``.
    status : str
        ``complete``, or why it ended early; ``recording`` while (or if a crash left it so) it is being recorded.
    recipe : dict
        Everything needed to make it again: sensor, model, seed, program, instruments.
    counts : dict
        Samples accepted, lost, rejected by reason.
    versions : dict
        Of the software that made it, see `testbench.versions`.
    """

    gauge_length_mm: float
    origin: str
    status: str
    recipe: dict[str, Any]
    counts: dict[str, Any]
    versions: dict[str, str]

    @property
    def in_progress(self) -> bool:
        """Whether its files may still grow (or a crash left them unfinished)."""
        return self.status == IN_PROGRESS


def write_manifest(folder: Path, campaign: Campaign, files: Iterable[str]) -> None:
    """Describe `files` of `folder` and write the manifest, atomically and last."""
    hashed = not campaign.in_progress
    resources = [_resource(folder / name, hashed) for name in files]
    head = {"format": FORMAT, "version": FORMAT_VERSION}
    data = {
        "$schema": PROFILE,
        "name": "knitbench-campaign",
        "resources": resources,
        "knitbench": {**head, **vars(campaign), **_gauge(campaign), "manifest_sha256": NO_HASH},
    }
    text = _dump(data)
    digest = hashlib.sha256(text.encode()).hexdigest()
    write_text(folder / NAME, text.replace(NO_HASH, digest))


def _gauge(campaign: Campaign) -> dict[str, float | None]:
    """The gauge length as JSON has it: there is no NaN in it."""
    gauge_mm = campaign.gauge_length_mm
    return {"gauge_length_mm": None if math.isnan(gauge_mm) else gauge_mm}


def read_manifest(folder: Path) -> tuple[Campaign, dict[str, Any]]:
    """The campaign in `folder` and the manifest's plain data.

    Raises
    ------
    UserError
        If there is no manifest, or it is not one of knitbench's.
    """
    path = folder / NAME
    if not path.is_file():
        raise UserError(f"{folder}: no {NAME} in this folder, so it is not a campaign")
    data = read_json(path, "campaign manifest")
    recipe = data.get("knitbench") if isinstance(data, dict) else None
    if not isinstance(recipe, dict) or recipe.get("format") != FORMAT:
        raise UserError(f"{path}: not a knitbench campaign (its key knitbench must have the format {FORMAT!r})")
    if recipe.get("version") != FORMAT_VERSION:
        raise UserError(
            f"{path}: campaign version {recipe.get('version')!r}; this knitbench reads {FORMAT_VERSION}; "
            "update knitbench"
        )
    try:
        if recipe["gauge_length_mm"] is None:
            recipe["gauge_length_mm"] = math.nan
        campaign = Campaign(**{name: recipe[name] for name in Campaign.__dataclass_fields__})
    except KeyError as missing:
        raise UserError(f"{path}: the manifest has no {missing} under knitbench; run the campaign again") from None
    return campaign, data


def problems(folder: Path) -> list[str]:
    """Everything in `folder` that does not agree with its manifest, in sentences that name the file."""
    campaign, data = read_manifest(folder)
    if campaign.in_progress:
        again = "run it again with --overwrite"
        if campaign.origin == "recorded":
            again = f"continue it with `testbench record --resume -o {folder}`"
        return [f"{folder}: unfinished; {again}"]
    found = [] if _self_hash_holds(folder / NAME) else [f"{folder / NAME}: changed since it was written"]
    for resource in data.get("resources", []):
        found += resource_problems(folder, resource)
    return found


def resource_problems(folder: Path, resource: dict[str, Any]) -> list[str]:
    """What is wrong with one file of a campaign; empty if nothing is."""
    path = folder / str(resource.get("path"))
    if not path.is_file():
        return [f"{path}: missing"]
    if "hash" not in resource:
        return [f"{folder / NAME}: no hash for {path.name}"]
    size = path.stat().st_size
    if size != resource.get("bytes"):
        return [f"{path}: {size} bytes, the manifest says {resource.get('bytes')}"]
    if f"sha256:{sha256_of(path)}" != resource["hash"]:
        return [f"{path}: checksum differs from the manifest"]
    return []


def _self_hash_holds(path: Path) -> bool:
    text = path.read_bytes()
    match = re.search(rb'"manifest_sha256": "([0-9a-f]{64})"', text)
    if match is None:
        return False
    bare = text[: match.start(1)] + NO_HASH.encode() + text[match.end(1) :]
    return hashlib.sha256(bare).hexdigest().encode() == match.group(1)


def _resource(path: Path, hashed: bool) -> dict[str, Any]:
    kind, media = _KINDS.get(path.suffix, (path.suffix.lstrip(".") or "bin", "text/plain"))
    entry: dict[str, Any] = {"name": path.name.replace(".", "-"), "path": path.name, "format": kind}
    entry |= {"mediatype": media, "encoding": "utf-8"}
    if hashed:
        entry |= {"bytes": path.stat().st_size, "hash": f"sha256:{sha256_of(path)}"}
    if path.suffix == ".csv":
        entry |= {"name": path.stem, "type": "table", "schema": {"fields": _fields(path)}}
    return entry


def _fields(path: Path) -> list[dict[str, Any]]:
    if not path.exists():
        return []
    with path.open(encoding="utf-8") as stream:
        names = stream.readline().strip().split(",")
    return [_field(name) for name in names if name]


def _field(name: str) -> dict[str, Any]:
    entry = {"name": name, "type": "number", "unit": UNITS.get(name, name.rpartition("_")[2] or "1")}
    return entry | ({"title": _TITLES[name]} if name in _TITLES else {})


def _dump(data: dict[str, Any]) -> str:
    return json.dumps(data, indent=2, allow_nan=False) + "\n"
