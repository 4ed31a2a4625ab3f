"""Refits side by side: in processes where the system can fork one, in threads elsewhere.

A refit is many short calls of NumPy, and threads wait for each other between them: two threads gain a tenth of the
time, two processes nearly half of it. A forked process sees all that its parent has; only what comes out is sent
back.
"""

from __future__ import annotations

import ctypes
import multiprocessing
import os
import signal
import sys
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from typing import Any, TypeVar

DIE_WITH_PARENT = 1  # PR_SET_PDEATHSIG of Linux
MOST = 3  # at once: of a pair of 6 h each has 0.3 to 0.5 GB of its own, and 2 GB hold them all

Result = TypeVar("Result")
_task: tuple[Callable[..., Any], list[tuple[Any, ...]]]


class SideBySide:
    """Calls functions that change nothing but what they return.

    Parameters
    ----------
    classes : iterable of type
        Of what comes out. One that its module's name and its own do not lead to, such as that of a user's file,
        cannot be sent from one process to another.
    """

    def __init__(self, classes: Iterable[type] = ()) -> None:
        self.count = min(_cores(), MOST)
        self.forks = _can_fork() and all(map(_is_found_by_name, classes))

    def map(self, fn: Callable[..., Result], *iterables: Iterable[Any]) -> list[Result]:
        """Results in the order of the arguments.

        Raises
        ------
        Exception
            The first that a call raised.
        """
        calls = list(zip(*iterables, strict=False))
        if self.count == 1 or len(calls) < 2:
            return [fn(*call) for call in calls]
        if not self.forks:
            with ThreadPoolExecutor(self.count) as threads:
                return list(threads.map(lambda call: fn(*call), calls))
        return self._in_processes(fn, calls)

    def _in_processes(self, fn: Callable[..., Result], calls: list[tuple[Any, ...]]) -> list[Result]:
        context, workers = multiprocessing.get_context("fork"), min(self.count, len(calls))
        processes = ProcessPoolExecutor(workers, context, initializer=_take, initargs=(fn, calls, os.getpid()))
        try:
            found = list(processes.map(_made, range(len(calls))))
        except BaseException:
            processes.shutdown(wait=False, cancel_futures=True)  # nobody waits for the rest
            raise
        processes.shutdown()  # its threads must have ended before the next fork
        return found


def _take(fn: Callable[..., Any], calls: list[tuple[Any, ...]], parent: int) -> None:
    """Begin a forked process, which is ended when its parent dies, however that happens: else it would wait for ever.

    An interruption from the keyboard goes to the parent alone.
    """
    global _task
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    ctypes.CDLL(None).prctl(DIE_WITH_PARENT, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(1)
    _task = fn, calls


def _made(number: int) -> Any:
    fn, calls = _task
    return fn(*calls[number])


def _is_found_by_name(one: type) -> bool:
    return getattr(sys.modules.get(one.__module__), one.__qualname__, None) is one


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if sys.platform == "linux" else os.cpu_count() or 1


def _can_fork() -> bool:
    """On Linux, but for processes that may have no children; forks of macOS break its own libraries."""
    return sys.platform == "linux" and not multiprocessing.current_process().daemon
