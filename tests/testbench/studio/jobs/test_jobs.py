"""Jobs are processes: they report, fail in words, can be cancelled, and never double."""

from __future__ import annotations

import asyncio
import signal
import sys
from pathlib import Path

import pytest

from testbench.studio.jobs.job import Job, State
from testbench.studio.jobs.jobs import JobBoard, interpreter_argv
from testbench.studio.parts.job_card import progress_in_words


async def ended(job: Job) -> Job:
    assert job.task
    await asyncio.wait_for(job.task, 30)
    return job


@pytest.mark.asyncio
async def test_a_job_is_what_a_user_could_type(tmp_path: Path) -> None:
    job = await ended(JobBoard().start("v", "Verify", ["testbench", "verify", str(tmp_path)]))
    assert job.state is State.FAILED
    assert "not a campaign" in job.problem
    assert job.command == f"testbench verify {tmp_path}"


@pytest.mark.asyncio
async def test_a_second_job_with_the_same_key_is_the_first_one() -> None:
    board = JobBoard()
    first = board.start("help", "Help", ["testbench", "--help"])
    assert board.start("help", "Help", ["testbench", "--help"]) is first
    assert (await ended(first)).state is State.DONE
    again = board.start("help", "Help", ["testbench", "--help"])
    assert again is not first
    await ended(again)


@pytest.mark.asyncio
async def test_cancelling_ends_the_process(monkeypatch: pytest.MonkeyPatch) -> None:
    started = [sys.executable, "-c", 'import time\nprint(\'{"done": 1, "total": 4}\', flush=True)\ntime.sleep(600)']
    monkeypatch.setattr("testbench.studio.jobs.jobs.interpreter_argv", lambda argv: started)
    board = JobBoard()
    job = board.start("long", "Long", ["testbench", "diagnose"])
    while job.share is None:
        await asyncio.sleep(0.01)
    assert job.share == 0.25
    await board.cancel(job)
    assert job.state is State.CANCELLED
    assert job.process is not None
    assert job.process.returncode is not None


@pytest.mark.asyncio
async def test_a_crash_is_told_in_words(monkeypatch: pytest.MonkeyPatch) -> None:
    crash = [sys.executable, "-c", "import os; os.kill(os.getpid(), 9)"]
    monkeypatch.setattr("testbench.studio.jobs.jobs.interpreter_argv", lambda argv: crash)
    job = await ended(JobBoard().start("crash", "Crash", ["testbench", "fit"]))
    assert job.state is State.FAILED
    assert job.problem == "something outside the studio ended it (SIGKILL)"


@pytest.mark.asyncio
async def test_an_interpreter_that_is_not_there_is_a_failed_job(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("testbench.studio.jobs.jobs.interpreter_argv", lambda argv: ["/nowhere/python"])
    job = await ended(JobBoard().start("none", "None", ["testbench", "fit"]))
    assert job.state is State.FAILED
    assert "No such file" in job.problem


def test_progress_is_read_from_either_form() -> None:
    job = Job("k", "t", ("testbench",))
    job.hear('{"time_s": 30, "duration_s": 60, "message": "force is high"}')
    assert (job.share, job.note) == (0.5, "force is high")
    job.hear("a plain line")
    job.hear('{"done": 3, "total": 4, "note": "creep"}')
    assert (job.share, job.note) == (0.75, "creep")
    assert list(job.lines)[1] == "a plain line"


def test_jobs_use_this_very_interpreter() -> None:
    interpreter, option, code, *arguments = interpreter_argv(["compensation", "train", "x"])
    assert (interpreter, option, arguments) == (sys.executable, "-c", ["train", "x"])
    assert code.endswith("from compensation.cli import main; sys.exit(main())")


WAITING = """
import time

def main():
    print('{"done": 1, "total": 4}', flush=True)
    try:
        time.sleep(600)
    except KeyboardInterrupt:
        return 77
"""


@pytest.mark.asyncio
async def test_a_job_of_a_studio_in_the_background_ends_well_when_it_is_stopped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "waiting").mkdir()
    (tmp_path / "waiting" / "cli.py").write_text(WAITING)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)  # what a shell does to all that it starts with "&"
    try:
        board = JobBoard()
        job = board.start("wait", "Wait", ["waiting"])
        while job.share is None:
            await asyncio.sleep(0.01)
        await board.cancel(job)
    finally:
        signal.signal(signal.SIGINT, before)
    assert job.process is not None
    assert job.process.returncode == 77, "not killed"


def test_what_a_command_says_to_a_terminal_is_no_progress() -> None:
    job = Job("rig", "Simulated rig", ("testbench", "rig"))
    job.hear_error("rig: the motion starts when the port is opened; kill 4711 ends the rig")
    assert "kill" not in progress_in_words(job)
    job.hear_error('{"note": "creep"}')
    assert progress_in_words(job).endswith("creep")


@pytest.mark.asyncio
async def test_what_comes_after_a_job_runs_without_a_page_that_looks() -> None:
    board = JobBoard()
    help_of = ["testbench", "fit", "--help"]
    first = board.start("train:a", "Train", ["testbench", "--help"], [("Score", help_of), ("Export", help_of)])
    await ended(first)
    second = first.followed_by
    assert second is not None
    assert (second.title, board.running()) == ("Score", [second])
    await ended(second)
    assert second.followed_by is not None
    assert (await ended(second.followed_by)).state is State.DONE
    assert board.running() == []


@pytest.mark.asyncio
async def test_nothing_comes_after_a_job_that_failed(tmp_path: Path) -> None:
    board = JobBoard()
    failing = ["testbench", "verify", str(tmp_path)]
    first = await ended(board.start("v", "Verify", failing, [("Help", ["testbench", "--help"])]))
    assert first.followed_by is None
    assert board.running() == []
