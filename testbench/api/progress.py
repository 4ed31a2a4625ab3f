"""Progress for whoever watches: a line in a notebook or a terminal, JSON for a program, nothing for a script."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from html import escape
from typing import Any

from gcode.support.console import Progress
from gcode.support.errors import UserError
from gcode.support.streams import redrawn

Tell = Callable[[str], None]


class Telling:
    """Words on stderr where somebody watches, JSON lines where a program does, counted where they can be.

    Parameters
    ----------
    unit : str
        What is counted.
    total : int
        How many there are; 0: they are not counted.
    counted : str
        Words of this beginning count one.
    """

    def __init__(self, unit: str = "step", total: int = 0, counted: str = "") -> None:
        self.unit, self.total, self.done, self._counted = unit, total, 0, counted

    def __call__(self, text: str) -> None:
        if self.total and text.startswith(self._counted):
            self.done = min(self.done + 1, self.total)
        if os.environ.get("KNITBENCH_PROGRESS") == "json":
            event: dict[str, object] = {"note": text}
            if self.done:
                event |= {"unit": self.unit, "done": self.done, "total": self.total}
            print(json.dumps(event), file=sys.stderr, flush=True)
        elif sys.stderr.isatty():
            count = f"{self.unit} {self.done} of {self.total}: " if self.done and text else ""
            print(redrawn(f"{count}{text}"), end="", file=sys.stderr, flush=True)


class Counting:
    """Words that each count one step on a line with the time left; how many there will be is only nearly known.

    Parameters
    ----------
    label : str
        What is being done.
    expected : int
        Number of steps; raised where there are more of them.
    """

    def __init__(self, label: str, expected: int) -> None:
        self._line = Progress(label, expected)

    def __call__(self, text: str) -> None:
        self._line.total = max(self._line.total, self._line.done + 2)
        self._line.step(text)


def clear_line() -> None:
    """Take away the line of progress, where somebody watches it in a terminal."""
    if sys.stderr.isatty():
        print(redrawn(""), end="", file=sys.stderr)


class _NotebookLine:
    """One line of a notebook's output, written over; a fork of the kernel has no wire to the notebook."""

    def __init__(self, display: Callable[..., Any]) -> None:
        self._handle, self._kernel = display(_Html(""), display_id=True), os.getpid()

    def __call__(self, text: str) -> None:
        if os.getpid() == self._kernel:
            self._handle.update(_Html(escape(text)))


class _Html:
    """Text that a notebook shows as HTML."""

    def __init__(self, text: str) -> None:
        self._text = text

    def _repr_html_(self) -> str:
        return f"<small>{self._text}</small>"


@contextmanager
def telling(progress: Tell | bool | None) -> Iterator[Tell | None]:
    """What a long function calls with a short text at each step; the line is gone when it is done.

    Parameters
    ----------
    progress : callable, bool or None
        A callable is used as it is, False says nothing, None or True shows a line where somebody watches.
    """
    if not (progress is None or isinstance(progress, bool) or callable(progress)):
        raise UserError(f"progress must be True, False or a callable that takes a text, got {progress!r}")
    if progress is False:
        yield None
    elif callable(progress):
        yield progress
    else:
        tell = _NotebookLine(display) if (display := _notebook_display()) else Telling()
        try:
            yield tell
        finally:
            tell("")


def _notebook_display() -> Callable[..., Any] | None:
    """IPython's `display` in the kernel of a notebook; None elsewhere."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    if type(shell).__name__ != "ZMQInteractiveShell":
        return None
    from IPython.display import display

    return display
