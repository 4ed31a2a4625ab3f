"""Long work as processes of our own command line, so that nothing a job does can take the page down."""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from gcode.support.errors import UserError
from testbench.studio.jobs.job import Commands, Job, State
from testbench.studio.jobs.outliving import HEEDS_CTRL_C, Outliving, job_environment
from testbench.studio.jobs.pace import Paces

PATIENCE_S = 5.0  # how long a cancelled job may take to end well before it is killed
LONG_PATIENCE_S = 60.0  # a recorder has hours of samples to bring to disk and to check


class JobBoard:
    """All jobs of a studio; shared by its tabs, so two tabs see one and the same job.

    Parameters
    ----------
    outliving : mapping of key to Path, optional
        Kinds of jobs that go on when the studio ends, each with the folder that it is followed in.
    paces : Path, optional
        Where it is kept how long jobs have taken.
    done : callable
        Told of every job that has ended well.
    """

    def __init__(
        self,
        outliving: Mapping[str, Path] | None = None,
        paces: Path | None = None,
        done: Callable[[Job], object] = lambda _: None,
    ) -> None:
        self.jobs: list[Job] = []
        self._paces, self._done = Paces(paces), done
        self._outliving = {key: Outliving(folder) for key, folder in (outliving or {}).items()}

    def find(self, key: str) -> Job | None:
        """The newest job with this key, were it started by a studio that is no more."""
        self._adopt(key)
        return next((job for job in reversed(self.jobs) if job.key == key), None)

    def last_command(self, key: str) -> tuple[str, ...]:
        """The command line of the last job that may outlive the studio, were it started by an earlier one."""
        about = self._outliving[key].last()
        return about.argv if about else ()

    def running(self) -> list[Job]:
        """Every job that has not ended, those of an earlier studio too."""
        for key in self._outliving:
            self._adopt(key)
        return [job for job in self.jobs if job.running]

    def under_way(self, key: str) -> Job | None:
        """The job with this key that has not ended; None where there is none."""
        job = self.find(key)
        return job if job and job.running else None

    def start(self, key: str, title: str, argv: Sequence[str], rest: Commands = ()) -> Job:
        """Start a command and, when it has ended well, the `rest`; or return what is running under this key."""
        if running := self.under_way(key):
            return running
        job = Job(key, title, tuple(argv), pace=self._paces.start(argv), rest=rest)
        self.jobs.append(job)
        job.task = asyncio.create_task(self._outlive(job) if key in self._outliving else self._run(job))
        return job

    async def _run(self, job: Job) -> None:
        await _run(job)
        if job.state is State.DONE:
            self._paces.keep(job.argv, job.pace, job.elapsed_s)
            self._done(job)
            if job.rest:
                (title, argv), *rest = job.rest
                job.followed_by = self.start(job.key, title, argv, rest)

    def _adopt(self, key: str) -> None:
        """Take in a job that lives and that this board does not know: an earlier studio has started it."""
        outliving = self._outliving.get(key)
        about = outliving.last() if outliving and outliving.alive() else None
        if about is None or any(job.key == key and (job.running or job.about == about) for job in self.jobs):
            return
        job = Job(key, about.title, about.argv, about=about)
        self.jobs.append(job)
        job.task = asyncio.create_task(self._follow(job))

    async def _outlive(self, job: Job) -> None:
        try:
            job.about = self._outliving[job.key].start(job.title, job.argv)
        except (OSError, UserError) as error:
            job.hear_error(f"error: {error}")
            _end(job, -1)
            return
        if job.state is State.CANCELLED:  # cancelled before it was born
            self._signal(job, signal.SIGINT)
        await self._follow(job)

    async def _follow(self, job: Job) -> None:
        outliving = self._outliving[job.key]
        await outliving.follow(job.hear, job.hear_error)
        code = outliving.code()
        if code is None and job.state is State.RUNNING:
            job.hear_error("error: something outside the studio ended it")
        _end(job, -1 if code is None else code)
        if job.state is State.DONE:
            self._done(job)

    async def cancel(self, job: Job) -> None:
        """Ask a job to end (as Ctrl-C would), kill it if it does not, and wait until it is gone."""
        if not job.running:
            return
        job.state = State.CANCELLED
        self._signal(job, signal.SIGINT)
        if job.task:
            patience_s = PATIENCE_S if job.about is None else LONG_PATIENCE_S
            done, _ = await asyncio.wait({job.task}, timeout=patience_s)
            if not done:
                self._signal(job, signal.SIGKILL)
                await asyncio.wait({job.task}, timeout=PATIENCE_S)

    async def close(self) -> list[Job]:
        """End every job but those that outlive the studio, which are returned; called when the studio closes."""
        left = [job for job in self.jobs if job.running and job.key in self._outliving]
        await asyncio.gather(*(self.cancel(job) for job in self.jobs if job.running and job not in left))
        for job in left:
            if job.task:
                job.task.cancel()
        return left

    def _signal(self, job: Job, number: signal.Signals) -> None:
        if job.about is not None:
            self._outliving[job.key].signal(job.about, number)
        elif job.process and job.process.returncode is None:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(job.process.pid, number)


def interpreter_argv(argv: Sequence[str]) -> list[str]:
    """The command with this very interpreter, wherever the console scripts are."""
    program, *arguments = argv
    return [sys.executable, "-c", f"{HEEDS_CTRL_C}; from {program}.cli import main; sys.exit(main())", *arguments]


async def _run(job: Job) -> None:
    try:
        job.process = await asyncio.create_subprocess_exec(
            *interpreter_argv(job.argv),
            stdin=asyncio.subprocess.DEVNULL,
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.PIPE,
            env=job_environment(),
            limit=2**24,
            start_new_session=True,  # a signal then reaches the job's own children too
        )
        if job.state is State.CANCELLED:  # cancelled before it was born
            os.killpg(job.process.pid, signal.SIGINT)
        assert job.process.stdout
        assert job.process.stderr
        await asyncio.gather(_listen(job.process.stdout, job.hear), _listen(job.process.stderr, job.hear_error))
        code = await job.process.wait()
    except (OSError, ValueError) as error:
        job.hear_error(f"error: {error}")
        code = -1
    if code < 0 and job.state is State.RUNNING and not job.errors:
        job.hear_error(f"error: something outside the studio ended it ({signal.Signals(-code).name})")
    _end(job, code)


def _end(job: Job, code: int) -> None:
    job.ended_s = time.monotonic()
    if job.state is State.RUNNING:
        job.state = State.DONE if code == 0 else State.FAILED


async def _listen(stream: asyncio.StreamReader, hear: Callable[[str], None]) -> None:
    while raw := await stream.readline():
        hear(raw.decode("utf-8", "replace").rstrip("\r\n"))
