"""What a page says where something that it needs is gone, and what is not taken away while it is needed."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace

import pytest
from nicegui.testing import User

from gcode.cli import main as gcode
from gcode.support.errors import UserError
from gcode.support.files import write_json
from testbench.cli import main as run_testbench
from testbench.studio import models
from testbench.studio.pages import campaign_card
from testbench.studio.parts.fields import written
from testbench.studio.parts.running_jobs import place_of
from testbench.studio.studio import Studio, campaign_of

pytestmark = pytest.mark.asyncio


async def test_a_model_is_not_judged_on_what_it_was_fitted_on_where_the_held_out_recording_is_gone(
    user: User, fitted: Studio
) -> None:
    path = models.model_path(fitted, "sleeve")
    two = fitted.workspace.root / "two" / "recording.csv"
    write_json(path, json.loads(path.read_text()) | {"held_out": str(two)})
    await user.open("/compare?c=sleeve")
    await user.should_see("the model of sleeve was judged on two, which is not among the campaigns any more")
    await user.should_see("Fit the baseline anew")
    await user.open("/ladder?c=sleeve")
    await user.should_see("the model of sleeve was judged on two")
    with pytest.raises(UserError, match="judged on two"):
        models.add_command(fitted, "sleeve", "stress_relaxation")


@pytest.mark.parametrize("page", ["/compare", "/ladder"])
async def test_a_model_whose_own_effect_is_gone_leads_to_the_effects_and_to_another_baseline(
    user: User, fitted: Studio, page: str
) -> None:
    path = models.model_path(fitted, "sleeve")
    told = json.loads(path.read_text())
    own = {"name": "mine", "effect": "mine", "parameters": {"gain": 1.0}}
    told["effects"].append(own)
    told["history"][-1]["model"]["effects"].append(own)
    write_json(path, told)
    await user.open(f"{page}?c=sleeve")
    await user.should_see("The model of sleeve needs what is not among the effects here: mine.", retries=50)
    await user.should_not_see("--effects")
    await user.should_see("Fit the baseline anew")
    fitted.effects.path.write_text("1 / 0\n")
    fitted.effects.agree()
    await user.open(f"{page}?c=sleeve")
    await user.should_see("effects.py: cannot be loaded: ZeroDivisionError", retries=50)
    await user.should_see("Fit the baseline anew")


async def test_a_file_that_is_gone_is_not_downloaded_in_silence(user: User, studio: Studio) -> None:
    await user.open("/recording?c=sleeve")
    await user.should_see("Download CSV", retries=50)
    user.find("Download CSV").click()
    assert await user.download.next()
    studio.deleted.add("sleeve")
    user.find("Download CSV").click()
    await user.should_see("recording.csv: this file is gone, so it cannot be downloaded")


async def test_a_plan_whose_trajectory_is_gone_says_so(user: User, studio: Studio) -> None:
    folder = studio.workspace.program("short")
    motion = ["--preset", "paper-1", "--seed", "1", "--gauge-length-mm", "25", "--duration-s", "20"]
    assert gcode(["generate", *motion, "-o", str(folder)]) == 0
    (folder / "trajectory.csv").unlink()
    await user.open("/plan?program=short")
    await user.should_see("trajectory.csv: cannot read", retries=50)


async def test_every_step_of_a_ladder_has_an_address(user: User, fitted: Studio) -> None:
    for step in ("0", "7", ""):
        await user.open(f"/ladder?c=sleeve&step={step}")
        await user.should_see("Through the history", retries=50)
    await user.open("/ladder?c=sleeve&step=x")
    await user.should_see("the address asks for step='x', which is no number")


async def test_a_link_to_a_recording_that_is_gone_is_a_sentence(user: User, fitted: Studio) -> None:
    await user.open("/compare?c=sleeve&on=gone")
    await user.should_see("no campaign 'gone'")


async def test_a_recording_without_a_gauge_length_is_refused_in_a_sentence(
    user: User, fitted: Studio, tmp_path: Path
) -> None:
    (tmp_path / "grip.csv").write_text("time_s,force_N,resistance_ohm\n0,0.1,900\n0.1,0.2,910\n0.2,0.3,930\n")
    assert run_testbench(["import", str(tmp_path / "grip.csv"), "-o", str(fitted.workspace.root / "grip")]) == 0
    await user.open("/compare?c=sleeve&on=grip")
    await user.should_see("that of sleeve has 25 mm, and grip has none. The tab Compare offers")


async def test_own_effects_that_are_not_text_are_not_used_and_those_of_the_workspace_are_found_again(
    studio: Studio, tmp_path: Path
) -> None:
    own, other, bad = studio.effects.here, tmp_path / "other.py", tmp_path / "bad.py"
    other.write_text("# none\n")
    bad.write_bytes(b"# \xe9\n")
    studio.effects.point_to(other)
    with pytest.raises(UserError, match="not a file of effects"):
        studio.effects.point_to(bad)
    assert studio.effects.path == other
    studio.effects.point_to(own)
    assert studio.effects.path == own


async def test_a_campaign_holds_no_other_and_an_empty_folder_is_no_campaign(studio: Studio) -> None:
    with pytest.raises(UserError, match="sleeve is a campaign, which holds no others"):
        studio.workspace.free_name("sleeve/inner")
    place = studio.deleted.add("sleeve")
    (studio.workspace.root / "sleeve").mkdir()
    assert studio.deleted.restore(place) == "sleeve"


async def test_a_campaign_that_a_job_is_about_is_not_deleted(studio: Studio, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(campaign_card, "is_under_way", lambda *_: False)
    job = SimpleNamespace(key="train:sleeve:force", title="Training for sleeve")
    card = campaign_card.Card.__new__(campaign_card.Card)
    card.studio = SimpleNamespace(jobs=SimpleNamespace(running=lambda: [job]))
    card.found = SimpleNamespace(campaign=studio.workspace.campaign("sleeve"))
    with pytest.raises(UserError, match="sleeve is in use: “Training for sleeve” is running"):
        card._delete()


async def test_a_campaign_may_have_a_colon_in_its_name() -> None:
    assert campaign_of("train:a:b:force") == "a:b"
    assert place_of(SimpleNamespace(key="train:a:b:force")) == "/compensate?c=a%3Ab&target=force"
    assert place_of(SimpleNamespace(key="export:sleeve:force")) == "/compensate?c=sleeve&target=force"
    assert place_of(SimpleNamespace(key="model:a:b")) == "/ladder?c=a%3Ab"


async def test_a_run_is_looked_at_below_the_plan_that_it_follows() -> None:
    argv = ("testbench", "run", "--sensor", "pes", "--program", "/ws/programs/short/program.tap", "-o", "/ws/new")
    assert place_of(SimpleNamespace(key="run:new", argv=argv)) == "/plan?program=short"


@pytest.mark.parametrize("value", [1234567890123, 25.5, 0.1, 1e-7, 1 / 3])
async def test_a_number_keeps_its_digits_in_an_address(value: float) -> None:
    assert float(written(value)) == value
