"""A job: a command that the user could have typed, and what it says while it runs.

The studio shows the very command. Its JSON lines are its progress, its last words on stderr are its error.
"""

from __future__ import annotations

import asyncio
import contextlib
import shlex
import time
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

from gcode.support.errors import UserError
from gcode.support.strict import json_of
from testbench.studio.jobs.outliving import About
from testbench.studio.jobs.pace import Pace

KEPT_LINES = 400
Commands = Sequence[tuple[str, Sequence[str]]]  # title and command line


class State(Enum):
    """State of a job."""

    RUNNING = "running"
    DONE = "done"
    FAILED = "failed"
    CANCELLED = "cancelled"


@dataclass(eq=False)
class Job:
    """One command, running or ended.

    Attributes
    ----------
    key : str
        What the job is about; a second job with the same key is not started while the first runs.
    title : str
    argv : tuple of str
        As typed: ``("testbench", "fit", ...)``.
    share : float or None
        Progress from 0 to 1, where the command tells it.
    latest : dict
        The last JSON object it printed.
    """

    key: str
    title: str
    argv: tuple[str, ...]
    state: State = State.RUNNING
    share: float | None = None
    note: str = ""
    step: str = ""  # "motion 7 of 13", where the command counts
    latest: dict[str, Any] = field(default_factory=dict)
    lines: deque[str] = field(default_factory=lambda: deque(maxlen=KEPT_LINES))
    errors: deque[str] = field(default_factory=lambda: deque(maxlen=40))
    started_s: float = field(default_factory=time.monotonic)
    ended_s: float | None = None
    task: asyncio.Task | None = None
    process: asyncio.subprocess.Process | None = None
    pace: Pace = field(default_factory=Pace)
    about: About | None = None  # of a job that outlives the studio
    rest: Commands = ()  # what comes after it, once it has ended well, whether or not a page still looks
    followed_by: Job | None = None

    @property
    def command(self) -> str:
        """The command line, ready to be pasted into a terminal."""
        return shlex.join(self.argv)

    @property
    def elapsed_s(self) -> float:
        """Since its start, until its end."""
        return (self.ended_s or time.monotonic()) - self.started_s

    @property
    def running(self) -> bool:
        """Whether it has not ended yet."""
        return self.state is State.RUNNING

    @property
    def problem(self) -> str:
        """Its error in one sentence."""
        spoken = [line for line in self.errors if line.strip()]
        said = next((line for line in reversed(spoken) if "error: " in line), spoken[-1] if spoken else "")
        return said.partition("error: ")[2] or said or "it ended without saying why"

    def hear(self, line: str) -> None:
        """Take in one line of its stdout."""
        self.lines.append(line)
        if event := _event(line):
            self._take(event)

    def hear_error(self, line: str) -> None:
        """Take in one line of its stderr: progress, or words."""
        if event := _event(line):
            self._take(event)
        else:
            self.errors.append(line)

    def _take(self, event: dict[str, Any]) -> None:
        self.latest = event
        self.step = ""
        done, total = event.get("done", event.get("time_s")), event.get("total", event.get("duration_s"))
        if isinstance(done, int | float) and isinstance(total, int | float) and total > 0:
            self.share = min(1.0, done / total)
            # A command that does not say what it counts counts steps.
            self.step = f"{event.get('unit', 'step')} {event['done']} of {event['total']}" if "done" in event else ""
        said = [str(event[key]) for key in ("label", "note", "message") if event.get(key)]
        self.note = " · ".join(said) or self.note
        if event.get("note"):
            self.pace.hear(str(event["note"]), self.share, self.elapsed_s, self.step.partition(" of ")[0])


def _event(line: str) -> dict[str, Any] | None:
    if not line.startswith("{"):
        return None
    with contextlib.suppress(UserError):
        return json_of(line, "event")
    return None
