"""What a compensator and a model are judged on, and what the pages say of that."""

from __future__ import annotations

import shutil
from pathlib import Path
from types import SimpleNamespace

import pytest
from nicegui import ui
from nicegui.testing import User

from compensation.memories.ema import PAPER_RATE_HZ, smoothing_factors
from compensation.training import learners
from compensation.training.tuning import BANKS
from testbench.comparing import clamping
from testbench.knit.catalogue import baseline
from testbench.measurements.preparing import prepare
from testbench.studio.pages.campaign import compare, compensate
from testbench.studio.pages.campaign.compensate import REMEMBERS_S, TUNED_REMEMBERS_S, lasts_s
from testbench.studio.studio import Studio


def cut(studio: Studio, name: str, last_s: float) -> None:
    """A campaign beside ``sleeve``, whose recording ends earlier."""
    folder = studio.workspace.root / name
    shutil.copytree(studio.workspace.root / "sleeve", folder)
    header, *rows = (folder / "recording.csv").read_text().splitlines()
    kept = [row for row in rows if float(row.split(",")[0]) <= last_s]
    (folder / "recording.csv").write_text("\n".join([header, *kept]) + "\n")
    assert lasts_s(folder / "recording.csv") == pytest.approx(last_s, abs=0.1)


@pytest.mark.asyncio
async def test_recordings_that_end_before_the_method_forgets_are_left_out(
    user: User, studio: Studio, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One of 20 s among those that were chosen by themselves ended the scoring, after minutes of training."""
    for name, last_s in (("cuff", 60), ("long", 120), ("brief", 20)):
        cut(studio, name, last_s)
    same = ["brief", "cuff", "long"]  # of one specimen
    monkeypatch.setattr(compensate, "companions", lambda *_: (same, []))
    await user.open("/compensate?c=sleeve")
    (judged,) = user.find(kind=ui.select, content="Judged on").elements
    (method,) = user.find(kind=ui.select, content="Method").elements
    assert judged.options == judged.value == ["cuff", "long"]
    await user.should_see("1 campaign is shorter than the 31 s that this method may remember, and not offered.")
    method.set_value("tuned")
    assert judged.options == judged.value == ["long"]
    await user.should_see("2 campaigns are shorter than the 77 s that this method may remember, and not offered.")
    method.set_value("4,2,2")
    assert judged.options == ["cuff", "long"]
    assert judged.value == ["long"], "what was chosen stays"
    await user.should_not_see("Nothing is chosen to judge on")
    judged.set_value([])
    await user.should_see("Nothing is chosen to judge on: the score will be that of the training itself.")


@pytest.mark.asyncio
async def test_where_none_lasts_long_enough_the_score_is_that_of_the_training(user: User, studio: Studio) -> None:
    cut(studio, "brief", 20)
    shutil.copytree(studio.workspace.root / "sleeve", studio.workspace.root / "damaged")
    (studio.workspace.root / "damaged" / "recording.csv").write_bytes(b"\0" * 100)
    await user.open("/compensate?c=sleeve")
    await user.should_see("Of 1 campaign no two samples can be read.")
    await user.should_see("1 campaign is shorter than the 31 s that this method may remember, and not offered.")
    await user.should_see("has resistance and force for so long: the score will be that of the training itself.")


def test_the_page_knows_how_long_a_compensator_remembers() -> None:
    banks = [smoothing_factors(), smoothing_factors(learners.FACTOR, learners.COUNT)]
    slowest_s = [1 / (PAPER_RATE_HZ * bank.min()) for bank in banks]
    assert max(slowest_s) <= REMEMBERS_S < max(slowest_s) + 1
    tuned_s = [1 / (PAPER_RATE_HZ * smoothing_factors(*bank).min()) for bank in BANKS]
    assert max(tuned_s) <= TUNED_REMEMBERS_S < max(tuned_s) + 1


@pytest.mark.parametrize("text", ["", "time_s\n", "x,y\n1,2\n", "time_s,a\n1,2", "time_s,a\nq,2\n3,4\n"])
def test_a_file_without_samples_lasts_no_time(tmp_path: Path, text: str) -> None:
    (tmp_path / "recording.csv").write_text(text)
    assert lasts_s(tmp_path / "recording.csv") == lasts_s(tmp_path / "none.csv") == 0


def test_half_a_row_at_the_end_is_none(tmp_path: Path) -> None:
    (tmp_path / "recording.csv").write_text("a,time_s\n1,2.5\n" + "1,4\n" * 9000 + "1,7.5\n1,")
    assert lasts_s(tmp_path / "recording.csv") == 5


def test_the_page_says_where_the_play_of_the_clamps_is_given(studio: Studio, monkeypatch: pytest.MonkeyPatch) -> None:
    """What the library calls it says nothing to who looks at a page."""
    held = prepare(studio.workspace.recording("sleeve"))
    errors = iter(({"force": 1.0}, {"force": 0.1}, {"force": 0.2}))
    monkeypatch.setattr(clamping, "rms_errors", lambda *_, **__: next(errors))
    note = clamping.may_be_clamped_anew(baseline(), held)
    (told,) = compare._notes(studio, "sleeve", SimpleNamespace(measurement=held, notes=(note,)))
    assert told.startswith("Counted 0.5 mm less far")
    assert told.endswith("if the sensor was clamped anew, fit the baseline anew with “Play of the clamps / mm”.")
