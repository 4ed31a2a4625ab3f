"""The pages without a browser: what they say, where they lead, how they fail."""

from __future__ import annotations

import asyncio
import json
import shutil
from pathlib import Path

import pytest
from nicegui import ui
from nicegui.testing import User

import tests.testbench.report.samples as samples
from gcode.cli import main as gcode
from gcode.support.errors import UserError
from testbench.cli import main as run_testbench
from testbench.studio.pages import plan
from testbench.studio.parts import widgets
from testbench.studio.parts.address import address
from testbench.studio.parts.picture import Picture, zoomed_span
from testbench.studio.studio import Studio

pytestmark = pytest.mark.asyncio


async def test_campaigns_are_listed_with_their_verdict(user: User) -> None:
    await user.open("/")
    await user.should_see("sleeve")
    await user.should_see("verified")
    await user.should_see("imported")


async def test_an_empty_folder_invites(user: User, studio: Studio) -> None:
    shutil.rmtree(studio.workspace.root / "sleeve")
    await user.open("/")
    await user.should_see("Nothing here yet")


async def test_a_recording_shows_its_plots(user: User) -> None:
    await user.open("/recording?c=sleeve")
    await user.should_see("Duration")
    await user.should_see("How often each value occurred")
    assert len(user.find(Picture).elements) == 3


async def test_a_wrong_checksum_is_said_on_the_page(user: User, studio: Studio) -> None:
    path = studio.workspace.root / "sleeve" / "recording.csv"
    path.write_text(path.read_text() + "\n")
    await user.open("/recording?c=sleeve")
    await user.should_see("does not agree with its manifest")


@pytest.mark.parametrize("path", ["/recording?c=absent", "/compare?c=../..", "/recording"])
async def test_a_wrong_address_is_a_sentence(user: User, path: str) -> None:
    await user.open(path)
    await user.should_see("no campaign")


@pytest.mark.parametrize("page", ["compare", "missing", "ladder", "propose"])
async def test_a_fitted_campaign_that_is_gone_is_said_once(user: User, fitted: Studio, page: str) -> None:
    shutil.rmtree(fitted.workspace.root / "sleeve")
    await user.open(f"/{page}?c=sleeve")
    await user.should_see("no campaign 'sleeve'")
    assert len(user.find("no campaign 'sleeve'").elements) == 1
    await user.should_not_see("fit the baseline anew")


async def test_an_address_without_a_page_says_so_and_leads_back(user: User) -> None:
    answer = await user.http_client.get("/nowhere")
    assert answer.status_code == 404
    assert "Nothing is at /nowhere." in answer.text
    assert "grid_view" in answer.text.partition("Nothing is at /nowhere.")[2]  # the button's icon


async def test_a_list_narrowed_by_a_state_that_does_not_exist_says_so(user: User) -> None:
    await user.open("/?state=bogus")
    await user.should_see("the state must be one of fitted, diagnosed")
    await user.open("/?order=bogus")
    await user.should_see("the order must be one of newest, oldest")
    await user.open("/?tag=gone")
    await user.should_see("sleeve")


async def test_a_campaign_without_model_offers_the_fit(user: User) -> None:
    await user.open("/compare?c=sleeve")
    await user.should_see("Fit the baseline")
    await user.should_see("the last third of this recording")


async def test_training_is_offered_for_each_target(user: User) -> None:
    await user.open("/compensate?c=sleeve&target=displacement")
    await user.should_see("Train")
    await user.open("/compensate?c=sleeve&target=colour")
    await user.should_see("the target must be one of force, displacement")


async def test_a_score_is_shown_with_its_figures(user: User, studio: Studio) -> None:
    studio.make_results("train:sleeve:force")
    (studio.workspace.results("sleeve") / "force.score.json").write_text(json.dumps(samples.score()))
    await user.open("/compensate?c=sleeve")
    await user.should_see("Export for the chip")
    await user.should_see("pes-A (held-out)")


async def test_a_new_training_takes_the_old_score_away(
    user: User, studio: Studio, monkeypatch: pytest.MonkeyPatch
) -> None:
    studio.make_results("train:sleeve:force")
    score = studio.workspace.results("sleeve") / "force.score.json"
    score.write_text(json.dumps(samples.score()))
    monkeypatch.setattr("testbench.studio.pages.campaign.compensate.run_in_turn", lambda *_: None)
    await user.open("/compensate?c=sleeve")
    user.find(kind=ui.button, content="Train").click()
    await asyncio.sleep(0.1)
    assert not score.exists()
    (score.parent / "force.compensator.json").write_text("{}")
    await user.open("/compensate?c=sleeve")
    await user.should_see("has no score; every training ends with one")
    await user.should_see("Compensator as JSON")


async def test_a_compensator_is_judged_on_campaigns_that_have_what_it_needs(
    user: User, studio: Studio, tmp_path: Path
) -> None:
    shutil.copytree(studio.workspace.root / "sleeve", studio.workspace.root / "cuff")
    (tmp_path / "pull.csv").write_text("time_s,displacement_mm,force_N\n0,0,0.1\n0.01,1,0.2\n")
    argv = [
        "import",
        str(tmp_path / "pull.csv"),
        "--gauge-length-mm",
        "25",
        "-o",
        str(studio.workspace.root / "pull"),
    ]
    assert run_testbench(argv) == 0
    await user.open("/compensate?c=sleeve")
    (judged,) = user.find(kind=ui.select, content="Judged on").elements
    assert judged.options == ["cuff"]


async def test_a_new_effect_starts_from_the_template_and_is_checked(user: User, studio: Studio) -> None:
    await user.open("/effects")
    user.find("Name of a new effect").type("My Effect")
    user.find("Start from the template").click()
    await user.should_see("lower case with underscores")
    user.find("Name of a new effect").clear().type("my_effect")
    user.find("Start from the template").click()
    await user.should_see("done after", retries=150)
    assert studio.effects.file is not None
    assert studio.effects.arguments() == ["--effects", str(studio.effects.file)]
    user.find("Save and check").click()
    await user.should_see("my_effect: keeps all rules", retries=150)


async def test_own_effects_may_lie_in_a_file_elsewhere(user: User, studio: Studio, tmp_path: Path) -> None:
    await user.open("/effects")
    user.find("File in use").clear().type(str(tmp_path / "absent.py"))
    user.find("Use this file").click()
    await user.should_see("no such Python file")
    (tmp_path / "mine.py").write_text("1 / 0\n")
    user.find("File in use").clear().type(str(tmp_path / "mine.py"))
    user.find("Use this file").click()
    await asyncio.sleep(0)
    assert studio.effects.arguments() == ["--effects", str(tmp_path / "mine.py")]
    assert Studio(studio.workspace.root).effects.file == tmp_path / "mine.py"


async def test_a_file_of_own_effects_is_named_as_in_a_shell_and_said_to_be_gone(
    user: User, studio: Studio, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    (tmp_path / "lab").mkdir()
    (tmp_path / "lab" / "mine.py").write_text("one = 1\n")
    await user.open("/effects")
    user.find("File in use").clear()
    user.find("Use this file").click()
    await user.should_see("“File in use” is empty: name a .py file on this machine")
    monkeypatch.chdir(tmp_path)
    user.find("File in use").type("lab/mine.py")
    user.find("Use this file").click()
    await user.should_see("lab/mine.py: no such Python file; give the full path")
    user.find("File in use").clear().type(" ~/lab/mine.py ")
    user.find("Use this file").click()
    await asyncio.sleep(0.1)
    assert studio.effects.file == tmp_path / "lab" / "mine.py"
    shutil.rmtree(tmp_path / "lab")
    await user.open("/effects")
    await user.should_see("mine.py was pointed to, and is gone.")
    await user.should_see(f"that of this workspace is {studio.effects.here}")
    user.find(kind=ui.codemirror).type("two = 2\n")
    user.find("Save and check").click()
    await user.should_see("lab: no such folder. Bring it back, or use another file")


async def test_somebody_elses_effects_are_not_run_unasked(user: User, studio: Studio, tmp_path: Path) -> None:
    ran = tmp_path / "ran"
    mine = "from testbench.effects import StressRelaxation\nclass Mine(StressRelaxation):\n    name = 'mine'\n"
    (studio.workspace.root / "effects.py").write_text(f"open({str(ran)!r}, 'w').close()\n{mine}")
    assert studio.effects.arguments() == []
    studio.effects.catalogue()
    await user.open("/recording?c=sleeve")
    await user.should_see("have not been run")
    await user.should_see("How often each value occurred", retries=50)
    assert not ran.exists()
    user.find("Run it").click()
    await asyncio.sleep(0.1)
    assert studio.effects.arguments() == ["--effects", str(studio.workspace.root / "effects.py")]
    studio.effects.catalogue()
    assert ran.exists()
    (studio.workspace.root / "effects.py").write_text("other = 1\n")
    assert studio.effects.arguments() == [], "it was another text that was agreed to"
    assert Studio(studio.workspace.root).effects.runnable is None


async def test_clocks_of_plan_and_recording_are_compared(user: User, studio: Studio) -> None:
    program = studio.workspace.root / "programs" / "short"
    motion = ["--preset", "paper-1", "--seed", "1", "--gauge-length-mm", "25", "--duration-s", "60"]
    assert gcode(["generate", *motion, "-o", str(program)]) == 0
    argv = ["--sensor", "pes", "--program", str(program / "program.tap"), "-o", str(studio.workspace.root / "knit")]
    assert run_testbench(["run", *argv]) == 0
    await user.open("/align?c=knit")
    await user.should_see("The plan began together with the recording; their clocks run alike.", retries=50)
    await user.should_see("knit-aligned")


async def test_a_campaign_without_program_has_no_plan_to_compare_with(user: User) -> None:
    await user.open("/align?c=sleeve")
    await user.should_see("sleeve has no program in its folder")


async def test_a_broken_effect_is_said_not_thrown(user: User, studio: Studio) -> None:
    (studio.workspace.root / "effects.py").write_text("1 / 0\n")
    await user.open("/effects")
    user.find("Save and check").click()
    await user.should_see("ZeroDivisionError", retries=150)


async def test_a_travel_that_begins_at_nothing_has_no_sign() -> None:
    speeds = {"v_mean_mm_per_s": 1.0, "v_max_mm_per_s": 2.0, "a_max_mm_per_s2": 3.0}
    told = dict(plan._figures({"duration_s": 30.0, "x_min_mm": -1e-9, "x_max_mm": 6.36, **speeds}))
    assert told["Travel"] == "0.00 to 6.36 mm"
    assert told["Duration"] == "30 s"


async def test_how_far_above_the_noise_is_told_of_what_was_fitted(user: User, fitted: Studio) -> None:
    for path in ("/ladder", "/compare"):
        await user.open(f"{path}?c=sleeve&show=resistance")
        await user.should_see(kind=ui.html, content="the noise floor of the conductance", retries=50)


async def test_addresses_carry_any_name() -> None:
    assert address("/recording", c="a b/ü&c", on=None) == "/recording?c=a+b%2F%C3%BC%26c"


async def test_zooms_along_time_are_understood_and_others_left() -> None:
    assert zoomed_span({"xaxis.range[0]": 3.5, "xaxis.range[1]": 9}) == (3.5, 9.0)
    assert zoomed_span({"xaxis.range": [1, 2]}) == (1.0, 2.0)
    assert zoomed_span({"xaxis.autorange": True, "yaxis.autorange": True}) == (None, None)
    assert zoomed_span({"yaxis.range[0]": 1, "yaxis.range[1]": 2}) is None


async def test_what_was_chosen_to_be_compared_stays_chosen_in_a_narrower_list(user: User, studio: Studio) -> None:
    await user.open("/")
    await user.should_see(kind=ui.checkbox)
    user.find(kind=ui.checkbox).click()
    user.find("Search").type("sleeve")
    await user.should_see("1 campaign")
    await user.should_see(kind=ui.checkbox)
    (choice,) = user.find(kind=ui.checkbox).elements
    assert choice.value is True


async def test_a_compensator_is_compared_where_no_model_was_fitted(user: User, studio: Studio) -> None:
    studio.make_results("train:sleeve:force")
    (studio.workspace.results("sleeve") / "force.score.json").write_text(json.dumps(samples.score()))
    await user.open("/side?a=sleeve&b=sleeve")
    await user.should_see("sleeve: the whole recording.", retries=50)
    assert any("r² of the force, compensated" in html.content for html in user.find(kind=ui.html).elements)


async def test_what_nobody_expected_is_said_in_its_place_too(
    user: User, studio: Studio, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def broken(*some: object, **more: object) -> None:
        raise ZeroDivisionError("division by zero")

    monkeypatch.setattr("testbench.studio.pages.campaign.recording.figures.distributions", broken)
    await user.open("/recording?c=sleeve")
    await user.should_see("This page could not be built: ZeroDivisionError: division by zero.", retries=50)
    await user.should_see("Where it comes from", retries=50)
    monkeypatch.setattr("testbench.studio.pages.campaign.recording.figures.summary", broken)
    await user.open("/recording?c=sleeve")
    await user.should_see("This page could not be built: ZeroDivisionError")
    with user:
        await widgets.attempt(broken)
    await user.should_see("This could not be done: ZeroDivisionError")
    assert "division by zero" in caplog.text, "where it happened is in the log"
    caplog.clear()


async def test_what_a_later_part_refuses_is_said_in_its_place(
    user: User, studio: Studio, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*some: object, **more: object) -> None:
        raise UserError("the summary is gone; fetch it")

    monkeypatch.setattr("testbench.studio.pages.campaign.recording.figures.hysteresis_loops", refuse)
    await user.open("/recording?c=sleeve")
    await user.should_see("the summary is gone; fetch it", retries=50)


@pytest.mark.parametrize(
    ("path", "said"),
    [
        ("/recording?c=sleeve&start=1&end=inf", "both must be seconds"),
        ("/recording?c=sleeve&start=nan&end=3", "both must be seconds"),
        ("/recording?c=sleeve&show=colour", "Duration"),
        ("/recording?c=a%00b", "no campaign"),
        ("/ladder?c=a%00b", "no campaign"),
    ],
)
async def test_addresses_that_ask_for_the_impossible_have_a_page(user: User, path: str, said: str) -> None:
    await user.open(path)
    await user.should_see(said)
    await user.should_not_see("could not be built")


async def test_a_file_of_two_rows_has_all_but_its_distributions(user: User, studio: Studio, tmp_path: Path) -> None:
    (tmp_path / "two.csv").write_text("time_s,displacement_mm,force_N\n0,0,0.1\n0.01,1,0.2\n")
    argv = ["import", str(tmp_path / "two.csv"), "--gauge-length-mm", "25", "-o", str(studio.workspace.root / "two")]
    assert run_testbench(argv) == 0
    await user.open("/recording?c=two")
    await user.should_see("Download CSV", retries=50)
    await user.should_not_see("at least 2 samples")


async def test_what_was_changed_on_disk_meanwhile_is_not_overwritten(user: User, studio: Studio) -> None:
    path = studio.effects.path
    path.write_text("first = 1\n")
    studio.effects.agree()
    await user.open("/effects")
    await user.should_see("Save and check")
    path.write_text("changed_elsewhere = 1\n")
    user.find("Save and check").click()
    await user.should_see("effects.py was changed on disk since it was read here")
    assert path.read_text() == "changed_elsewhere = 1\n"
    user.find("Read the file again").click()
    user.find("Save and check").click()
    await asyncio.sleep(0)
    assert studio.jobs.find("effects") is not None


async def test_no_resistance_is_offered_where_none_was_recorded(user: User, fitted: Studio, tmp_path: Path) -> None:
    (tmp_path / "pull.csv").write_text("time_s,displacement_mm,force_N\n0,0,0.1\n0.01,1,0.2\n")
    target = str(fitted.workspace.root / "pull")
    assert run_testbench(["import", str(tmp_path / "pull.csv"), "--gauge-length-mm", "25", "-o", target]) == 0
    await user.open("/compare?c=sleeve")
    await user.should_see(kind=ui.toggle)
    await user.open("/compare?c=sleeve&on=pull")
    await user.should_see("Compared with the recording of")
    await user.should_not_see(kind=ui.toggle)
