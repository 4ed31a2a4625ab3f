"""What a person fills in on a page: it is checked, kept in the address, and asked for where it is missing."""

from __future__ import annotations

import argparse
import asyncio
import json
from pathlib import Path
from urllib.parse import quote_plus

import pytest
from nicegui import Client, ui
from nicegui.testing import User

from gcode.support.errors import UserError
from testbench.commands.record import add_arguments
from testbench.studio.jobs.job import Job, State
from testbench.studio.pages import record
from testbench.studio.parts.address import address
from testbench.studio.parts.picture import Picture
from testbench.studio.parts.running_jobs import place_of
from testbench.studio.studio import KEY_RECORDING, KEY_RIG, Studio
from tests.testbench.importing import exports
from tests.testbench.studio.diagnoses import with_diagnosis

pytestmark = pytest.mark.asyncio


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


async def test_a_column_that_is_chosen_goes_into_the_address(
    user: User, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The page looks at the file again and draws its lists anew, the one that was chosen from, too."""
    path, addresses = tmp_path / "plain.csv", []
    path.write_text("".join(f"{n / 10},{n % 7},{n % 5}\n" for n in range(60)))
    monkeypatch.setattr(Client, "run_javascript", lambda self, code, **_: addresses.append(code))
    await user.open(address("/import", file=str(path)))
    await user.should_see("Found: no row of names", retries=100)
    (force,) = (box for box in _selects(user) if box.props.get("aria-label") == "Column of force")
    force.set_value("3")
    await user.should_see("the file does not say the unit", retries=100)
    assert quote_plus('{"columns":{"force":"3"}}') in addresses[-1]


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


async def test_a_number_that_an_import_cannot_take_is_refused_in_words(user: User, tmp_path: Path) -> None:
    path = tmp_path / "plain.csv"
    path.write_text("".join(f"{n % 9},{n % 7},{n % 5}\n" for n in range(60)))
    told = json.dumps({"columns": {"displacement": "1", "force": "3"}, "units": {"displacement": "mm", "force": "N"}})
    await user.open(address("/import", file=str(path), chosen=told))
    await user.should_see("Sampling rate / Hz", retries=100)
    user.find(kind=ui.number, content="Sampling rate / Hz").type("-20")
    user.find(kind=ui.button, content="Import").click()
    await user.should_see("The sampling rate must be more than 0.")
    user.find("Header row").type("-1")
    user.find(kind=ui.number, content="Gauge length / mm").type("-5").trigger("blur")
    assert numbers(user)["Gauge length / mm"] == -5
    user.find(kind=ui.button, content="Import").click()
    await user.should_see("The gauge length must be more than 0.")
    fields = {field.props["label"]: field for field in user.find(kind=ui.number).elements}
    assert fields["Header row"].error == "The header row must be a whole number, 0 or more."


async def test_more_laws_than_are_looked_for_are_refused_in_words(user: User, fitted: Studio) -> None:
    await user.open("/propose?c=sleeve")
    user.find("Laws at most").clear().type("99").trigger("blur")
    user.find(kind=ui.button, content="Look for a law").click()
    await user.should_see("Give a whole number from 1 to 4.")
    assert not fitted.jobs.jobs


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


async def test_enter_reads_the_file_and_its_letters_name_the_campaign(user: User, tmp_path: Path) -> None:
    path = exports.testxpert(tmp_path).rename(tmp_path / "Probe Süß 7 (Nässe).txt")
    await user.open("/import")
    user.find("File on this machine").type(str(path)).trigger("keydown.enter")
    await user.should_see("Found: names in row 1", retries=50)
    (name,) = user.find(kind=ui.input, content="Campaign name").elements
    assert name.value == "Probe-Süß-7-Nässe"


async def test_what_the_uploader_rejects_is_said(user: User) -> None:
    await user.open("/import")
    user.find(kind=ui.upload).trigger("rejected", args=[["accept", "notes.pdf"]])
    await user.should_see("notes.pdf: no file of a kind that can be read")


async def test_what_a_person_says_of_a_specimen_may_begin_with_a_dash(
    user: User, studio: Studio, monkeypatch: pytest.MonkeyPatch
) -> None:
    program = studio.workspace.root / "programs" / "short" / "program.tap"
    program.parent.mkdir(parents=True)
    program.write_text("G0 X0\n")
    begun: list[list[str]] = []

    def start(key: str, title: str, argv: list[str]) -> None:
        begun.append(argv)
        raise UserError("begun")

    monkeypatch.setattr(studio.jobs, "start", start)
    await user.open("/record")
    user.find("Port").clear().type("/dev/ttyNONE")
    user.find("Specimen").type("-wet")
    user.find(kind=ui.button, content="Record").click()
    await user.should_see("begun")
    parser = argparse.ArgumentParser()
    add_arguments(parser)
    assert parser.parse_args(begun[0][2:]).specimen == "-wet"


async def test_a_recording_begins_though_its_page_is_left_while_the_rig_starts(
    user: User, studio: Studio, monkeypatch: pytest.MonkeyPatch
) -> None:
    program = studio.workspace.program("short") / "program.tap"
    program.parent.mkdir(parents=True)
    program.write_text("G0 X0\n")
    begun: list[str] = []
    shown: list[object] = []

    async def leave(*_: object) -> str:
        ui.context.client.content.clear()
        return "/dev/ttyNONE"

    monkeypatch.setattr(record, "_simulated_port", leave)
    monkeypatch.setattr(record, "Live", lambda *given: shown.append(given))
    monkeypatch.setattr(studio.jobs, "start", lambda key, *_: begun.append(key))
    await user.open("/record")
    user.find(kind=ui.button, content="Record").click()
    for _ in range(100):
        await asyncio.sleep(0)
    assert begun == [KEY_RECORDING]
    assert not shown, "nobody would see it, and it would look for samples for ever"


async def test_a_recorder_that_did_not_begin_promises_nothing_and_leads_back(user: User, studio: Studio) -> None:
    job = Job(KEY_RECORDING, "Recording new", ("testbench", "record", "-o", str(studio.workspace.root / "new")))
    rig = Job(KEY_RIG, "Simulated rig", ("testbench", "rig"))
    studio.jobs.jobs += [job, rig]
    await user.open("/record")
    await user.should_see("waiting for the first sample", retries=50)
    job.hear_error("error: no such port")
    job.state, job.ended_s = State.FAILED, job.started_s
    await user.should_see("no such port", retries=50)
    await user.should_not_see("Every sample up to that moment is on disk")
    await user.should_see("Record another", retries=50)
    await user.should_see("nothing was recorded")
    await user.should_not_see(kind=Picture)
    assert rig.state is State.CANCELLED
    user.find("Record another").click()
    await user.should_see("No program yet", retries=50)


async def test_the_rig_of_a_recording_that_a_limit_has_ended_plays_on_to_nobody(user: User, studio: Studio) -> None:
    folder = studio.workspace.root / "sleeve"
    manifest = folder / "datapackage.json"
    told = json.loads(manifest.read_text())
    told["knitbench"] |= {"origin": "recorded", "status": "alarm"}
    manifest.write_text(json.dumps(told))
    job = Job(KEY_RECORDING, "Recording sleeve", ("testbench", "record", "-o", str(folder)))
    rig = Job(KEY_RIG, "Simulated rig", ("testbench", "rig"))
    studio.jobs.jobs += [job, rig]
    await user.open("/record")
    job.hear_error("error: force 2.5 N is beyond the limit of 2 N")
    job.state, job.ended_s = State.FAILED, job.started_s
    await user.should_see("Open the recording", retries=50)
    await user.should_not_see("Resume")
    assert rig.state is State.CANCELLED


async def test_a_plan_that_failed_still_says_so_after_a_reload(user: User, studio: Studio) -> None:
    argv = ["gcode", "generate", "--preset", "paper-1", "--seed", "1", "--gauge-length-mm", "25", "--v-max=0.0001"]
    job = studio.jobs.start("plan:slow", "Planning slow", [*argv, "-o", str(studio.workspace.root / "p")])
    assert place_of(job) == "/plan"
    await asyncio.wait_for(job.task, 60)
    await user.open("/plan")
    await user.should_see("Planning slow")
    await user.should_see("failed after")
