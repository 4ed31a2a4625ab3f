"""A studio over a small folder of campaigns, and a simulated user of it."""

from __future__ import annotations

import logging
import shutil
from collections.abc import AsyncIterator, Iterable
from pathlib import Path

import pytest
import pytest_asyncio
from nicegui.testing import User
from nicegui.testing.user_simulation import user_simulation

import tests.testbench.report.samples as samples
from testbench.cli import main
from testbench.recordings.files import write_recording_csv
from testbench.studio.shell import frame
from testbench.studio.studio import Studio


@pytest.fixture(autouse=True)
def own_state(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What the user agreed to is kept for this test alone."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))


@pytest.fixture(scope="session")
def campaign_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with one imported campaign, ``sleeve``."""
    root = tmp_path_factory.mktemp("workspace")
    foreign = tmp_path_factory.mktemp("foreign") / "lab.csv"
    write_recording_csv(foreign, samples.recording(3000))
    columns = ["--time", "time_s", "--displacement", "displacement_mm", "--force", "force_N"]
    columns += ["--resistance", "resistance_ohm", "--gauge-length-mm", "25"]
    assert main(["import", str(foreign), *columns, "-o", str(root / "sleeve")]) == 0
    return root


@pytest.fixture(scope="session")
def fitted_model(campaign_folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The baseline fitted to ``sleeve``."""
    path = tmp_path_factory.mktemp("model") / "model.json"
    assert main(["fit", str(campaign_folder / "sleeve"), "-o", str(path)]) == 0
    return path


@pytest.fixture
def studio(campaign_folder: Path, tmp_path: Path) -> Studio:
    """A studio over its own copy of the campaigns."""
    shutil.copytree(campaign_folder, tmp_path / "ws")
    return Studio(tmp_path / "ws")


@pytest_asyncio.fixture
async def user(
    studio: Studio, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> AsyncIterator[User]:
    """A user without a browser; nothing on a page waits, and no handler may raise."""
    monkeypatch.setattr("testbench.studio.parts.widgets.LATER_S", 0.0)
    async with user_simulation(root=lambda: frame(studio)) as simulated:
        yield simulated
        await studio.jobs.close()
    blame_the_handlers(caplog.get_records("call"))


def blame_the_handlers(records: Iterable[logging.LogRecord]) -> None:
    """Fail where NiceGUI has logged what a handler raised: the page goes on as if nothing had been."""
    raised = [logging.Formatter().format(one) for one in records if one.exc_info]
    assert not raised, "\n".join(raised)


@pytest.fixture
def fitted(studio: Studio, fitted_model: Path) -> Studio:
    """The studio with a model for ``sleeve``."""
    studio.make_results("model:sleeve")
    shutil.copy(fitted_model, studio.workspace.results("sleeve") / "model.json")
    return studio
