"""The pages from a model to what it is missing, and to the experiment, without a browser."""

from __future__ import annotations

import asyncio
import json
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from nicegui import ui
from nicegui.testing import User

import tests.testbench.report.samples as samples
from gcode.support.errors import UserError
from testbench.results.result_files import read_diagnosis
from testbench.studio import models
from testbench.studio.pages.campaign import missing
from testbench.studio.pages.campaign.fit_form import REST
from testbench.studio.parts.picture import Picture
from testbench.studio.studio import Studio
from tests.testbench.studio.diagnoses import refit_elsewhere, running_job, steps_in, with_diagnosis

pytestmark = pytest.mark.asyncio


@pytest.mark.parametrize("path", ["/compare?c=sleeve", "/ladder?c=sleeve", "/missing?c=sleeve"])
async def test_a_fitted_campaign_opens_every_step(user: User, fitted: Studio, path: str) -> None:
    await user.open(path)
    words = {"/compare": "Where it fails", "/ladder": "Through the history", "/missing": "Find what is missing"}
    await user.should_see(words[path.partition("?")[0]], retries=50)


async def test_candidates_are_ranked_and_ties_are_said(user: User, fitted: Studio) -> None:
    with_diagnosis(fitted)
    await user.open("/missing?c=sleeve")
    await user.should_see("Missing: stress relaxation")
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
    await user.should_see("not refitted: it would hardly lower the error")


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


@pytest.mark.parametrize("path", ["/missing?c=sleeve", "/experiment?c=sleeve"])
async def test_a_diagnosis_of_another_model_is_called_old_whatever_the_times_of_files(
    user: User, fitted: Studio, path: str
) -> None:
    with_diagnosis(fitted)
    os.utime(fitted.workspace.results("sleeve") / "diagnosis.json", (1, 1))
    await user.open(path)
    await user.should_see("stress relaxation")
    await user.should_not_see("The model has changed since this diagnosis.")
    with_diagnosis(fitted)
    refit_elsewhere(fitted)
    await user.open(path)
    await user.should_see("The model has changed since this diagnosis.")


async def test_a_diagnosis_of_an_undone_model_is_fresh_though_that_was_fitted_once_more(fitted: Studio) -> None:
    with_diagnosis(fitted)
    path = models.model_path(fitted, "sleeve")
    data = json.loads(path.read_text())
    data["history"][0]["errors"]["held_out"] = {"force": 0.5, "conductance": 0.5}
    path.write_text(json.dumps(data))
    assert not models.is_fresh(fitted, "sleeve")
    path.write_text(json.dumps(data | {"fit": {}}))
    assert models.is_fresh(fitted, "sleeve")
    data["history"][0]["model"]["effects"].pop()
    path.write_text(json.dumps(data | {"fit": {}}))
    assert not models.is_fresh(fitted, "sleeve")


@pytest.mark.parametrize("kind", ["diagnose", "propose"])
async def test_the_model_stays_while_it_is_asked_about(user: User, fitted: Studio, kind: str) -> None:
    with_diagnosis(fitted)
    fitted.jobs.jobs.append(running_job(f"{kind}:sleeve"))
    for path, button in (
        ("/missing?c=sleeve", "Add stress relaxation"),
        ("/ladder?c=sleeve", "Undo the last step"),
        ("/compare?c=sleeve", "Fit the baseline anew"),
    ):
        await user.open(path)
        await user.should_see(kind=ui.button, content=button, retries=100)
        for one in user.find(kind=ui.button, content=button).elements:
            one.set_enabled(True)
        user.find(kind=ui.button, content=button).click()
        await user.should_see("Looking around: this is still under way, and the model of sleeve must stay as it is")
    assert len(fitted.jobs.jobs) == 1
    fitted.jobs.jobs.clear()


async def test_a_tab_that_does_not_know_of_the_model_keeps_it_before_it_is_fitted_anew(
    user: User, studio: Studio, fitted_model: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun: list[str] = []
    monkeypatch.setattr(models, "change_model", lambda studio, c, *more: begun.append(c))
    await user.open("/missing?c=sleeve")
    await user.should_see("Fit the baseline")
    studio.make_results("model:sleeve")
    shutil.copy(fitted_model, models.model_path(studio, "sleeve"))
    user.find(kind=ui.button, content="Fit the baseline").click()
    await asyncio.sleep(0)
    assert begun == ["sleeve"]
    kept = studio.workspace.results("sleeve") / models.BEFORE
    assert kept.read_bytes() == fitted_model.read_bytes()


async def test_motions_for_an_earlier_diagnosis_are_not_shown(user: User, fitted: Studio) -> None:
    with_diagnosis(fitted)
    (fitted.workspace.results("sleeve") / "experiment.json").write_text(json.dumps(samples.experiment()))
    asked = samples.diagnosis() | {"left_unexplained": 0.5}
    (fitted.workspace.results("sleeve") / "experiment-asked.json").write_text(json.dumps(asked))
    await user.open("/experiment?c=sleeve")
    await user.should_see("Which is it")
    await user.should_not_see("Run “long hold”")


async def test_a_held_out_recording_may_be_clamped_anew_and_of_the_same_specimen(
    user: User, studio: Studio, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[list[str]] = []
    monkeypatch.setattr(models, "change_model", lambda studio, c, commands, *more: asked.append(commands[0][1]))
    shutil.copytree(studio.workspace.root / "sleeve", studio.workspace.root / "other")
    await user.open("/missing?c=sleeve")
    await user.should_see("First, a baseline")
    await user.should_not_see(REST)
    (held,) = user.find(kind=ui.select, content="Held out").elements
    for choice, said in ((models.LAST_THIRD, 5.0), ("other", None), ("other", 120.0)):
        held.value = choice
        for field in (*user.find(kind=ui.number, content=REST).elements,) if choice == "other" else ():
            field.value = said
        user.find(kind=ui.button, content="Fit the baseline").click()
        await asyncio.sleep(0)
    third, fresh, same = asked
    assert "--rest-s" not in third
    assert "--rest-s" not in fresh
    assert same[same.index("--rest-s") + 1] == "120"
    assert "--clamp-play-mm" not in same


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


def with_diagnosed(studio: Studio, *names: str) -> dict[str, Any]:
    """A diagnosis of ``sleeve`` that put these effects in, and its model; what `read_diagnosis` makes of it."""
    with_diagnosis(studio)
    model = json.loads(models.model_path(studio, "sleeve").read_text())
    worse = {"errors": {kind: {"force": 9.0, "conductance": 9.0} for kind in ("calibration", "held_out")}}
    steps = [model["history"][-1], *(model["history"][-1] | worse | {"step": f"+ {name}"} for name in names)]
    models.diagnosed_path(studio, "sleeve").write_text(json.dumps(model | {"history": steps}))
    path = models.diagnosis_path(studio, "sleeve")
    path.write_text(json.dumps(json.loads(path.read_text()) | {"history": steps}))
    return dict(read_diagnosis(path))


async def test_what_the_diagnosis_put_in_goes_on_top_of_the_ladder_once(fitted: Studio) -> None:
    diagnosis = with_diagnosed(fitted, "slack")
    models.adopt_diagnosed(fitted, "sleeve", diagnosis)
    (line,) = fitted.commands_path("sleeve").read_text().splitlines()
    copied = f"  cp {models.diagnosed_path(fitted, 'sleeve')} {models.model_path(fitted, 'sleeve')}"
    assert line.endswith(copied), "the log leads to the model as it is"
    assert list(models.kept_diagnoses(fitted, "sleeve")) == [1], "it is told of the step that it led to"
    with pytest.raises(UserError, match="sleeve: the model or the diagnosis has changed since"):
        models.adopt_diagnosed(fitted, "sleeve", diagnosis)
    steps = [step["step"] for step in json.loads(models.model_path(fitted, "sleeve").read_text())["history"]]
    assert steps == ["baseline", "+ slack"]


async def test_steps_that_were_judged_on_other_samples_are_not_put_on_the_ladder(fitted: Studio) -> None:
    diagnosis = with_diagnosed(fitted, "slack")
    refit_elsewhere(fitted)
    with pytest.raises(UserError, match="has changed since; ask again what is missing"):
        models.adopt_diagnosed(fitted, "sleeve", diagnosis)
    assert steps_in(fitted, "sleeve") == 1


async def test_a_stale_tab_does_not_adopt_what_a_later_diagnosis_found(fitted: Studio) -> None:
    stale = with_diagnosed(fitted, "slack")
    with_diagnosed(fitted, "creep")
    with pytest.raises(UserError, match="has changed since; ask again what is missing"):
        models.adopt_diagnosed(fitted, "sleeve", stale)
    assert steps_in(fitted, "sleeve") == 1


def with_step(studio: Studio, name: str) -> None:
    """One more step on the ladder of ``sleeve``, as `testbench add` would put it there."""
    path = models.model_path(studio, "sleeve")
    data = json.loads(path.read_text())
    below = data["history"].pop()
    data["history"] += [below | {"fit": data["fit"]}, below | {"step": f"+ {name}"}]
    path.write_text(json.dumps(data))


async def test_the_diagnosis_of_each_step_is_kept(
    user: User, fitted: Studio, monkeypatch: pytest.MonkeyPatch
) -> None:
    with_diagnosis(fitted)
    monkeypatch.setattr(models, "change_model", lambda *some: None)
    diagnosis = read_diagnosis(models.diagnosis_path(fitted, "sleeve"))
    models.add_laws(fitted, "sleeve", ["stress_relaxation"], diagnosis, None, lambda: None)
    assert models.kept_diagnoses(fitted, "sleeve") == {}, "the step has not been taken yet"
    with_step(fitted, "stress_relaxation")
    with_diagnosis(fitted, "nothing_missing")
    kept = models.kept_diagnoses(fitted, "sleeve")
    assert list(kept) == [1]
    assert read_diagnosis(kept[1])["verdict"] == "missing"
    await user.open("/ladder?c=sleeve")
    await user.should_see("The diagnosis before step 1: it found stress relaxation", retries=50)


async def test_a_diagnosis_is_not_told_of_a_step_that_it_did_not_lead_to(fitted: Studio, fitted_model: Path) -> None:
    with_diagnosis(fitted)
    diagnosis = read_diagnosis(models.diagnosis_path(fitted, "sleeve"))
    before = list(diagnosis["history"])
    models.keep_diagnosis(fitted, "sleeve", diagnosis, before, "+ stress_relaxation")
    with_step(fitted, "slack")
    assert models.kept_diagnoses(fitted, "sleeve") == {}, "another step was taken after the first was undone"
    shutil.copy(fitted_model, models.model_path(fitted, "sleeve"))
    with_step(fitted, "stress_relaxation")
    assert list(models.kept_diagnoses(fitted, "sleeve")) == [1]
    refit_elsewhere(fitted)
    assert models.kept_diagnoses(fitted, "sleeve") == {}, "the baseline was fitted anew"


async def test_what_is_in_the_model_already_is_not_added_again(user: User, fitted: Studio) -> None:
    with_diagnosis(fitted)
    await user.open("/missing?c=sleeve")
    await user.should_see("Add stress relaxation", retries=100)
    path = models.model_path(fitted, "sleeve")
    data = json.loads(path.read_text())
    data["history"][-1]["model"]["effects"].append(
        {"name": "relaxed", "effect": "stress_relaxation", "parameters": {}}
    )
    path.write_text(json.dumps(data))
    user.find(kind=ui.button, content="Add stress relaxation").click()
    await user.should_see("stress relaxation: it is in the model of sleeve already; ask again")
    assert not models.step_diagnosis(fitted, "sleeve", 1).exists()
    await user.open("/missing?c=sleeve")
    await user.should_see("in the model already", retries=100)
    await user.should_not_see("Add stress relaxation")


async def test_commands_of_a_campaign_are_kept(studio: Studio) -> None:
    job = studio.jobs.start("model:sleeve", "Help", ["testbench", "--help"])
    assert job.task
    await job.task
    other = studio.jobs.start("effects", "Help", ["testbench", "--version"])
    assert other.task
    await other.task
    assert studio.commands_path("sleeve").read_text().endswith("  testbench --help\n")
    assert studio.commands_path("sleeve").read_text().count("\n") == 1


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


async def test_a_slow_answer_does_not_take_the_place_of_what_was_chosen_after_it(
    user: User, fitted: Studio, monkeypatch: pytest.MonkeyPatch
) -> None:
    with_diagnosis(fitted)
    gate, shown, show, look = asyncio.Event(), [], missing._Candidates._show, missing.aside
    pages: list[missing._Candidates] = []

    async def watched(candidates: missing._Candidates, entry: dict) -> None:
        pages.append(candidates)
        await show(candidates, entry)
        shown.append(entry["law"])

    async def slow(function: Callable, *arguments: Any) -> Any:
        if arguments and arguments[0]["law"] == "stress_relaxation":
            await gate.wait()
        return await look(function, *arguments)

    monkeypatch.setattr(missing._Candidates, "_show", watched)
    monkeypatch.setattr(missing, "aside", slow)
    await user.open("/missing?c=sleeve")
    await user.should_see("Working out what it would add")
    with user:
        await pages[0]._look(pages[0].diagnosis["ranking"][1])
    await user.should_see("Add load cell creep")
    gate.set()
    while len(shown) < 2:
        await asyncio.sleep(0)
    assert shown == ["load_cell_creep", "stress_relaxation"]
    await user.should_see("Add load cell creep")
    await user.should_not_see("Add stress relaxation")
