"""Thousands of campaigns from one file, fanned out over processes; then their list, and Parquet files of them.

A campaign is one task. It is written whole or not at all and carries its own checksums, so a killed run is resumed
by starting it again: what verifies is never redone.
"""

from __future__ import annotations

import fcntl
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from gcode.support import strict
from gcode.support.errors import UserError
from gcode.support.files import clear_drafts, make_folder, sha256_of, write_text
from testbench.campaigns.campaign import matches, simulate_campaign
from testbench.campaigns.datasets.index import write_entries
from testbench.campaigns.datasets.splits import SPLITS, split_of
from testbench.campaigns.datasets.tasks import Task
from testbench.campaigns.plan import Plan, motion_of
from testbench.recordings import manifest

LOCK = ".lock"
CONNECT_S = 10  # until a Dask scheduler is given up


def make(task: Task) -> bool:
    """Make one campaign; False if it was there and intact already."""
    plan = task.plan()
    if _there(task.folder, plan):
        return False
    try:
        simulate_campaign(plan, task.folder, motion_of(task.program, task.gauge_length_mm), overwrite=True)
    except (OSError, UserError):
        # A scheduler may give a task to two workers when it believes the first one dead.
        if not _there(task.folder, plan):
            raise
    return True


@contextmanager
def cluster(address: str | None) -> Iterator[None]:
    """Within the block, joblib's ``dask`` backend works on the cluster at `address`; without one, do nothing.

    Raises
    ------
    UserError
        If Dask is not installed or the scheduler does not answer.
    """
    if address is None:
        yield
        return
    try:
        from distributed import Client
    except ImportError:
        raise UserError("a Dask cluster needs the extra: pip install 'knitbench[dask]'") from None
    try:
        client = Client(address, timeout=CONNECT_S)
    except (OSError, ValueError, TimeoutError) as error:
        raise UserError(
            f"{address}: no Dask scheduler answers there ({type(error).__name__}); check `scheduler`"
        ) from None
    with client:
        yield


def run(
    tasks: Sequence[Task], backend: str = "loky", workers: int = -1, step: Callable[[], None] = lambda: None
) -> tuple[int, int]:
    """Make all campaigns; return how many were made and how many were there already.

    Parameters
    ----------
    tasks : sequence of Task
    backend : {"loky", "dask"}
        Processes of this machine, or the Dask client that is active.
    workers : int
        Processes; -1 is one for each core.
    step : callable
        Called after each campaign.
    """
    from joblib import Parallel, delayed, parallel_config

    with parallel_config(
        backend=backend, n_jobs=workers, **({"inner_max_num_threads": 1} if backend == "loky" else {})
    ):
        made = 0
        for was_made in Parallel(return_as="generator_unordered")(delayed(make)(task) for task in tasks):
            made += was_made
            step()
    return made, len(tasks) - made


def write_index(out: Path, spec: Path, tasks: Sequence[Task]) -> None:
    """Copy the spec and list the campaigns, with the checksum of each one's manifest."""
    write_text(out / "dataset.toml", strict.read_text(spec, "spec", strict.MOST_TOML_BYTES))
    entries = []
    splits = split_of(task.specimen for task in tasks)
    for task in tasks:
        campaign, _ = manifest.read_manifest(task.folder)
        entries.append(
            {
                "campaign": task.folder.name,
                "sensor": task.sensor,
                "program": task.program.name,
                "seed": task.seed,
                "specimen": task.specimen,
                "split": splits[task.specimen],
                "samples": campaign.counts["samples"],
                "manifest_sha256": sha256_of(task.folder / manifest.NAME),
            }
        )
    write_entries(out, entries)


def write_parquet(out: Path, tasks: Sequence[Task], workers: int = -1) -> int:
    """Write the campaigns as Parquet, split by specimen, with Croissant metadata; how many were not there already."""
    from testbench.campaigns.datasets.croissant import write_croissant
    from testbench.campaigns.datasets.parquet import FIRST_COLUMNS, channels_of, parts_of, write_parts

    parts = parts_of(out, tasks)
    written = write_parts(out, parts, workers)
    splits = [split for split in SPLITS if any(part.split == split for part in parts)]
    write_croissant(out, out.absolute().name, splits, [*FIRST_COLUMNS, *channels_of(parts)])
    return written


def drop_stale_parquet(out: Path, tasks: Sequence[Task]) -> int:
    """Remove Parquet files of campaigns that are others now, and the metadata that counts on them; how many."""
    from testbench.campaigns.datasets.croissant import NAME
    from testbench.campaigns.datasets.parquet import parts_of
    from testbench.campaigns.datasets.parquet_checksums import keep_current

    parts = parts_of(out, tasks)
    dropped = keep_current(out, {part.file: part.campaign for part in parts})
    if dropped:
        (out / NAME).unlink(missing_ok=True)
    return dropped


@contextmanager
def one_at_a_time(out: Path) -> Iterator[None]:
    """Make a folder and hold it for one `dataset` command, and clear away the drafts of killed workers.

    A folder that it made, and in which nothing came to be, goes again.

    Raises
    ------
    UserError
        If another one is at work there.
    """
    new = [folder for folder in (out, *out.parents) if not folder.exists()]
    make_folder(out)
    # Where the command before has taken its lock away since that was opened, nobody else would see this one.
    while not os.fstat(handle := _locked(out)).st_nlink:
        os.close(handle)
    try:
        clear_drafts(out)
        yield
    finally:
        (out / LOCK).unlink(missing_ok=True)
        os.close(handle)
        with suppress(OSError):
            for folder in new:
                folder.rmdir()


def _locked(out: Path) -> int:
    try:
        handle = os.open(out / LOCK, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_NONBLOCK, 0o644)
    except OSError as error:
        raise UserError(f"{out / LOCK}: cannot hold this folder: {error.strerror}; see what is there") from None
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        os.close(handle)
        raise UserError(f"{out}: another `testbench dataset` is at work in this folder") from None
    return handle


def _there(folder: Path, plan: Plan) -> bool:
    try:
        return matches(folder, plan)
    except UserError:
        return False
