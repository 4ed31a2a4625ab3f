"""Ctrl-C ends a recording well; a second one ends the program at once. How to end what runs in the background."""

from __future__ import annotations

import contextlib
import os
import signal
from collections.abc import Callable, Iterator

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


@contextlib.contextmanager
def stop_signals() -> Iterator[Callable[[], bool]]:
    """Within the block, the first signal only sets a flag; the block gets a function that reads it."""
    asked = False

    def stop(number: int, frame: object) -> None:
        nonlocal asked
        if asked:
            raise KeyboardInterrupt
        asked = True

    before = {number: signal.signal(number, stop) for number in SIGNALS}
    try:
        yield lambda: asked
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def what_ends_it() -> str:
    """``Ctrl-C``, where this program is in the foreground of a terminal; elsewhere the ``kill`` that ends it.

    A shell keeps Ctrl-C from what was started with ``&`` (what it starts ignores it), and a program without a
    terminal never gets one.
    """
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        return f"kill {os.getpid()}"
    try:
        terminal = os.open(os.ctermid(), os.O_RDONLY | os.O_NOCTTY)
    except OSError:
        return f"kill {os.getpid()}"
    try:
        in_foreground = os.tcgetpgrp(terminal) == os.getpgrp()
    except OSError:
        in_foreground = False
    finally:
        os.close(terminal)
    return "Ctrl-C" if in_foreground else f"kill {os.getpid()}"
