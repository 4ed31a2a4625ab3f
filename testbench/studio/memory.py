"""What was worked out once for a page and need not be again until a file changes."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from pathlib import Path
from threading import Lock
from typing import Any, TypeVar

T = TypeVar("T")

KEPT = 12  # views of 23 min take about 2 MB each


def stamp(*paths: Path | None) -> tuple:
    """Changes whenever one of the files does; one that is not there has a stamp too."""
    return tuple(_one(path) for path in paths if path)


def _one(path: Path) -> tuple:
    try:
        info = path.stat()
    except OSError:
        return str(path), None
    return str(path), info.st_mtime_ns, info.st_size


class Memory:
    """The last few results, the least used forgotten first; shared by all tabs, safe among threads."""

    def __init__(self, kept: int = KEPT) -> None:
        self._kept = kept
        self._results: OrderedDict[Hashable, Any] = OrderedDict()
        self._lock = Lock()

    def recall(self, key: Hashable, make: Callable[[], T]) -> T:
        """The result kept under `key`, or, where there is none yet, made now."""
        with self._lock:
            if key in self._results:
                self._results.move_to_end(key)
                return self._results[key]
        result = make()  # outside the lock: two tabs may make it twice, none waits for another's
        with self._lock:
            self._results[key] = result
            while len(self._results) > self._kept:
                self._results.popitem(last=False)
        return result
