"""One growing file: what the disk refuses is kept, and tried again with the next write."""

from __future__ import annotations

import contextlib
import fcntl
import os
from collections.abc import Iterator
from pathlib import Path

from gcode.support import disk
from gcode.support.errors import UserError


class Appender:
    """Appends text to one file; what the disk refuses it keeps, and tries again with the next write.

    Attributes
    ----------
    pending : bytes
        What the disk has not taken yet.
    refusal : OSError or None
        Why it did not.
    sync_failures : int
        How often the disk said that it could not keep what it had taken.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.pending = b""
        self.refusal: OSError | None = None
        self.sync_failures = 0
        self._handle: int | None = None
        self._named = False
        self._size = 0  # at least; another's bytes are found by whoever reads the file

    def open(self) -> int:
        """The open file, made if it is not there; its name is kept with the first sync."""
        if self._handle is None:
            self._handle = disk.open_growing(self.path)
            self._named, self._size = False, os.fstat(self._handle).st_size
        return self._handle

    def write(self, text: str) -> bool:
        """Append; whether everything is written."""
        self.pending += text.encode()
        try:
            while self.pending:
                self.open()
                self.pending = self.pending[self.take(self.pending) :]
        except OSError as error:
            self.refusal = error
            return False
        self.refusal = None
        return True

    def lock(self) -> None:
        """Refuse a second recorder on this file; the lock ends with this process, however it ends."""
        try:
            fcntl.flock(self.open(), fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            self._shut()
            raise UserError(f"{self.path}: another recorder is writing this file; choose another") from None

    def sync(self) -> None:
        """Have the disk keep what was written, and the file's name."""
        if self._handle is None:
            return
        try:
            disk.DISK.sync(self._handle)
        except OSError:
            self.sync_failures += 1
        if not self._named:
            disk.sync_quietly(self.path.parent)
            self._named = True

    def take(self, data: bytes) -> int:
        """Give `data` to the operating system; how many bytes it took."""
        taken = disk.DISK.write(self.open(), data)
        self._size += taken
        return taken

    @property
    def disturbed(self) -> bool:
        """Whether another program has removed the file, put another one in its place, or cut it."""
        if self._handle is None:
            return False
        mine = os.fstat(self._handle)
        try:
            named = self.path.lstat()
        except OSError:
            return True
        return (named.st_dev, named.st_ino) != (mine.st_dev, mine.st_ino) or mine.st_size < self._size

    @property
    def empty(self) -> bool:
        """Whether the file holds nothing."""
        return os.fstat(self.open()).st_size == 0

    def drop(self) -> bool:
        """Forget what is pending and cut the line that it left half written; whether that could be done."""
        self.pending, self.refusal = b"", None
        if self._handle is None:
            return True
        try:
            self._size = disk.whole_lines_size(self._handle)
            disk.DISK.truncate(self._handle, self._size)
        except OSError as error:
            self.refusal = error
        return self.refusal is None

    def close(self) -> bool:
        """Write what is pending, sync and close. What the disk does not take is gone, but leaves no half line.

        Returns
        -------
        bool
            Whether the file ends with a whole line.
        """
        whole = self.write("") or self.drop()
        self.sync()
        self._shut()
        return whole

    def _shut(self) -> None:
        if self._handle is not None:
            with contextlib.suppress(OSError):
                disk.DISK.close(self._handle)
            self._handle = None


@contextlib.contextmanager
def held(folder: Path) -> Iterator[None]:
    """Hold `folder` for this process alone, however the process ends; the lock leaves no file.

    On a file system that cannot lock a folder the lock on ``recording.csv`` (`Appender.lock`) must do.

    Raises
    ------
    UserError
        If another recorder holds it, or it is no folder.
    """
    try:
        handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    except OSError as error:
        raise UserError(f"{folder}: cannot record here: {error.strerror}") from None
    busy = f"{folder}: another recorder is at work in this folder; end it first, or choose another"
    try:
        with contextlib.suppress(OSError):
            try:
                fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                raise UserError(busy) from None
        yield
    finally:
        os.close(handle)
