"""A job that outlives the studio: found again, followed to its end, never two of a kind."""

from __future__ import annotations

import asyncio
import os
import signal
from pathlib import Path

import pytest

from gcode.cli import main as gcode
from testbench.studio.jobs.job import Job, State
from testbench.studio.jobs.jobs import JobBoard
from testbench.studio.jobs.outliving import CAUGHT_UP_BYTES
from testbench.studio.tail import Tail

RIG = "rig"


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("program") / "minute"
    motion = ["--preset", "paper-1", "--seed", "1", "--gauge-length-mm", "25", "--duration-s", "60"]
    assert gcode(["generate", *motion, "-o", str(folder)]) == 0
    return folder / "program.tap"


def rig(program: Path, link: Path) -> list[str]:
    """A job that waits until it is told to end: the simulated rig, which nobody listens to."""
    return ["testbench", "rig", "--sensor", "pes", "--program", str(program), "--link", str(link)]


async def until_heard(job: Job) -> None:
    while not job.lines:
        await asyncio.sleep(0.02)


async def ended(job: Job) -> Job:
    assert job.task
    await asyncio.wait_for(job.task, 60)
    return job


@pytest.mark.asyncio
@pytest.mark.parametrize("ctrl_c", [signal.default_int_handler, signal.SIG_IGN])
async def test_a_later_board_finds_the_job_and_ends_it(tmp_path: Path, program: Path, ctrl_c) -> None:
    """Also where the studio was started with ``&``, which makes all that it starts ignore Ctrl-C."""
    first = JobBoard({RIG: tmp_path / "running"})
    before = signal.signal(signal.SIGINT, ctrl_c)
    try:
        job = first.start(RIG, "Rig", rig(program, tmp_path / "port"))
        await until_heard(job)
    finally:
        signal.signal(signal.SIGINT, before)
    assert await first.close() == [job], "it is left running"
    second = JobBoard({RIG: tmp_path / "running"})
    found = second.find(RIG)
    assert found is not None
    assert (found.title, found.argv, found.running) == (job.title, job.argv, True)
    assert second.start(RIG, "Another", ["testbench", "rig"]) is found
    await until_heard(found)
    await second.cancel(found)
    assert found.state is State.CANCELLED
    assert not (tmp_path / "port").is_symlink(), "it ended well: Ctrl-C takes its link away"
    assert JobBoard({RIG: tmp_path / "running"}).find(RIG) is None
    assert second.last_command(RIG) == job.argv


@pytest.mark.asyncio
async def test_a_killed_job_is_known_to_be_dead(tmp_path: Path, program: Path) -> None:
    board = JobBoard({RIG: tmp_path / "running"})
    job = board.start(RIG, "Rig", rig(program, tmp_path / "port"))
    await until_heard(job)
    assert job.about
    os.kill(job.about.pid, signal.SIGKILL)
    await ended(job)
    assert job.state is State.FAILED
    assert job.problem == "something outside the studio ended it"


@pytest.mark.asyncio
async def test_its_error_is_heard_and_its_code_is_known(tmp_path: Path) -> None:
    board = JobBoard({RIG: tmp_path / "running"})
    job = await ended(board.start(RIG, "Rig", rig(tmp_path / "absent.tap", tmp_path / "port")))
    assert job.state is State.FAILED
    assert "absent.tap" in job.problem
    done = await ended(board.start(RIG, "Rig", ["testbench", "--help"]))
    assert done.state is State.DONE


def test_a_long_log_is_caught_up_with_from_its_end(tmp_path: Path) -> None:
    path = tmp_path / "said"
    path.write_text("".join(f"line {number}\n" for number in range(100_000)))
    tail = Tail(path, CAUGHT_UP_BYTES)
    lines = tail.fresh()
    assert lines[-1] == "line 99999"
    assert all(line.startswith("line ") for line in lines), "no torn line"
    assert len("\n".join(lines)) <= CAUGHT_UP_BYTES
    with path.open("a") as stream:
        stream.write("half")
    assert tail.fresh() == []
    with path.open("a") as stream:
        stream.write(" and half\n")
    assert tail.fresh() == ["half and half"]
