"""A proposed law is shown from its files, and put to use by a click: code that was seen, and no other."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from gcode.support.errors import UserError
from testbench.knit.template import write_template
from testbench.studio import models, proposed_law
from testbench.studio.studio import Studio
from tests.testbench.studio.diagnoses import refit_elsewhere, running_job, steps_in
from tests.testbench.studio.proposals import FOUND, write_proposal


@pytest.fixture
def proposed(studio: Studio, fitted_model: Path) -> Studio:
    """A studio with a model for ``sleeve`` and a law proposed for it."""
    studio.make_results("model:sleeve")
    shutil.copy(fitted_model, models.model_path(studio, "sleeve"))
    write_proposal(proposed_law.folder_of(studio, "sleeve"), models.model_path(studio, "sleeve"))
    return studio


def kept(studio: Studio) -> proposed_law.Kept:
    found = proposed_law.kept_proposal(studio, "sleeve")
    assert found is not None
    return found


def test_a_law_that_is_added_joins_the_own_effects_and_the_ladder(proposed: Studio) -> None:
    assert proposed.effects.runnable is None
    proposed_law.take(proposed, "sleeve", kept(proposed))
    assert "sleeve_law" in proposed.effects.catalogue().effects
    assert steps_in(proposed, "sleeve") == 2
    done = [line.partition("  ")[2].split()[0] for line in proposed.commands_path("sleeve").read_text().splitlines()]
    assert done == ["cat", "cp"], "the log leads to the model as it is"
    assert not kept(proposed).fresh, "what is in already is not offered again"
    assert proposed_law.free_law_name(proposed, "sleeve") == "sleeve_law_2"


def test_effects_that_are_there_already_stay_and_nothing_is_added_twice(proposed: Studio) -> None:
    write_template("mine", proposed.effects.path)
    proposed.effects.agree()
    proposed_law.take(proposed, "sleeve", kept(proposed))
    assert {"mine", "sleeve_law"} <= set(proposed.effects.catalogue().effects)
    text = proposed.effects.path.read_text()
    assert proposed_law.with_law(text, kept(proposed)) == text


def test_a_strangers_effects_are_not_run_along_with_it(proposed: Studio) -> None:
    write_template("stranger", proposed.effects.path)
    before = proposed.effects.path.read_text()
    with pytest.raises(UserError, match="you have not agreed to run"):
        proposed_law.take(proposed, "sleeve", kept(proposed))
    assert proposed.effects.runnable is None
    assert proposed.effects.path.read_text() == before


def test_code_that_was_changed_after_it_was_shown_is_not_taken(proposed: Studio) -> None:
    shown = kept(proposed)
    path = shown.folder / "sleeve_law.py"
    path.write_text(path.read_text() + "\nprint('more')\n")
    with pytest.raises(UserError, match="has changed since"):
        proposed_law.take(proposed, "sleeve", shown)
    assert not proposed.effects.path.exists()


def test_a_law_is_not_taken_while_the_model_is_asked_about(proposed: Studio) -> None:
    proposed.jobs.jobs.append(running_job("diagnose:sleeve"))
    with pytest.raises(UserError, match="still under way, and the model of sleeve must stay"):
        proposed_law.take(proposed, "sleeve", kept(proposed))
    assert not proposed.effects.path.exists()


def test_another_effect_of_that_name_is_not_replaced(proposed: Studio) -> None:
    write_template("sleeve_law", proposed.effects.path)
    proposed.effects.path.write_text(proposed.effects.path.read_text().replace("gain", "share"))
    proposed.effects.agree()
    with pytest.raises(UserError, match="another effect called sleeve_law"):
        proposed_law.take(proposed, "sleeve", kept(proposed))


def test_a_model_that_cannot_be_read_leaves_everything_as_it_was(proposed: Studio) -> None:
    (proposed_law.folder_of(proposed, "sleeve") / proposed_law.MODEL).write_text("{}")
    with pytest.raises(UserError, match="not a knitbench model"):
        proposed_law.take(proposed, "sleeve", kept(proposed))
    assert not proposed.effects.path.exists()
    assert steps_in(proposed, "sleeve") == 1


@pytest.mark.parametrize("name", ["../evil", "a b", ""])
def test_a_file_that_names_something_else_is_refused(proposed: Studio, name: str) -> None:
    bad = json.loads(json.dumps(FOUND))
    bad["laws"][0]["effect"] = name
    (proposed_law.folder_of(proposed, "sleeve") / proposed_law.JSON).write_text(json.dumps(bad))
    with pytest.raises(UserError, match="not a usable proposal"):
        proposed_law.kept_proposal(proposed, "sleeve")


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("stress_relaxation", "an effect called stress_relaxation already"),
        ("My Law", "must be like my_effect.py"),
        ("", "must be like my_effect.py"),
    ],
)
def test_a_name_that_is_none_or_taken_is_refused_before_anything_runs(proposed: Studio, name: str, why: str) -> None:
    with pytest.raises(UserError, match=why):
        proposed_law.propose_command(proposed, "sleeve", name, 1)
    assert proposed_law.kept_proposal(proposed, "sleeve") is not None


def test_the_command_is_one_that_can_be_typed(proposed: Studio) -> None:
    title, argv = proposed_law.propose_command(proposed, "sleeve", "my_law", 2)
    assert "sleeve" in title
    assert argv[:2] == ["testbench", "propose"]
    assert argv[-1].endswith("my_law.py")
    assert proposed_law.kept_proposal(proposed, "sleeve") is None


@pytest.mark.asyncio
async def test_the_page_tells_the_law_and_adds_it(user, proposed: Studio) -> None:
    await user.open("/propose?c=sleeve")
    await user.should_see("Proposed: the force rises with the memory of the strain.", retries=50)
    await user.should_see("0.0500 → 0.0100 N", retries=50)
    await user.should_see("Not judged: no temperature was recorded.")
    await user.should_see("The effect file", retries=300)
    user.find("Add sleeve law").click()
    await user.should_see("Through the history", retries=100)


@pytest.mark.asyncio
async def test_a_law_for_a_model_that_has_changed_since_is_not_offered(user, proposed: Studio) -> None:
    refit_elsewhere(proposed)
    await user.open("/propose?c=sleeve")
    await user.should_see("The model has changed since this was proposed.", retries=50)
    await user.should_not_see("Add sleeve law")


def test_whether_it_is_of_the_model_as_it_is_now_takes_one_look_at_the_file(
    proposed: Studio, monkeypatch: pytest.MonkeyPatch
) -> None:
    looks, about = [], proposed_law.about_model
    monkeypatch.setattr(proposed_law, "about_model", lambda path: looks.append(path) or about(path))
    monkeypatch.setattr(models, "about_model", looks.append)
    assert kept(proposed).fresh
    assert looks == [models.model_path(proposed, "sleeve")]
