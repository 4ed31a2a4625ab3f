"""The checksums of a data set's Parquet files, and which of these are of its campaigns as they are now."""

from __future__ import annotations

from collections.abc import Mapping, Set
from contextlib import suppress
from pathlib import Path

from gcode.support.errors import UserError
from gcode.support.files import refuse_links, sha256_of, write_json
from gcode.support.strict import StrictModel, read_json, validated
from testbench.campaigns.datasets.splits import SPLITS
from testbench.recordings import manifest

PARQUET, CHECKSUMS = "parquet", "parquet-checksums.json"  # beside the folder: readers take all that is in it
MOST_BYTES = 1 << 30


class Checksums(StrictModel):
    """Of one Parquet file, and of the manifest of the campaign that it was written from."""

    sha256: str
    manifest_sha256: str


def keep_current(out: Path, campaigns: Mapping[Path, Path]) -> int:
    """Remove Parquet files that are not of the campaigns as they are now; how many.

    What stays behind would be loaded as if it were of the data set.

    Parameters
    ----------
    out : Path
        Folder of the data set.
    campaigns : mapping of Path to Path
        From the Parquet file to the folder of its campaign.
    """
    root = out / PARQUET
    if not root.is_dir():
        return 0
    refuse_links((root, *(root / split for split in SPLITS)), "choose another place")
    kept = _checksums(out) if (out / CHECKSUMS).is_file() else {}
    current = {
        file
        for file, campaign in campaigns.items()
        if (one := kept.get(name_of(file))) and one.manifest_sha256 == sha256_of(campaign / manifest.NAME)
    }
    write_checksums(out, {name: one for name, one in kept.items() if root / name in current})
    return keep_only(root, current)


def parquet_problems(out: Path) -> list[str]:
    """What does not agree with the checksums of a data set's Parquet files, or with its campaigns, a sentence each.

    Raises
    ------
    UserError
        If the list of checksums is not one.
    """
    root, kept, found = out / PARQUET, _checksums(out), []
    again = "; write them anew with `testbench dataset --format parquet`"
    for name, one in kept.items():
        file, campaign = root / name, out / Path(name).stem / manifest.NAME
        if not file.is_file():
            found.append(f"{file}: missing{again}")
        elif sha256_of(file) != one.sha256:
            found.append(f"{file}: its checksum is another{again}")
        elif not campaign.is_file() or sha256_of(campaign) != one.manifest_sha256:
            found.append(f"{file}: its campaign is another now, or gone{again}")
    others = sorted(file for file in _files(root) if name_of(file) not in kept)
    return [*found, *(f"{file}: {CHECKSUMS} does not list it{again}" for file in others)]


def keep_only(root: Path, wanted: Set[Path]) -> int:
    """Remove the files of campaigns that are no longer of this data set, or now of another split; how many."""
    others = [path for path in _files(root) if path not in wanted]
    for path in others:
        path.unlink()
    return len(others)


def _files(root: Path) -> list[Path]:
    return [path for split in SPLITS for path in (root / split).glob("*.parquet")]


def name_of(file: Path) -> str:
    """A file as the list of checksums names it: ``SPLIT/CAMPAIGN.parquet``."""
    return f"{file.parent.name}/{file.name}"


def _checksums(out: Path) -> dict[str, Checksums]:
    path, what = out / CHECKSUMS, "list of checksums"
    return validated(read_json(path, what, MOST_BYTES), dict[str, Checksums], path, what)


def known_checksums(out: Path) -> dict[str, Checksums]:
    """The list of a data set, by name of the file; empty where there is none that can be read."""
    with suppress(UserError):
        return _checksums(out)
    return {}


def write_checksums(out: Path, sums: Mapping[str, Checksums]) -> None:
    write_json(out / CHECKSUMS, {name: one.model_dump() for name, one in sums.items()})
