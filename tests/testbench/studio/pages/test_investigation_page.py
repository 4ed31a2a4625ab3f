"""The page of investigations without a browser: the list, the belief after each run, and what is damaged."""

from __future__ import annotations

import shutil

import pytest
from nicegui.testing import User

from gcode.programs.make import make
from testbench.design.protocols import NOISE, menu
from testbench.investigating.state import (
    NAME,
    BeliefState,
    Investigation,
    RunState,
    Settings,
    program_folder,
    run_folder,
    save_investigation,
)
from testbench.studio.parts.picture import Picture
from testbench.studio.studio import Studio

pytestmark = pytest.mark.asyncio


@pytest.fixture
def investigated(studio: Studio) -> Studio:
    """An investigation of two runs in the workspace."""
    folder = studio.workspace.root / "knit-7"
    settings = Settings(bounds={"duration_s": 120}, budget_s=600)
    runs = []
    for number, chance in enumerate((0.6, 0.97), 1):
        made = make(menu(settings.limits)[NOISE], number, settings.gauge_length_mm)
        made.write(program_folder(folder, number))
        shutil.copytree(studio.workspace.root / "sleeve", run_folder(folder, number))
        chances = {"permanent_set": chance, "clamp_slip": 1 - chance}
        noise = {"force": 0.01}
        belief = BeliefState(probabilities=chances, own=chances, verdict="missing", noise=noise, pieces=30, likely=[])
        runs.append(RunState(words="random motion", seconds=118.0, recorded=True, belief=belief))
    save_investigation(folder, Investigation(sensor="pes", settings=settings, runs=runs, ended="sure"))
    return studio


async def test_the_belief_after_each_run_is_drawn_and_told(user: User, investigated: Studio) -> None:
    await user.open("/investigation?i=knit-7")
    await user.should_see("knit-7: permanent set: 97 % after 3.9 min of motion")
    await user.should_see("Recording of run 2")
    (drawn,) = user.find(Picture).elements
    assert drawn is not None
    investigated.deleted.add("knit-7/run-1")
    await user.open("/investigation?i=knit-7")
    await user.should_see("The recording of run 1 is gone.")
    await user.should_not_see("Recording of run 1")
    await user.should_see("Recording of run 2")


async def test_an_empty_workspace_says_how_to_begin(user: User) -> None:
    await user.open("/investigation")
    await user.should_see("No investigation yet")


async def test_a_wrong_name_and_a_damaged_file_are_sentences(user: User, investigated: Studio) -> None:
    await user.open("/investigation?i=absent")
    await user.should_see("no investigation 'absent'")
    (investigated.workspace.root / "knit-7" / NAME).write_text("{")
    await user.open("/investigation?i=knit-7")
    await user.should_see("not a investigation")
