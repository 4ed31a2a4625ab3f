"""Progress of commands whose work tells what it does in words."""

from __future__ import annotations

import json
import os
import sys


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
            print(f"\r\x1b[K{count}{text}"[:110], end="", file=sys.stderr, flush=True)
