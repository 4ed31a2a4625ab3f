"""What came of an import or of a run is still told where the page is read anew."""

from __future__ import annotations

import asyncio
import json
import time
from pathlib import Path

import pytest
from nicegui import ui
from nicegui.testing import User

from gcode.cli import main as gcode
from testbench.studio.jobs.job import Job, State
from testbench.studio.studio import Studio

pytestmark = pytest.mark.asyncio

DOUBT = "the force rises as the displacement falls: add --negate displacement"


def ended(studio: Studio, key: str, argv: list[str], state: State, said: str = "") -> Job:
    """A job that has just ended."""
    job = Job(key, key, tuple(argv), state=state, ended_s=time.monotonic())
    job.hear(said) if state is State.DONE else job.hear_error(f"error: {said}")
    studio.jobs.jobs.append(job)
    return job


def imported(studio: Studio, *doubts: str) -> str:
    return json.dumps({"recordings": [{"out": str(studio.workspace.root / "sleeve"), "doubts": list(doubts)}]})


async def test_what_an_import_doubted_is_told_again(user: User, studio: Studio) -> None:
    ended(studio, "import:sleeve", ["testbench", "import", "/lab/a.csv"], State.DONE, imported(studio, DOUBT))
    await user.open("/import")
    await user.should_see("sleeve: the force rises as the displacement falls")
    user.find("Open sleeve").click()
    await user.should_see("Duration", retries=50)


async def test_an_import_that_went_well_does_not_lead_away_from_a_page_that_is_read_anew(
    user: User, studio: Studio
) -> None:
    ended(studio, "import:sleeve", ["testbench", "import", "/lab/a.csv"], State.DONE, imported(studio))
    await user.open("/import")
    await user.should_see("Open sleeve")
    await user.should_see("Import a measurement")


async def test_why_an_import_failed_is_told_again_for_a_while(user: User, studio: Studio) -> None:
    argv = ["testbench", "import", "/lab/a.csv", "-o", "x"]
    job = ended(studio, "import:x", argv, State.FAILED, "/lab/a.csv: row 3: say --force-unit")
    await user.open("/import")
    await user.should_see("row 3: choose “Unit of force”", retries=50)
    job.ended_s = time.monotonic() - 1000
    await user.open("/import")
    await asyncio.sleep(0.3)
    await user.should_not_see("row 3")


async def test_the_result_of_a_run_is_told_again_beside_its_own_plan(user: User, studio: Studio) -> None:
    root: Path = studio.workspace.root
    for name in ("one", "two"):
        argv = ["generate", "--preset", "paper-1", "--seed", "3", "--gauge-length-mm", "25", "--duration-s", "20"]
        assert gcode([*argv, "-o", str(root / "programs" / name)]) == 0
    argv = ["testbench", "run", "--program", str(root / "programs" / "one" / "program.tap"), "-o"]
    ended(studio, "run:sleeve", [*argv, str(root / "sleeve")], State.DONE)
    await user.open("/plan?program=two")
    await user.should_see("Run it on the simulated rig")
    await user.should_not_see("Open sleeve")
    await user.open("/plan?program=one")
    await user.should_see("run:sleeve: done after")
    user.find("Open sleeve").click()
    await user.should_see("Duration", retries=50)
    ended(studio, "run:other", [*argv, str(root / "other")], State.FAILED, "the disk is full")
    await user.open("/plan?program=one")
    await user.should_see("the disk is full", retries=50)
    assert user.find(kind=ui.button, content="Run").elements
