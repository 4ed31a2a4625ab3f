"""Standard input, output and error as a command can rely on: there, taking any character, and never in the way."""

from __future__ import annotations

import contextlib
import os
import shutil
import sys
from collections.abc import Callable
from typing import Any, TextIO

NAMES = ("stdin", "stdout", "stderr")


def make_ready() -> None:
    """Open what was closed, and show characters that the terminal's encoding has not as ``\\xb1``.

    A stream that the caller closed (``2>&-``) leaves its number free: the next file opened gets it, and what a
    library writes to standard error lands in a recording. Python has no object for such a stream, either.
    """
    for number, name in enumerate(NAMES):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDONLY if number == 0 else os.O_WRONLY)  # gets the lowest free number: this one
        stream: TextIO | None = getattr(sys, name)
        if stream is None:
            setattr(sys, name, open(os.devnull, "r" if number == 0 else "w", encoding="utf-8"))  # noqa: SIM115
        elif number and hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")


def redrawn(text: str) -> str:
    """What shows `text` in place of a terminal's last line, and no wider: a line that wraps cannot be redrawn."""
    width = max(shutil.get_terminal_size().columns - 1, 1)
    cleared = f"\r{' ' * width}\r" if os.environ.get("TERM") == "dumb" else "\r\x1b[K"
    return f"{cleared}{text[:width]}"


class Beside:
    """A stream that is written to in another way: a subclass says what becomes of a call of it."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        """Write it, as far as it can be."""
        self._act(lambda: self._stream.write(text))
        return len(text)

    def flush(self) -> None:
        """Pass it on, as far as it can be."""
        self._act(self._stream.flush)

    def _act(self, call: Callable[[], object]) -> None:
        raise NotImplementedError

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


class Remarks(Beside):
    """A stream for what is said beside the work (standard error): where nobody can take it, the work goes on.

    The terminal may be gone, the reader of a pipe, or the room on a disk: a recording outlives each of them.
    """

    def _act(self, call: Callable[[], object]) -> None:
        with contextlib.suppress(OSError):
            call()
