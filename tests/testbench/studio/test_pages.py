"""The pages without a browser: what they say, where they lead, how they fail."""

from __future__ import annotations

import asyncio
import json
import os
import shutil
from pathlib import Path

import pytest
from nicegui import ui
from nicegui.testing import User

import tests.testbench.report.samples as samples
from gcode.cli import main as gcode
from testbench.cli import main as run_testbench
from testbench.studio import models
from testbench.studio.parts.address import address
from testbench.studio.parts.picture import Picture, zoomed_span
from testbench.studio.studio import Studio
from tests.testbench.importing import exports

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


async def test_an_address_without_a_page_says_so_and_leads_back(user: User) -> None:
    answer = await user.http_client.get("/nowhere")
    assert answer.status_code == 404
    assert "Nothing is at /nowhere." in answer.text
    assert "grid_view" in answer.text.partition("Nothing is at /nowhere.")[2]  # the button's icon


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
    (studio.workspace.results("sleeve") / "force.score.json").write_text(json.dumps(samples.score()))
    await user.open("/compensate?c=sleeve")
    await user.should_see("Export for the chip")
    await user.should_see("pes-A (held-out)")


@pytest.fixture
def fitted(studio: Studio, fitted_model: Path) -> Studio:
    """The studio with a model for ``sleeve``."""
    shutil.copy(fitted_model, studio.workspace.results("sleeve") / "model.json")
    return studio


def with_diagnosis(studio: Studio, verdict: str = "missing") -> None:
    history = json.loads((studio.workspace.results("sleeve") / "model.json").read_text())["history"]
    data = samples.diagnosis(verdict) | {"history": history}
    (studio.workspace.results("sleeve") / "diagnosis.json").write_text(json.dumps(data))


@pytest.mark.parametrize("path", ["/compare?c=sleeve", "/ladder?c=sleeve", "/missing?c=sleeve"])
async def test_a_fitted_campaign_opens_every_step(user: User, fitted: Studio, path: str) -> None:
    await user.open(path)
    words = {"/compare": "Where it fails", "/ladder": "Through the history", "/missing": "Find what is missing"}
    await user.should_see(words[path.partition("?")[0]], retries=50)


async def test_candidates_are_ranked_and_ties_are_said(user: User, fitted: Studio) -> None:
    with_diagnosis(fitted)
    await user.open("/missing?c=sleeve")
    await user.should_see("The model is missing stress relaxation")
    await user.should_see("1. stress relaxation")
    await user.should_see("2. load cell creep")
    await user.should_see("tied")


async def test_with_nothing_missing_there_is_nothing_to_add_but_a_better_law(user: User, fitted: Studio) -> None:
    with_diagnosis(fitted, "nothing_missing")
    await user.open("/missing?c=sleeve")
    await user.should_see("Nothing is missing that these recordings could show (92 %).")
    await user.should_see("lie on the dashed line", retries=100)
    await user.should_not_see("Add stress relaxation")
    await user.should_not_see("Design the experiment")
    await user.should_not_see("Use elasticity ogden")
    path = fitted.workspace.results("sleeve") / "diagnosis.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | {"other_laws": ["elasticity_ogden"]}))
    await user.open("/missing?c=sleeve")
    await user.should_see("The law elasticity ogden suits this sensor better.")
    await user.should_see("Use elasticity ogden")


async def test_a_candidate_is_told_with_formula_source_and_values(user: User, fitted: Studio) -> None:
    with_diagnosis(fitted)
    await user.open("/missing?c=sleeve")
    await user.should_see("Add stress relaxation", retries=100)
    await user.should_see("F(t) = F_e(t) - fraction")
    await user.should_see("Source: Fung, Biomechanics")
    await user.should_see("leaves 38 % of the held-out error")
    await user.should_see("not worth a refit")


async def test_several_that_were_found_are_added_together(user: User, fitted: Studio) -> None:
    model = json.loads(models.model_path(fitted, "sleeve").read_text())
    steps = [model["history"][0], *(model["history"][0] | {"step": f"+ {name}"} for name in ("one", "two"))]
    models.diagnosed_path(fitted, "sleeve").write_text(json.dumps(model | {"history": steps}))
    found = samples.diagnosis()
    found["found"] = [found["found"][0], found["found"][0] | {"effect": "slack", "law": "slack"}]
    (fitted.workspace.results("sleeve") / "diagnosis.json").write_text(json.dumps(found | {"history": steps}))
    await user.open("/missing?c=sleeve")
    await user.should_see("Add all that was found: stress relaxation, slack")
    user.find("Add all that was found").click()
    await user.should_see("Through the history", retries=50)
    taken = json.loads(models.model_path(fitted, "sleeve").read_text())["history"]
    assert [step["step"] for step in taken] == ["baseline", "+ one", "+ two"]


async def test_looking_at_a_candidate_shows_its_prediction(user: User, fitted: Studio) -> None:
    with_diagnosis(fitted)
    await user.open("/missing?c=sleeve&pick=load_cell_creep")
    await user.should_see("Add load cell creep", retries=100)
    await user.should_see("lie on the dashed line")


async def test_an_old_diagnosis_is_called_old(user: User, fitted: Studio) -> None:
    with_diagnosis(fitted)
    os.utime(fitted.workspace.results("sleeve") / "diagnosis.json", (1, 1))
    await user.open("/missing?c=sleeve")
    await user.should_see("The model has changed since this diagnosis.")


async def test_the_next_step_is_judged_on_what_the_first_was(fitted: Studio) -> None:
    assert models.held_out_of(fitted, "sleeve") == models.LAST_THIRD
    title, argv = models.add_command(fitted, "sleeve", "stress_relaxation")
    assert title == "Adding stress relaxation and refitting"
    assert argv[:3] == ["testbench", "add", "stress_relaxation"]
    assert "--held-out" not in argv
    data = json.loads(models.model_path(fitted, "sleeve").read_text())
    shutil.copytree(fitted.workspace.root / "sleeve", fitted.workspace.root / "other")
    data["held_out"] = str(fitted.workspace.root / "other" / "recording.csv")
    models.model_path(fitted, "sleeve").write_text(json.dumps(data))
    assert models.held_out_of(fitted, "sleeve") == "other"
    _, argv = models.add_command(fitted, "sleeve", "stress_relaxation")
    assert argv[argv.index("--held-out") + 1] == str(fitted.workspace.root / "other")


async def test_what_the_diagnosis_put_in_goes_on_top_of_the_ladder(fitted: Studio) -> None:
    data = json.loads(models.model_path(fitted, "sleeve").read_text())
    found = data | {"history": [data["history"][0], data["history"][0] | {"step": "+ slack"}]}
    models.diagnosed_path(fitted, "sleeve").write_text(json.dumps(found))
    models.adopt_diagnosed(fitted, "sleeve")
    models.adopt_diagnosed(fitted, "sleeve")
    steps = [step["step"] for step in json.loads(models.model_path(fitted, "sleeve").read_text())["history"]]
    assert steps == ["baseline", "+ slack", "+ slack"]


async def test_the_diagnosis_of_each_step_is_kept(user: User, fitted: Studio) -> None:
    with_diagnosis(fitted)
    models.keep_diagnosis(fitted, "sleeve")
    assert models.kept_diagnoses(fitted, "sleeve") == {}, "the step has not been taken yet"
    path = models.model_path(fitted, "sleeve")
    data = json.loads(path.read_text())
    data["history"].append(data["history"][0] | {"step": "+ stress_relaxation"})
    path.write_text(json.dumps(data))
    with_diagnosis(fitted, "nothing_missing")
    kept = models.kept_diagnoses(fitted, "sleeve")
    assert list(kept) == [1]
    assert json.loads(kept[1].read_text())["verdict"] == "missing"
    await user.open("/ladder?c=sleeve")
    await user.should_see("The diagnosis that led to step 1, stress relaxation", retries=50)


async def test_commands_of_a_campaign_are_kept(studio: Studio) -> None:
    job = studio.jobs.start("model:sleeve", "Help", ["testbench", "--help"])
    assert job.task
    await job.task
    other = studio.jobs.start("effects", "Help", ["testbench", "--version"])
    assert other.task
    await other.task
    assert studio.commands_path("sleeve").read_text().endswith("  testbench --help\n")
    assert studio.commands_path("sleeve").read_text().count("\n") == 1


async def test_a_new_effect_starts_from_the_template_and_is_checked(user: User, studio: Studio) -> None:
    await user.open("/effects")
    user.find("Name of a new effect").type("My Effect")
    user.find("Start from the template").click()
    await user.should_see("lower case with underscores")
    user.find("Name of a new effect").clear().type("my_effect")
    user.find("Start from the template").click()
    await user.should_see("done after", retries=150)
    assert studio.effects_file is not None
    assert studio.effects_arguments() == ["--effects", str(studio.effects_file)]
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
    assert studio.effects_arguments() == ["--effects", str(tmp_path / "mine.py")]
    assert Studio(studio.workspace.root).effects_file == tmp_path / "mine.py"


async def test_somebody_elses_effects_are_not_run_unasked(user: User, studio: Studio, tmp_path: Path) -> None:
    ran = tmp_path / "ran"
    mine = "from testbench.effects import StressRelaxation\nclass Mine(StressRelaxation):\n    name = 'mine'\n"
    (studio.workspace.root / "effects.py").write_text(f"open({str(ran)!r}, 'w').close()\n{mine}")
    assert studio.effects_arguments() == []
    studio.catalogue()
    await user.open("/recording?c=sleeve")
    await user.should_see("have not been run")
    await user.should_see("How often each value occurred")
    assert not ran.exists()
    user.find("Run it").click()
    await asyncio.sleep(0.1)
    assert studio.effects_arguments() == ["--effects", str(studio.workspace.root / "effects.py")]
    studio.catalogue()
    assert ran.exists()
    (studio.workspace.root / "effects.py").write_text("other = 1\n")
    assert studio.effects_arguments() == [], "it was another text that was agreed to"
    assert Studio(studio.workspace.root).runnable_effects is None


async def test_tied_effects_lead_to_the_experiment(user: User, fitted: Studio) -> None:
    with_diagnosis(fitted)
    await user.open("/missing?c=sleeve")
    await user.should_see("Design the experiment that tells them apart")
    await user.open("/experiment?c=sleeve")
    await user.should_see("Which is it: stress relaxation or load cell creep?")


async def test_an_experiment_without_diagnosis_says_what_to_do(user: User) -> None:
    await user.open("/experiment?c=sleeve")
    await user.should_see("ask what is missing first")


async def test_an_experiment_shows_its_program_and_how_decisive_it_is(user: User, fitted: Studio) -> None:
    with_diagnosis(fitted)
    program = fitted.workspace.root / "programs" / "sleeve-experiment"
    program.mkdir(parents=True)
    (program / "trajectory.csv").write_text("time_s,position_mm\n0.0,0.0\n0.05,0.1\n0.1,0.2\n")
    (fitted.workspace.results("sleeve") / "experiment.json").write_text(json.dumps(samples.experiment()))
    await user.open("/experiment?c=sleeve")
    await user.should_see("Run “long hold” for 10 min", retries=50)
    await user.should_see("Download the Mach4 program", retries=50)
    await user.should_see(Picture, retries=50)
    assert len(user.find(Picture).elements) == 1


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


async def test_recording_needs_a_program_first(user: User) -> None:
    await user.open("/record")
    await user.should_see("No program yet")


async def test_a_wrong_field_is_marked_in_its_own_words(user: User, studio: Studio) -> None:
    await user.open("/plan")
    user.find("Duration / min").clear()
    user.find("Speed / mm/s").type("-3")
    user.find(kind=ui.button, content="Plan").click()
    await user.should_see("Give the duration.")
    assert not studio.jobs.jobs
    fields = {field.props["label"]: field for field in user.find(kind=ui.number).elements}
    assert fields["Duration / min"].error == "Give the duration."
    assert fields["Speed / mm/s"].error == "The speed must be more than 0."
    assert fields["Seed"].error is None
    assert fields["Speed / mm/s"].props["hint"] == "empty: 4.35 mm/s"


async def test_a_plan_that_was_not_made_is_a_sentence(user: User) -> None:
    await user.open("/plan?program=../../etc")
    await user.should_see("no plan called")


async def test_addresses_carry_any_name() -> None:
    assert address("/recording", c="a b/ü&c", on=None) == "/recording?c=a+b%2F%C3%BC%26c"


async def test_zooms_along_time_are_understood_and_others_left() -> None:
    assert zoomed_span({"xaxis.range[0]": 3.5, "xaxis.range[1]": 9}) == (3.5, 9.0)
    assert zoomed_span({"xaxis.range": [1, 2]}) == (1.0, 2.0)
    assert zoomed_span({"xaxis.autorange": True, "yaxis.autorange": True}) == (None, None)
    assert zoomed_span({"yaxis.range[0]": 1, "yaxis.range[1]": 2}) is None


async def test_the_choices_of_a_plan_are_in_its_address(user: User) -> None:
    await user.open("/plan?motion=fast&seed=7&gauge=40&minutes=2.5&speed=3")
    fields = numbers(user)
    assert fields == {
        "Seed": 7,
        "Gauge length / mm": 40,
        "Duration / min": 2.5,
        "Speed / mm/s": 3,
        "Acceleration / mm/s²": None,
        "Travel from / mm": None,
        "Travel to / mm": None,
    }
    user.find("Duration / min").clear().type("4")
    await user.should_see("Plan and run")
    for wrong, said in (("seed=soon", "seed='soon', which is no number"), ("motion=dance", "the motion 'dance'")):
        await user.open(f"/plan?{wrong}")
        await user.should_see(said)


async def test_the_limits_of_an_experiment_are_in_its_address(user: User, fitted: Studio) -> None:
    with_diagnosis(fitted)
    await user.open("/experiment?c=sleeve&strain=12&minutes=3")
    fields = numbers(user)
    assert fields["Largest strain / %"] == 12
    assert fields["Duration / min"] == 3
    assert fields["Speed up to / mm/s"] == 10


async def test_a_file_that_an_address_names_is_read_as_it_was_chosen(user: User, tmp_path: Path) -> None:
    path = tmp_path / "plain.csv"
    path.write_text("".join(f"{n / 10},{n % 7},{n % 5}\n" for n in range(60)))
    told = json.dumps({"columns": {"time": "1", "force": "3"}, "units": {"force": "kN"}, "gauge_length_mm": 40})
    await user.open(address("/import", file=str(path), name="again", chosen=told))
    await user.should_see("Found: no row of names", retries=100)
    chosen = {box.props.get("aria-label") or box.props.get("label"): box.value for box in _selects(user)}
    assert chosen["Column of force"] == "3"
    assert chosen["Unit of force"] == "kN"
    assert numbers(user)["Gauge length / mm"] == 40
    await user.open(address("/import", file=str(path), chosen='{"negate":["overwrite"]}'))
    await user.should_see("which the import does not know", retries=50)


async def test_thousands_show_what_becomes_of_them(user: User, tmp_path: Path) -> None:
    path = tmp_path / "grouped.csv"
    path.write_text("Zeit [s];Weg [mm];R [Ohm]\n" + "".join(f"{n},5;{n % 7},5;47.{n:03d}\n" for n in range(60)))
    await user.open(address("/import", file=str(path)))
    await user.should_see("no number at the top of the file", retries=100)
    await user.open(address("/import", file=str(path), chosen='{"hints":{"thousands":"."}}'))
    await user.should_see("47 000 Ω", retries=100)


async def test_clocks_that_cannot_be_told_apart_lead_to_where_they_are_chosen(user: User, tmp_path: Path) -> None:
    path = tmp_path / "clocks.csv"
    path.write_text("t_R [s],R [kOhm],t_a [s],Force [N]\n" + "".join(f"{n},40,{n},1.5\n" for n in range(60)))
    await user.open(address("/import", file=str(path)))
    await user.should_see("a clock of its own, see “Other quantities, and several clocks”", retries=100)


def numbers(user: User) -> dict[str, float | None]:
    """What stands in every field for a number, by its label."""
    return {field.props["label"]: field.value for field in user.find(kind=ui.number).elements}


def _selects(user: User) -> set[ui.select]:
    return user.find(kind=ui.select).elements


async def test_a_file_is_named_as_in_a_shell(user: User, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    exports.testxpert(tmp_path)
    await user.open("/import")
    user.find("Read the file").click()
    await user.should_see("“File on this machine” is empty")
    user.find("File on this machine").type("~nobody-here/testxpert.txt")
    user.find("Read the file").click()
    await user.should_see("~nobody-here/testxpert.txt: no such file")
    user.find("File on this machine").clear().type(" ~/testxpert.txt ")
    user.find("Read the file").click()
    await user.should_see("Found: names in row 1", retries=50)
