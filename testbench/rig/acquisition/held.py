"""One recorder to a folder: a lock on the folder itself, which leaves no file and ends with the process."""

from __future__ import annotations

import contextlib
import fcntl
import os
from collections.abc import Iterator
from pathlib import Path

from gcode.support.errors import UserError


@contextlib.contextmanager
def held(folder: Path) -> Iterator[None]:
    """Hold `folder` for this process alone, however the process ends.

    On a file system that cannot lock a folder the lock on ``recording.csv`` (`acquisition/appender.py`) must do.

    Raises
    ------
    UserError
        If another recorder holds it, or it is no folder.
    """
    try:
        handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    except OSError as error:
        raise UserError(f"{folder}: cannot record here: {error.strerror}") from None
    try:
        with contextlib.suppress(OSError):
            _lock(folder, handle)
        yield
    finally:
        os.close(handle)


def _lock(folder: Path, handle: int) -> None:
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise UserError(
            f"{folder}: another recorder is at work in this folder; end it first, or choose another"
        ) from None
