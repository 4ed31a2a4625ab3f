"""A data set as Parquet files, one a campaign, in a folder a split: what tools that never heard of us can load."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from gcode.support.errors import UserError
from gcode.support.files import atomic_path, make_folder, refuse_links, sha256_of
from gcode.support.strict import blocks_of
from testbench.campaigns.datasets.parquet_checksums import (
    PARQUET,
    Checksums,
    keep_only,
    known_checksums,
    name_of,
    write_checksums,
)
from testbench.campaigns.datasets.splits import split_of
from testbench.campaigns.datasets.tasks import Task
from testbench.recordings import manifest
from testbench.recordings.channels import TIME
from testbench.recordings.files import read_recording

if TYPE_CHECKING:
    import pyarrow as pa

SPECIMEN = b"specimen"
FIRST_COLUMNS = "campaign", "specimen", TIME


@dataclass(frozen=True)
class Part:
    """One campaign of a data set on its way to Parquet."""

    campaign: Path
    specimen: str
    split: str
    file: Path


def parts_of(out: Path, tasks: Sequence[Task]) -> list[Part]:
    """Where each campaign of the data set in `out` goes: ``parquet/SPLIT/CAMPAIGN.parquet``, split by specimen."""
    splits = split_of(task.specimen for task in tasks)
    parts = []
    for task in tasks:
        split = splits[task.specimen]
        file = out / PARQUET / split / f"{task.folder.name}.parquet"
        parts.append(Part(task.folder, task.specimen, split, file))
    return parts


def write_parts(out: Path, parts: Sequence[Part], workers: int = -1) -> int:
    """Write all parts that are not there already, each whole or not at all, and the checksums of all.

    Returns
    -------
    int
        How many were written.

    Raises
    ------
    UserError
        If pyarrow is not installed, or a folder is a link.
    """
    from joblib import Parallel, delayed

    _pyarrow()
    for folder in {part.file.parent for part in parts}:
        refuse_links((folder.parent, folder), "choose another place")
        make_folder(folder)
    keep_only(out / PARQUET, {part.file for part in parts})
    channels, before = channels_of(parts), known_checksums(out)
    sums = {name_of(part.file): before.get(name_of(part.file)) for part in parts}
    with_one_thread = {"inner_max_num_threads": 1}
    done = Parallel(n_jobs=workers, backend="loky", return_as="generator", **with_one_thread)(
        delayed(make_part)(part, channels, sums[name_of(part.file)]) for part in parts
    )
    count = 0
    try:
        for part, (one, written) in zip(parts, done, strict=True):
            sums[name_of(part.file)] = one
            count += written
    finally:  # what is done by then is not done again
        write_checksums(out, {name: one for name, one in sums.items() if one})
    return count


def channels_of(parts: Sequence[Part]) -> list[str]:
    """Channels that any of the campaigns has: those of a sensor without resistance are fewer."""
    found: dict[str, None] = {}
    for part in parts:
        first_line = next(blocks_of(part.campaign / manifest.CSV, "recording")).partition(b"\n")[0]
        found |= dict.fromkeys(first_line.decode().strip().split(","))
    return [name for name in found if name != TIME]


def make_part(part: Part, channels: Sequence[str], known: Checksums | None) -> tuple[Checksums, bool]:
    """Write one campaign, unless it is there with the checksums that are known of it; and whether it was written."""
    if known and _is_there(part, channels, known):
        return known, False
    return write_part(part, channels), True


def _is_there(part: Part, channels: Sequence[str], known: Checksums) -> bool:
    """Whether the file is the one that was written of this campaign, this specimen and these channels."""
    from pyarrow import parquet

    if not part.file.is_file() or sha256_of(part.file) != known.sha256:
        return False
    schema = parquet.read_schema(part.file)
    of_specimen = (schema.metadata or {}).get(SPECIMEN) == part.specimen.encode()
    of_campaign = known.manifest_sha256 == sha256_of(part.campaign / manifest.NAME)
    return of_specimen and of_campaign and schema.names == [*FIRST_COLUMNS, *channels]


def write_part(part: Part, channels: Sequence[str]) -> Checksums:
    """Write one campaign."""
    from pyarrow import parquet

    of_campaign = sha256_of(part.campaign / manifest.NAME)
    table = table_of(part, channels)
    with atomic_path(part.file) as temporary:
        parquet.write_table(table, temporary, compression="zstd")
    return Checksums(sha256=sha256_of(part.file), manifest_sha256=of_campaign)


def table_of(part: Part, channels: Sequence[str]) -> pa.Table:
    """``campaign``, ``specimen``, the time and the `channels` as float64, null where it lacks one; a row a sample.

    All files of a data set have the same columns: a reader takes those of the first.
    """
    pa = _pyarrow()
    recording = read_recording(part.campaign)
    count = len(recording)
    said = {
        name: pa.DictionaryArray.from_arrays(pa.array([0] * count, pa.int32()), pa.array([value]))
        for name, value in (("campaign", part.campaign.name), ("specimen", part.specimen))
    }
    nothing = pa.nulls(count, pa.float64())
    table = pa.table({**said, TIME: recording.time_s, **{c: recording.channels.get(c, nothing) for c in channels}})
    told = {SPECIMEN: part.specimen, b"gauge_length_mm": repr(float(recording.gauge_length_mm))}
    return table.replace_schema_metadata(told)


def _pyarrow():
    try:
        import pyarrow
    except ImportError:
        raise UserError("Parquet needs pyarrow; install it with: pip install 'knitbench[parquet]'") from None
    return pyarrow
