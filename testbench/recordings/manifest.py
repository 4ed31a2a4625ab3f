"""``datapackage.json``: a Frictionless Data Package (v2) whose key ``knitbench`` holds the whole recipe.

The manifest carries the SHA-256 of every file and of itself, so that any flipped byte in the folder is found.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import math
import os
import shlex
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gcode.support import strict
from gcode.support.errors import UserError
from gcode.support.files import MANIFEST as NAME
from gcode.support.files import sha256_of, write_bytes
from testbench.recordings.channels import UNITS
from testbench.recordings.stored import Resource, StoredManifest

FORMAT, FORMAT_VERSION = "knitbench-campaign", 1
PROFILE = "https://datapackage.org/profiles/2.0/datapackage.json"
NO_HASH = "0" * 64
MOST_BYTES = 64 << 20
CSV = "recording.csv"
CHANGED = "changed since it was written (its own checksum is wrong)"
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
        Of the software that made it, see `testbench.recordings.versions`.
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
    """Describe `files` of `folder` and write the manifest, atomically and last.

    Raises
    ------
    UserError
        If `campaign` holds what `read_manifest` would refuse.
    """
    hashed = not campaign.in_progress
    resources = [_resource(folder / name, hashed) for name in files]
    gauge_mm = None if math.isnan(campaign.gauge_length_mm) else campaign.gauge_length_mm  # JSON has no NaN
    head = {"format": FORMAT, "version": FORMAT_VERSION}
    data = {
        "$schema": PROFILE,
        "name": "knitbench-campaign",
        "resources": resources,
        "knitbench": {**head, **vars(campaign), "gauge_length_mm": gauge_mm},
    }
    text = sealed(data)
    # What is written can be read again: a name or a number beyond the loader's bounds is refused here.
    strict.validated(strict.json_of(text), StoredManifest, folder / NAME, "campaign manifest")
    write_bytes(folder / NAME, text.encode(), recorded=True)


def read_manifest(folder: Path) -> tuple[Campaign, list[Resource]]:
    """The campaign in `folder`, checked against the manifest's own hash, and the files that it names.

    Raises
    ------
    UserError
        If there is no manifest, it is not one of knitbench's, or it was changed since it was written.
    """
    campaign, resources, intact = _read(folder)
    if not intact:
        raise UserError(f"{folder / NAME}: {CHANGED}; restore it from a copy, or make the campaign again")
    return campaign, resources


def is_campaign(folder: Path) -> bool:
    """Whether a manifest of ours is there, changed or not; others may have a ``datapackage.json`` of their own."""
    with contextlib.suppress(UserError):
        _check_kind(strict.json_of(_text_of(folder)[0]), str(folder))
        return True
    return False


def origin_of(folder: Path) -> str:
    """What a manifest says its campaign came from, changed or not: enough to know what must not be removed."""
    return _read(folder)[0].origin


def _read(folder: Path) -> tuple[Campaign, list[Resource], bool]:
    text, path = _text_of(folder)
    data = strict.json_of(text, "campaign manifest", path)
    _check_kind(data, path)
    stored = strict.validated(data, StoredManifest, path, "campaign manifest")
    about = stored.knitbench
    counts = about.counts.model_dump(exclude_unset=True)
    gauge_mm = math.nan if about.gauge_length_mm is None else about.gauge_length_mm
    campaign = Campaign(gauge_mm, about.origin, about.status, about.recipe.to_dict(), counts, about.versions)
    return campaign, stored.resources, _self_hash_holds(text, about.manifest_sha256)


def _text_of(folder: Path) -> tuple[str, str]:
    """The text of a manifest, and what to call it: a link is named with where it leads."""
    path = folder / NAME
    try:
        path.lstat()
    except (FileNotFoundError, NotADirectoryError):
        what = f"no {NAME} in this folder, so it is not a campaign" if folder.is_dir() else "no such campaign folder"
        raise UserError(f"{folder}: {what}; `testbench run`, `record` and `import` make one") from None
    except (OSError, ValueError) as error:
        raise UserError(f"{folder}: cannot look into this folder: {getattr(error, 'strerror', error)}") from None
    link = _link_in_words(folder)
    try:
        return strict.read_text(path, "campaign manifest", MOST_BYTES), f"{path}{link}"
    except UserError as error:
        remedy = "; put the manifest itself there, or what the link leads to" if link else ""
        raise UserError(f"{path}{link}{str(error).removeprefix(str(path))}{remedy}") from None


def _link_in_words(folder: Path) -> str:
    """Where the manifest of a folder really is; empty where it is no link."""
    path = folder / NAME
    return f" (a link to {os.readlink(path)})" if path.is_symlink() else ""


def _check_kind(data: Any, path: str) -> None:
    about = data.get("knitbench") if isinstance(data, dict) else None
    if not isinstance(about, dict) or about.get("format") != FORMAT:
        raise UserError(f"{path}: not a knitbench campaign (its key knitbench must have the format {FORMAT!r})")
    if about.get("version") != FORMAT_VERSION:
        raise UserError(
            f"{path}: campaign version {about.get('version')!r}; this knitbench reads {FORMAT_VERSION}; "
            "update knitbench"
        )


def problems(folder: Path) -> list[str]:
    """Everything in `folder` that does not agree with its manifest, in sentences that name the file."""
    campaign, resources, intact = _read(folder)
    found = [] if intact else [f"{folder / NAME}: {CHANGED}"]
    if campaign.in_progress:
        again = "run it again, and overwrite it"
        if campaign.origin == "recorded":
            again = f"continue it with `testbench record --resume -o {shlex.quote(str(folder))}`"
        return [*found, f"{folder}: unfinished; {again}"]
    if CSV not in {resource.path for resource in resources}:
        found.append(f"{folder / NAME}: does not list {CSV}")
    for resource in resources:
        found += resource_problems(folder, resource)
    return found


def resource_problems(folder: Path, resource: Resource) -> list[str]:
    """What is wrong with one file of a campaign; empty if nothing is."""
    path = folder / resource.path
    if not path.is_file():
        return [f"{path}: missing"]
    if resource.hash is None:
        return [f"{folder / NAME}: no hash for {path.name}"]
    size = path.stat().st_size
    if size != resource.bytes:
        return [f"{path}: {size} bytes, the manifest{_link_in_words(folder)} says {resource.bytes}"]
    if f"sha256:{sha256_of(path)}" != resource.hash:
        return [f"{path}: checksum differs from the manifest{_link_in_words(folder)}"]
    return []


def sealed(data: dict[str, Any]) -> str:
    """The text of a manifest with the hash of itself in it."""
    bare = {**data, "knitbench": {**data["knitbench"], "manifest_sha256": NO_HASH}}
    text = json.dumps(bare, indent=2, allow_nan=False) + "\n"
    return text.replace(NO_HASH, hashlib.sha256(text.encode()).hexdigest())


def _self_hash_holds(text: str, digest: str) -> bool:
    mark = f'"manifest_sha256": "{digest}"'
    bare = text.replace(mark, mark.replace(digest, NO_HASH))
    return text.count(mark) == 1 and hashlib.sha256(bare.encode()).hexdigest() == digest


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
    entry = {"name": name, "type": "number", "unit": UNITS.get(name, name.rpartition("_")[2] if "_" in name else "1")}
    return entry | ({"title": _TITLES[name]} if name in _TITLES else {})
