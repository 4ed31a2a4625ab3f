"""Finding campaigns again: search, order, tags, notes, states, deleting and bringing back; and thousands of them."""

from __future__ import annotations

import json
import os
import shutil
import time
from pathlib import Path

import pytest
from nicegui.testing import User

from gcode.support.errors import UserError
from testbench.studio.finding import Found, all_tags, narrowed
from testbench.studio.models import LAST_THIRD, companions, held_out_choices
from testbench.studio.notes import Note, Notes, tags_of
from testbench.studio.pages.campaigns import found_in
from testbench.studio.studio import Studio
from testbench.studio.workspace import Campaign


def found(name: str, made_s: float = 0.0, specimen: str = "", note: Note | None = None, *states: str) -> Found:
    campaign = Campaign(name, Path(name), "imported", 25.0, "complete", specimen, made_s)
    return Found(campaign, note or Note(), frozenset(states))


FOUR = [
    found("sleeve-1", 3, "PES", Note(("wet",), "torn at 40 %"), "fitted"),
    found("sleeve-2", 1, "PES", Note(("dry", "wet"))),
    found("Strip", 2, "lycra", None, "fitted", "diagnosed"),
    found("band", 4),
]


def names(**chosen: str) -> list[str]:
    return [one.campaign.name for one in narrowed(FOUR, **chosen)]


def test_every_word_must_be_found_somewhere() -> None:
    assert names(words="pes SLEEVE") == ["sleeve-1", "sleeve-2"]
    assert names(words="torn") == ["sleeve-1"]
    assert names(words="diagnosed strip") == ["Strip"]
    assert names(words="torn strip") == []


def test_states_tags_and_orders_narrow_and_sort() -> None:
    assert names(state="fitted") == ["sleeve-1", "Strip"]
    assert names(tag="wet", order="oldest") == ["sleeve-2", "sleeve-1"]
    assert names(order="name") == ["band", "sleeve-1", "sleeve-2", "Strip"]
    assert names(order="no such order") == ["band", "sleeve-1", "Strip", "sleeve-2"]
    assert all_tags(FOUR) == ["dry", "wet"]


def test_notes_are_kept_and_seen_by_another_tab(tmp_path: Path) -> None:
    one, other = Notes(tmp_path), Notes(tmp_path)
    assert one.of("sleeve") == Note()
    one.put("sleeve", Note(tags_of(" wet, PES,wet,"), "torn"))
    assert other.of("sleeve") == Note(("wet", "PES"), "torn")
    other.put("sleeve", Note())
    assert json.loads((tmp_path / "notes.json").read_text()) == {}


@pytest.mark.parametrize("damaged", ["[", "[]", '{"sleeve": {"note": 3}}', '{"sleeve": {}, "sleeve": {}}'])
def test_damaged_notes_are_shown_as_none_and_never_written_over(tmp_path: Path, damaged: str) -> None:
    (tmp_path / "notes.json").write_text(damaged)
    assert Notes(tmp_path).all() == {}
    with pytest.raises(UserError, match=r"notes\.json: not a"):
        Notes(tmp_path).put("band", Note(text="dry"))
    assert (tmp_path / "notes.json").read_text() == damaged


def test_deleting_is_undone_with_all_that_was_made(studio: Studio) -> None:
    workspace = studio.workspace
    studio.make_results("model:sleeve")
    (workspace.results("sleeve") / "model.json").write_text("{}")
    before = (workspace.root / "sleeve" / "recording.csv").read_bytes()
    studio.deleted.add("sleeve")
    assert workspace.campaigns() == []
    ((name, place),) = studio.deleted.all()
    assert name == "sleeve"
    assert studio.deleted.restore(place) == "sleeve"
    assert (workspace.root / "sleeve" / "recording.csv").read_bytes() == before
    assert (workspace.results("sleeve") / "model.json").is_file()
    assert studio.deleted.all() == []


def test_a_note_goes_and_comes_back_with_its_campaign(studio: Studio) -> None:
    """Another campaign that gets the name meanwhile must not get the note."""
    note = Note(("wet",), "sleeve torn at 40 s")
    studio.notes.put("sleeve", note)
    place = studio.deleted.add("sleeve")
    assert studio.notes.of("sleeve") == Note()
    assert studio.deleted.restore(place) == "sleeve"
    assert studio.notes.of("sleeve") == note
    assert studio.deleted.all() == []


def test_looking_at_a_deleted_campaign_does_not_take_the_place_of_its_results(studio: Studio) -> None:
    workspace = studio.workspace
    studio.make_results("model:sleeve")
    (workspace.results("sleeve") / "model.json").write_text("{}")
    place = studio.deleted.add("sleeve")
    assert not workspace.results("sleeve").exists(), "nothing is made by asking"
    workspace.results("sleeve").mkdir()  # as an earlier version did
    studio.deleted.restore(place)
    assert workspace.made()["sleeve"] == {"fitted"}
    assert studio.deleted.all() == []


def test_old_results_are_kept_where_new_ones_have_been_made(studio: Studio) -> None:
    workspace = studio.workspace
    studio.make_results("model:sleeve")
    (workspace.results("sleeve") / "model.json").write_text("old")
    place = studio.deleted.add("sleeve")
    studio.make_results("model:sleeve")
    (workspace.results("sleeve") / "model.json").write_text("new")
    studio.deleted.restore(place)
    assert (workspace.results("sleeve") / "model.json").read_text() == "new"
    assert (place / "results" / "model.json").read_text() == "old"
    assert studio.deleted.all() == [("sleeve", place)]
    with pytest.raises(UserError, match=r"sleeve has other results now: move .* away"):
        studio.deleted.restore(place)
    shutil.rmtree(workspace.results("sleeve"))
    studio.deleted.restore(place)
    assert (workspace.results("sleeve") / "model.json").read_text() == "old"
    assert studio.deleted.all() == []


def test_a_name_that_was_taken_meanwhile_is_not_overwritten(studio: Studio) -> None:
    place = studio.deleted.add("sleeve")
    (studio.workspace.root / "sleeve").mkdir()
    (studio.workspace.root / "sleeve" / "mine.txt").write_text("mine")
    with pytest.raises(UserError, match="this name is taken"):
        studio.deleted.restore(place)
    assert studio.deleted.all()


def test_thousands_of_campaigns_are_described_from_what_is_known(studio: Studio) -> None:
    """Not timed: the second listing must read no manifest at all."""
    root = studio.workspace.root
    for number in range(1000):
        (root / f"c-{number}").mkdir()
        os.link(root / "sleeve" / "datapackage.json", root / f"c-{number}" / "datapackage.json")
    start = time.perf_counter()
    assert len(found_in(studio)) == 1001
    print(f"1001 campaigns in {time.perf_counter() - start:.2f} s")
    known = dict(studio.workspace._known)
    assert len(found_in(studio)) == 1001
    assert all(studio.workspace._known[folder] is kept for folder, kept in known.items())


@pytest.mark.asyncio
async def test_the_list_says_what_it_shows(user: User, studio: Studio) -> None:
    shutil.copytree(studio.workspace.root / "sleeve", studio.workspace.root / "strip")
    studio.notes.put("strip", Note(("wet",), "torn at 40 %"))
    studio.make_results("model:strip")
    (studio.workspace.results("strip") / "model.json").write_text("{}")
    await user.open("/?q=torn")
    await user.should_see("1 of 2")
    await user.should_see("strip")
    await user.should_see("fitted")
    await user.should_not_see("sleeve")


@pytest.mark.asyncio
async def test_a_deleted_campaign_is_offered_back(user: User, studio: Studio) -> None:
    studio.deleted.add("sleeve")
    await user.open("/")
    await user.should_see("sleeve was deleted.")
    user.find("Undo").click()
    await user.should_see("verified", retries=50)


@pytest.mark.asyncio
async def test_two_campaigns_stand_side_by_side(user: User, studio: Studio, fitted_model: Path) -> None:
    shutil.copytree(studio.workspace.root / "sleeve", studio.workspace.root / "strip")
    studio.make_results("model:strip")
    shutil.copy(fitted_model, studio.workspace.results("strip") / "model.json")
    await user.open("/side?a=sleeve&b=strip")
    await user.should_see("strip: the whole recording.", retries=50)
    await user.open("/side?a=sleeve")
    await user.should_see("Choose two campaigns")


def test_nobody_elses_recording_is_chosen_silently(studio: Studio) -> None:
    shutil.copytree(studio.workspace.root / "sleeve", studio.workspace.root / "other")
    same, rest = companions(studio, "sleeve")
    assert (same, rest) == ([], ["other"]), "no specimen was named, so nobody knows that it is the same"
    assert held_out_choices(studio, "sleeve")[0] == LAST_THIRD
