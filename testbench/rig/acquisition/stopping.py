"""Ctrl-C ends a recording well; a second one ends the program at once. How to end what runs in the background."""

from __future__ import annotations

import contextlib
import os
import signal
import threading
from collections.abc import Callable, Iterator

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


@contextlib.contextmanager
def stop_signals() -> Iterator[Callable[[], bool]]:
    """Within the block, the first signal only sets a flag; the block gets a function that reads it.

    A hang-up that is ignored (`nohup`) stays so. Outside the main thread, which alone gets signals, there are none.
    """
    asked = False

    def stop(number: int, frame: object) -> None:
        nonlocal asked
        if asked:
            raise KeyboardInterrupt
        asked = True

    main = threading.current_thread() is threading.main_thread()
    before = {number: signal.signal(number, stop) for number in SIGNALS if main and _is_heeded(number)}
    try:
        yield lambda: asked
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def end_as_ctrl_c() -> None:
    """Let a kill and a hang-up end this program as Ctrl-C does: it then takes away what must not stay behind."""
    for number in SIGNALS[1:]:
        if _is_heeded(number):
            signal.signal(number, signal.default_int_handler)


def _is_heeded(number: signal.Signals) -> bool:
    return number != signal.SIGHUP or signal.getsignal(number) is not signal.SIG_IGN


def what_ends_it() -> str:
    """``Ctrl-C``, where this program is in the foreground of a terminal; elsewhere the ``kill`` that ends it.

    A shell keeps Ctrl-C from what was started with ``&`` (what it starts ignores it), and a program without a
    terminal never gets one.
    """
    heeds = signal.getsignal(signal.SIGINT) is not signal.SIG_IGN
    return "Ctrl-C" if heeds and _is_in_foreground() else f"kill {os.getpid()}"


def _is_in_foreground() -> bool:
    """Whether this program has a terminal, and is what that terminal is busy with."""
    try:
        terminal = os.open(os.ctermid(), os.O_RDONLY | os.O_NOCTTY)
    except OSError:
        return False
    try:
        return os.tcgetpgrp(terminal) == os.getpgrp()
    except OSError:
        return False
    finally:
        os.close(terminal)
