"""Files that are either whole or not there."""

from __future__ import annotations

import contextlib
import errno
import hashlib
import json
import os
import re
import secrets
import shutil
import stat
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

from gcode.support import disk
from gcode.support.errors import UserError
from gcode.support.kinds import path_of

MANIFEST = "datapackage.json"  # the name that Frictionless gives it
MEASURED = frozenset((b"displacement_mm", b"force_N", b"resistance_ohm"))  # columns of a recording
PREDICTED = frozenset((b"low_N", b"low_mm"))  # beside one of these, what `compensation predict` wrote
EXECUTED = [b"time_s", b"position_mm"]  # what `gcode play` and `gcode generate` write
PROGRAM_NAMES, PROGRAM_BEGINS = (".tap", ".nc", ".ngc", ".gcode"), b"(RATE_HZ: "  # of a program that we wrote


@contextlib.contextmanager
def atomic_path(path: str | Path, *, recorded: bool = False) -> Iterator[Path]:
    """Yield a temporary sibling of `path`; move it into place when the block ends well.

    `recorded` says that it is one of a recording's own files and may be replaced.

    Raises
    ------
    UserError
        If the folder does not exist or cannot be written, or the disk does not take the file; what was there before
        is untouched.
    """
    path = path_of(path)
    if not recorded:
        _check_replaceable(path)
    temporary = _sibling(path)
    try:
        disk.DISK.close(disk.DISK.create(temporary))
        yield temporary
        with disk.growing(temporary) as handle:
            disk.DISK.sync(handle)
        disk.DISK.rename(temporary, path)
        disk.sync_quietly(path.parent)
    except OSError as error:
        raise UserError(f"cannot write {path}: {error.strerror or error}; choose another place") from error
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)


def check_place(path: str | Path | None, overwrite: bool = False) -> None:
    """Refuse a place that no file can be written to, before the work whose result would be lost there.

    Parameters
    ----------
    path : path, optional
        Where a file will be written; None and "-" (standard output) are let through.
    overwrite : bool
        Whether a person said that a file there may go, which then may be a recording; but none of a campaign.

    Raises
    ------
    UserError
        If it is a folder, a device, a pipe or a file that cannot be made again, or its folder does not exist or
        cannot be written.
    """
    if path is None or str(path) == "-":
        return
    path = path_of(path)
    _check_replaceable(path, overwrite)
    try:
        folder = path.resolve().parent
        there, free = folder.is_dir(), os.access(folder, os.W_OK | os.X_OK, effective_ids=True)
    except (OSError, RuntimeError, ValueError) as error:
        raise UserError(f"cannot write {path}: {error}; choose another place") from None
    if not there or not free:
        why = "its folder cannot be written" if there else "its folder does not exist"
        raise UserError(f"cannot write {path}: {why}; choose another place")


def _check_replaceable(path: Path, overwrite: bool = False) -> None:
    """A file takes the place of a file, or of nothing: root must not lose /dev/null to a model.

    What our commands cannot make again is not replaced: a recording, or data and programs that others wrote.
    """
    try:
        mode = path.lstat().st_mode
    except OSError:
        return
    except ValueError as error:  # a zero byte in its name
        raise UserError(f"cannot write {path}: {error}; choose another place") from None
    if stat.S_ISREG(mode) or (stat.S_ISLNK(mode) and not path.is_dir()):
        if there := _irreplaceable(path, overwrite):
            raise UserError(f"cannot write {path}: {there}; choose another place")
        if stat.S_ISREG(mode) and not os.access(path, os.W_OK, effective_ids=True):
            raise UserError(f"cannot write {path}: it is write-protected; choose another place")
        return
    what = "a folder" if path.is_dir() else "a device or a pipe"
    raise UserError(f"cannot write {path}: it is {what}; give the name of a file")


def _irreplaceable(path: Path, overwrite: bool) -> str:
    """What there is in a file that cannot be made again; empty for what our commands wrote, or what is no data."""
    from gcode.support.strict import blocks_of, read_bytes

    manifest, recording = path.parent / MANIFEST, "a recording is there, or a part of one"
    if manifest.is_file() and (path.name == MANIFEST or json.dumps(path.name).encode() in read_bytes(manifest)):
        return recording
    try:
        head = next(blocks_of(path), b"").removeprefix(b"\xef\xbb\xbf").lstrip()
    except UserError:
        return ""
    ending = path.suffix.lower()
    if overwrite or not head:
        return ""
    if ending in PROGRAM_NAMES:
        return "" if head.startswith(PROGRAM_BEGINS) else "a program is there that others wrote"
    columns = [name.strip(b"\"' ") for name in re.split(rb"[,;\t]", head.partition(b"\n")[0].rstrip())]
    predicted = b"time_s" in columns and not PREDICTED.isdisjoint(columns)
    if b"time_s" in columns and not MEASURED.isdisjoint(columns) and not predicted:
        return recording
    return "a table is there that others wrote" if ending == ".csv" and columns != EXECUTED and not predicted else ""


def existing_file(path: str | Path, what: str = "file") -> Path:
    """`path`, if it is a file; `what` says in the message what was wanted.

    Raises
    ------
    UserError
        If it is no path, or a folder, a pipe or a device, or nothing is there.
    """
    path = path_of(path, what)
    if path.is_dir():
        raise UserError(f"{path}: a folder, no {what}")
    if not path.is_file():
        if path.exists():
            raise UserError(f"{path}: a pipe or a device; save what comes from it in a file, and give that")
        raise UserError(f"{path}: no such {what}")
    return path


def write_bytes(path: str | Path, data: bytes, *, recorded: bool = False) -> None:
    """Write a whole file or none of it, to last: after a power cut the old content or the new one is there.

    `recorded` says that it is one of a recording's own files and may be replaced.

    Raises
    ------
    UserError
        If the disk does not take it; what was there before is untouched.
    """
    with atomic_writer(path, recorded=recorded) as write:
        write(data)


@contextlib.contextmanager
def atomic_writer(path: str | Path, *, recorded: bool = False) -> Iterator[Callable[[bytes], None]]:
    """Yield a function that writes the next bytes of a file; `path` becomes that file when the block ends well."""
    with atomic_path(path, recorded=recorded) as temporary, disk.growing(temporary) as handle:
        yield lambda data: disk.write_all(handle, data)


def write_text(path: str | Path, text: str) -> None:
    """Write `text` (UTF-8, line feeds) whole, as `write_bytes` does; bytes of a name that are no text are escaped."""
    write_bytes(path, text.encode(errors="backslashreplace"))


def copy_file(source: str | Path, target: str | Path) -> None:
    """Copy a plain file of at most 256 MB, as `write_bytes` does."""
    from gcode.support.strict import read_bytes

    write_bytes(target, read_bytes(source))


@contextlib.contextmanager
def drafted_folder(folder: Path) -> Iterator[Path]:
    """Yield a new folder beside `folder`; put it in its place when the block ends well: all of it or nothing.

    `folder` must not exist yet, or be empty.

    Raises
    ------
    UserError
        If something is there by then.
    """
    make_folder(folder.parent)
    scratch = folder.parent / f".{folder.name}.{secrets.token_hex(4)}"
    draft = scratch / "campaign"
    try:
        disk.DISK.make_folder(scratch)
        disk.DISK.make_folder(draft)
        yield draft
        disk.sync_quietly(draft)
        _move(draft, folder)
        disk.sync_quietly(folder.parent)
    finally:
        shutil.rmtree(scratch, ignore_errors=True)


def _move(draft: Path, folder: Path) -> None:
    try:
        disk.DISK.rename(draft, folder)
    except OSError as error:
        if error.errno not in (errno.ENOTEMPTY, errno.EEXIST, errno.ENOTDIR):
            raise
        raise UserError(f"{folder}: another program has just written there; choose another place") from None


def clear_drafts(folder: Path) -> None:
    """Remove what kills left of `drafted_folder` there: before a draft was made, in it, or after it was moved."""
    for scratch in folder.glob(".*.*"):
        if scratch.is_dir() and {path.name for path in scratch.iterdir()} <= {"campaign"}:
            shutil.rmtree(scratch, ignore_errors=True)


def _sibling(path: Path) -> Path:
    return path.parent / f".{path.name}.{secrets.token_hex(4)}{path.suffix}"


def write_json(path: str | Path, data: Any) -> None:
    """Write `data` as indented JSON, atomically. NaN and infinity are refused: JSON has none."""
    write_text(path, json.dumps(data, indent=2, allow_nan=False) + "\n")


def make_folder(path: str | Path) -> Path:
    """Create a folder (and its parents); a refusal is a `UserError`."""
    path = path_of(path, "folder")
    try:
        path.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:  # ValueError: a zero byte in its name
        why = getattr(error, "strerror", None) or error
        raise UserError(f"cannot make the folder {path}: {why}; choose another") from error
    return path


def check_folder(path: str | Path) -> Path:
    """Refuse a place where there is no folder and none can be made, before the work whose result would be lost there.

    Raises
    ------
    UserError
        If it, or what it would be made in, is no folder, or may not be written.
    """
    path = path_of(path, "folder")
    there = next(one for one in (path, *path.absolute().parents) if os.path.lexists(one))
    if not there.is_dir() or not os.access(there, os.W_OK | os.X_OK, effective_ids=True):
        why = "is no folder" if not there.is_dir() else "may not be written"
        raise UserError(f"cannot write into the folder {path}: {there} {why}; choose another")
    return path


def refuse_links(places: Iterable[Path], instead: str) -> None:
    """Raise `UserError`, with what to do `instead`, where a place is a link: what is written would land elsewhere."""
    for place in places:
        if place.is_symlink():
            raise UserError(f"{place}: is a link, and nothing is written through it; {instead}")


def sha256_of(path: str | Path) -> str:
    """Hex digest of a plain file's bytes; what is no plain file is a `UserError`."""
    from gcode.support.strict import blocks_of

    digest = hashlib.sha256()
    for block in blocks_of(path):
        digest.update(block)
    return digest.hexdigest()
