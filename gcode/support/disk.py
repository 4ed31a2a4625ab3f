"""Every call by which files of ours are changed, in one place.

What must survive a full disk, an I/O error or a power cut is written through `DISK`, so that the tests can put a disk
in its place that fails at any single call (``tests/faulty_disk.py``). No call follows a link at the end of a path: a
folder that came from a stranger must not be able to have a file outside of it written.
"""

from __future__ import annotations

import contextlib
import os
import stat
from collections.abc import Iterator
from pathlib import Path

from gcode.support.errors import UserError

TAIL_BYTES = 4096  # longer than any line
_NEW = os.O_WRONLY | os.O_CREAT | os.O_EXCL
_GROWING = os.O_RDWR | os.O_APPEND | os.O_CREAT
_SAFE = os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC


class Disk:
    """The operating system's calls; each raises `OSError` as the system does."""

    def create(self, path: Path) -> int:
        """A new, empty file, open for writing; it must not exist."""
        return os.open(path, _NEW | _SAFE, 0o644)

    def grow(self, path: Path) -> int:
        """A file to append to, made if it is not there."""
        return os.open(path, _GROWING | _SAFE, 0o644)

    def write(self, handle: int, data: bytes) -> int:
        """Give `data` to the operating system; how many bytes it took."""
        return os.write(handle, data)

    def truncate(self, handle: int, size: int) -> None:
        """Cut an open file."""
        os.ftruncate(handle, size)

    def sync(self, handle: int) -> None:
        """Have the disk itself keep what was written."""
        os.fsync(handle)

    def close(self, handle: int) -> None:
        """Close."""
        os.close(handle)

    def rename(self, old: Path, new: Path) -> None:
        """Put `old` in the place of `new`, at once."""
        os.replace(old, new)

    def remove(self, path: Path) -> None:
        """Remove a file."""
        os.unlink(path)

    def make_folder(self, path: Path) -> None:
        """Make a folder in a folder that is there."""
        os.mkdir(path)

    def sync_folder(self, path: Path) -> None:
        """Have the disk itself keep the names in a folder: without, a new file may be nameless after a power cut."""
        handle = os.open(path, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


DISK = Disk()


def write_all(handle: int, data: bytes) -> None:
    """Write every byte of `data`."""
    view = memoryview(data)
    while view:
        view = view[DISK.write(handle, bytes(view[: 1 << 20])) :]


def open_growing(path: Path) -> int:
    """Open a file of a campaign to append to it, made if it is not there.

    Raises
    ------
    UserError
        If it is a link, a pipe or anything but a file of its own: what is written there would land elsewhere.
    """
    try:
        handle = DISK.grow(path)
    except OSError as error:
        if path.is_symlink() or (path.exists() and not path.is_file()):
            raise UserError(f"{path}: is not a plain file, and nothing is written to it; see what it is") from None
        raise error
    about = os.fstat(handle)
    if not stat.S_ISREG(about.st_mode) or about.st_nlink > 1:
        DISK.close(handle)
        what = "has another name elsewhere (a hard link)" if stat.S_ISREG(about.st_mode) else "is not a plain file"
        raise UserError(f"{path}: {what}, and nothing is written to it; copy the folder and use the copy")
    return handle


def append(path: Path, text: str) -> None:
    """Append a text to a file of its own; see `open_growing`."""
    with growing(path) as handle:
        write_all(handle, text.encode(errors="backslashreplace"))


@contextlib.contextmanager
def growing(path: Path) -> Iterator[int]:
    """Hold a file open to append to it; see `open_growing`."""
    handle = open_growing(path)
    try:
        yield handle
    finally:
        DISK.close(handle)


def whole_lines_size(handle: int) -> int:
    """Bytes of an open file up to its last line feed: what follows is a line that a kill or a full disk left half."""
    size = os.fstat(handle).st_size
    tail = os.pread(handle, TAIL_BYTES, max(0, size - TAIL_BYTES))
    return size - (len(tail) - tail.rfind(b"\n") - 1)


def sync_quietly(folder: Path) -> None:
    """Sync a folder's names where the file system can; some network file systems cannot."""
    with contextlib.suppress(OSError):
        DISK.sync_folder(folder)
