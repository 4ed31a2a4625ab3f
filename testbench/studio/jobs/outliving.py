"""Jobs that outlive the studio: a recorder goes on when the page, the server or the terminal does not.

Such a job is a process of its own session. It writes what it says into files, and holds a lock on one of them as long
as it lives; so a studio that is started later knows whether it still runs, and follows it as if it had started it.
"""

from __future__ import annotations

import asyncio
import contextlib
import fcntl
import json
import os
import secrets
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from pydantic import Field

from gcode.support.disk import DISK, open_growing
from gcode.support.errors import UserError
from gcode.support.files import make_folder, write_text
from gcode.support.strict import read_json, read_text, validated
from testbench.studio.tail import Tail

POLLED_S = 0.1
LEFT: list[subprocess.Popen] = []  # running children that this process may forget, but not disown with a warning
CAUGHT_UP_BYTES = 1 << 16  # of what a job has said before it was found again
ABOUT, ALIVE, SAID, ERRORS, CODE = "job.json", "alive", "said.jsonl", "errors.txt", "code"
# A job can be interrupted even where the studio was started with ``&``, which makes all that it starts ignore that.
HEEDS_CTRL_C = "import signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler)"
# The exit code is left in a file: whoever finds the job later is not its parent.
WRAPPED = f"""{HEEDS_CTRL_C}
from importlib import import_module
program, code_file = sys.argv.pop(1), sys.argv.pop(1)
try:
    code = import_module(program + ".cli").main()
except SystemExit as end:
    code = end.code if isinstance(end.code, int) else 1
open(code_file, "w").write(str(int(code or 0)))
sys.exit(code)
"""


def job_environment() -> dict[str, str]:
    """What a job finds in its environment: ours, and that it is to tell its progress as JSON, line by line."""
    return {**os.environ, "KNITBENCH_PROGRESS": "json", "PYTHONUNBUFFERED": "1"}


@dataclass(frozen=True)
class About:
    """What a job wrote about itself when it started."""

    identity: str
    title: str
    argv: tuple[str, ...]
    pid: Annotated[int, Field(gt=1)]  # 0 and -1 would name the studio's own processes, or all


class Outliving:
    """The one job of a kind that may outlive the studio, in a folder of its own, made when the first starts."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def start(self, title: str, argv: Sequence[str]) -> About:
        """Start a command of ours in a session of its own.

        Raises
        ------
        OSError
            If it cannot be started.
        UserError
            If something else is in the place of a file of its own.
        """
        make_folder(self.folder)
        for name in (SAID, ERRORS, CODE):
            (self.folder / name).unlink(missing_ok=True)
        program, *arguments = argv
        command = [sys.executable, "-c", WRAPPED, program, str(self.folder / CODE), *arguments]
        with contextlib.ExitStack() as until_started:

            def kept(handle: int) -> int:
                until_started.callback(os.close, handle)
                return handle

            alive = kept(open_growing(self.folder / ALIVE))
            fcntl.flock(alive, fcntl.LOCK_EX | fcntl.LOCK_NB)
            said, errors = (kept(DISK.create(self.folder / name)) for name in (SAID, ERRORS))
            process = subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=said,
                stderr=errors,
                env=job_environment(),
                pass_fds=[alive],  # the lock is the child's from here on
                start_new_session=True,
            )
            LEFT.append(process)
        about = About(secrets.token_hex(8), title, tuple(argv), process.pid)
        write_text(self.folder / ABOUT, json.dumps(vars(about)) + "\n")
        return about

    def last(self) -> About | None:
        """The last job, whether it still runs or not."""
        with contextlib.suppress(UserError):
            path = self.folder / ABOUT
            return validated(read_json(path, "job", 1 << 20), About, path, "job")
        return None

    def alive(self) -> bool:
        """Whether its process lives: the system takes the lock back when it ends, however it ends."""
        for process in LEFT:
            process.poll()  # leaves no zombie behind
        try:
            handle = os.open(self.folder / ALIVE, os.O_RDWR | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
        except OSError:
            return False  # none was started, or what is there is none of ours
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return True
        finally:
            os.close(handle)
        return False

    def code(self) -> int | None:
        """How it ended; None when something ended it from outside."""
        with contextlib.suppress(OSError, ValueError):
            return int(read_text(self.folder / CODE, "exit code", 100))
        return None

    def signal(self, about: About, number: int) -> None:
        """Send a signal to the job and to its children, if it still lives."""
        if self.alive():
            with contextlib.suppress(ProcessLookupError):
                os.killpg(about.pid, number)

    async def follow(self, hear: Callable[[str], None], hear_error: Callable[[str], None]) -> None:
        """Pass on what it says, line by line, until it has ended; a job found again is caught up with."""
        tails = [
            (Tail(self.folder / name, CAUGHT_UP_BYTES), listener)
            for name, listener in ((SAID, hear), (ERRORS, hear_error))
        ]
        living = True
        while living:
            living = self.alive()  # asked before the look, so that the last look hears its last words
            for tail, listener in tails:
                while lines := tail.fresh():
                    for line in lines:
                        listener(line)
            if living:
                await asyncio.sleep(POLLED_S)
