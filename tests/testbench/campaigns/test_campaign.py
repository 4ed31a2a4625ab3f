"""Campaign folders: whole, verifiable, made again byte for byte."""

from __future__ import annotations

import json
import random
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import testbench as tb
from gcode.support.errors import UserError
from testbench import cli
from testbench.api.arguments import recordings_for
from testbench.campaigns.campaign import matches, simulate_campaign, simulate_live
from testbench.campaigns.clearing import vacant
from testbench.campaigns.plan import plan_of, programs_before
from testbench.campaigns.remake import Remade, made_again
from testbench.commands._output import show
from testbench.knit.catalogue import baseline, load_catalogue
from testbench.knit.model import inputs
from testbench.recordings.files import read_recording
from testbench.recordings.instruments import Instruments, Room
from testbench.recordings.manifest import IN_PROGRESS, Campaign, problems, read_manifest, sealed, write_manifest
from testbench.recordings.versions import software_versions
from testbench.results.model_file import ModelFile, load_model_file
from testbench.rig.simulation.played import past_displacement, played
from testbench.rig.simulation.simulated import SIMULATED_HZ, Motion, SimulatedRig
from tests.testbench.rig.rigs import plan, program, triangle


@pytest.fixture
def campaign(tmp_path):
    simulate_campaign(plan(tmp_path), tmp_path / "c", triangle())
    return tmp_path / "c"


def test_a_campaign_reads_back_as_what_was_simulated(campaign):
    recording = read_recording(campaign)
    truth = plan_of(campaign).rig(triangle()).truth()
    force_N = np.interp(recording.time_s, truth.time_s, truth.force_N)
    assert recording.gauge_length_mm == 25.0
    assert recording.metadata["recipe"]["seed"] == 1
    assert (
        np.abs(recording["displacement_mm"] - np.interp(recording.time_s, truth.time_s, truth.displacement_mm)).max()
        < 1e-3
    )
    assert np.abs(recording["force_N"] - force_N).max() < 0.06  # noise, and up to 12.5 ms of staleness


def test_another_gauge_length_is_not_used_and_this_is_said(campaign, caplog):
    """Neither what a person says for bare CSVs nor what a model says takes the place of what was measured."""
    assert read_recording(campaign, 35.0).gauge_length_mm == read_recording(campaign).gauge_length_mm == 25.0
    assert "its manifest says a gauge length of 25 mm, which is used, not 35 mm" in caplog.text
    with pytest.raises(UserError, match="the gauge length must be a positive number of mm"):
        read_recording(campaign, float("nan"))


def test_a_model_of_another_set_up_is_refused_for_a_campaign(campaign, tmp_path):
    """The model's gauge length used to take the place of the campaign's, and so agreed with it always."""
    ModelFile(baseline(), 35.0).save(tmp_path / "model.json")
    with pytest.raises(UserError, match=r"fitted at a gauge length of 35 mm, but .* has 25 mm"):
        recordings_for(None, load_model_file(tmp_path / "model.json", load_catalogue()), campaign, None, None)


def test_the_same_plan_gives_the_same_bytes(campaign, tmp_path):
    simulate_campaign(plan(tmp_path), tmp_path / "again", triangle())
    for path in campaign.iterdir():
        assert path.read_bytes() == (tmp_path / "again" / path.name).read_bytes(), path.name


def test_another_seed_gives_another_recording(campaign, tmp_path):
    simulate_campaign(plan(tmp_path, seed=2), tmp_path / "other", triangle())
    assert (campaign / "recording.csv").read_bytes() != (tmp_path / "other" / "recording.csv").read_bytes()


def test_any_flipped_byte_is_found(campaign):
    chance = random.Random(7)
    assert problems(campaign) == []
    for path in sorted(campaign.iterdir()):
        good = path.read_bytes()
        for _ in range(25):
            at = chance.randrange(len(good))
            path.write_bytes(good[:at] + bytes([good[at] ^ chance.randrange(1, 256)]) + good[at + 1 :])
            try:
                found = problems(campaign)
            except UserError as error:
                found = [str(error)]
            assert path.name in " ".join(found), (path.name, at)
        path.write_bytes(good)
    assert problems(campaign) == []


def test_a_missing_and_a_shortened_file_are_named(campaign):
    (campaign / "program.tap").unlink()
    data = (campaign / "recording.csv").read_bytes()
    (campaign / "recording.csv").write_bytes(data[:-40])
    found = " ".join(problems(campaign))
    assert "program.tap: missing" in found
    assert f"recording.csv: {len(data) - 40} bytes, the manifest says {len(data)}" in found


def test_reading_a_changed_recording_is_refused(campaign):
    path = campaign / "recording.csv"
    path.write_bytes(path.read_bytes().replace(b"7.", b"8.", 1))
    with pytest.raises(UserError, match=r"recording\.csv: checksum differs"):
        read_recording(campaign)


def test_a_campaign_is_made_again_from_its_manifest(tmp_path):
    wish = plan(tmp_path)
    simulate_campaign(wish, tmp_path / "c", played(wish.program, 25.0)[0])
    assert made_again(tmp_path / "c") == Remade((), ())


def test_a_changed_model_is_noticed_when_made_again(campaign):
    # The campaign was made with another motion than its program's, so every sample must differ.
    remade = made_again(campaign)
    assert any("recording.csv: differs" in line for line in remade.differences)
    assert "made by the same software" in remade.explained(campaign)[-1]


@pytest.mark.parametrize(
    ("motion", "code", "message"),
    [
        (None, 0, "intact, made again byte for byte (by other software: code {code}, now feedfacecafe)"),
        (triangle(), 1, "intact, but it was made by other software (code {code}, now feedfacecafe)"),
    ],
)
def test_other_software_is_told_from_another_byte(tmp_path, monkeypatch, capsys, motion, code, message):
    wish, versions = plan(tmp_path), software_versions()
    simulate_campaign(wish, tmp_path / "c", motion or played(wish.program, 25.0)[0])
    later = {**versions, "code": "feedfacecafe"}
    monkeypatch.setattr("testbench.recordings.versions._software_versions", lambda: later)
    assert cli.main(["verify", "--again", str(tmp_path / "c")]) == code
    assert message.format(code=versions["code"]) in "".join(capsys.readouterr())


def test_what_is_there_and_intact_is_not_run_again(campaign, tmp_path):
    assert matches(campaign, plan(tmp_path))
    assert not matches(campaign, plan(tmp_path, seed=2))
    (campaign / "recording.csv").write_text("time_s\n")
    assert not matches(campaign, plan(tmp_path))


def test_a_campaign_holds_no_other_and_takes_the_place_of_no_folder_that_somebody_is_in(
    campaign, tmp_path, monkeypatch
):
    with pytest.raises(UserError, match="c is a campaign, which holds no others"):
        simulate_campaign(plan(tmp_path), campaign / "inner", triangle())
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    with pytest.raises(UserError, match="the one that you are in; name one in it"):
        simulate_campaign(plan(tmp_path), Path("."), triangle())


def test_other_peoples_folders_are_never_overwritten(campaign, tmp_path):
    (tmp_path / "photos").mkdir()
    (tmp_path / "photos" / "cat.jpg").write_bytes(b"cat")
    with pytest.raises(UserError, match="not a campaign"):
        vacant(tmp_path / "photos", overwrite=True)
    with pytest.raises(UserError, match="`overwrite`"):
        vacant(campaign)
    with pytest.raises(UserError, match="a campaign that was simulated, which is not overwritten"):
        vacant(campaign, overwrite=True, origin="imported")
    vacant(campaign, overwrite=True)
    assert not campaign.exists()


@pytest.mark.parametrize("name", ["notes.txt", "Thesis.tap", "recording.csv.bak", ".hidden", "before-x.tap", "plots"])
def test_what_somebody_put_beside_a_campaign_stays(campaign, name):
    (campaign / name).mkdir() if name == "plots" else (campaign / name).write_text("mine")
    before = sorted(path.name for path in campaign.iterdir())
    with pytest.raises(UserError, match=f"holds '{re.escape(name)}', which would be lost; move that away"):
        vacant(campaign, overwrite=True)
    assert sorted(path.name for path in campaign.iterdir()) == before


def test_a_manifest_that_lists_somebodys_file_does_not_make_it_ours(campaign):
    (campaign / "thesis.docx").write_text("mine")
    about, resources = read_manifest(campaign)
    write_manifest(campaign, about, [*(one.path for one in resources), "thesis.docx"])
    with pytest.raises(UserError, match=r"thesis\.docx"):
        vacant(campaign, overwrite=True)


def test_what_a_kill_left_of_our_own_files_goes_with_them(campaign):
    for name in (".room", ".recording.csv.0123abcd.csv", "before-1.tap", "recording.bad"):
        (campaign / name).write_text("")
    vacant(campaign, overwrite=True)
    assert not campaign.exists()


def test_a_measured_campaign_is_not_overwritten_by_a_simulated_one(tmp_path):
    """A data set clears a folder for each campaign that it makes, and asks nobody."""
    write_import_of(tmp_path / "c")
    with pytest.raises(UserError, match="a campaign that was imported, which is not overwritten"):
        vacant(tmp_path / "c", overwrite=True)
    assert (tmp_path / "c" / "recording.csv").is_file()


def write_import_of(folder):
    csv = folder.with_suffix(".csv")
    csv.write_text("time_s,displacement_mm,force_N\n0,0,0\n1,1,2\n2,0,0\n")
    assert cli.main(["import", str(csv), "--gauge-length-mm", "25", "-o", str(folder)]) == 0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda data: data.pop("knitbench"), "not a knitbench campaign"),
        (lambda data: data["knitbench"].update(version=99), "campaign version 99"),
        (lambda data: data["knitbench"].pop("gauge_length_mm"), "gauge_length_mm"),
    ],
)
def test_a_foreign_manifest_is_refused_in_words(campaign, change, message):
    path = campaign / "datapackage.json"
    data = json.loads(path.read_text())
    change(data)
    path.write_text(json.dumps(data))
    with pytest.raises(UserError, match=message):
        read_manifest(campaign)


def test_frictionless_accepts_it_and_finds_a_changed_file(campaign):
    frictionless = pytest.importorskip("frictionless")
    with frictionless.system.use_context(trusted=True):
        assert frictionless.validate(str(campaign / "datapackage.json")).valid
        path = campaign / "recording.csv"
        path.write_bytes(path.read_bytes().replace(b"7.", b"8.", 1))
        assert not frictionless.validate(str(campaign / "datapackage.json")).valid


# What the same sensor went through before.


def _second(tmp_path, **change):
    return replace(plan(tmp_path, seed=2), past=(program(tmp_path),), rest_s=30.0, **change)


def test_a_second_campaign_of_a_sensor_continues_where_the_first_one_and_the_rest_left_it():
    model = baseline()
    first, second = triangle(), triangle(12.0, top_mm=5.0)
    past_mm = past_displacement([first], 30.0)
    truth = SimulatedRig(model, second, 25.0, 1, past_mm=past_mm).truth()
    whole_mm = np.concatenate([past_mm, second.displacement_mm])
    whole = model.simulate(inputs(np.arange(len(whole_mm)) / SIMULATED_HZ, whole_mm / 25.0), 1 / SIMULATED_HZ)
    assert len(past_mm) == (20 + 30) * SIMULATED_HZ
    assert truth.time_s[0] == 0
    np.testing.assert_allclose(truth.conductance_S, whole["conductance_S"][len(past_mm) :], rtol=1e-12)
    fresh = SimulatedRig(model, second, 25.0, 1).truth()
    assert np.abs(np.log(truth.conductance_S / fresh.conductance_S)).max() > 0.01


@pytest.mark.parametrize("rest_s", [60.0, 5.0, 0.0])
def test_a_stage_that_ended_elsewhere_returns_during_the_rest_or_takes_longer(rest_s):
    past_mm = past_displacement([triangle(5.0)], rest_s)  # ends at 7.5 mm
    assert past_mm[-1] == 0
    assert np.abs(np.diff(past_mm)).max() <= 1.0 / SIMULATED_HZ * 1.5 * (1 + 1e-9)


def test_a_stage_rests_where_the_next_motion_begins():
    """A pre-tension offset is where the machine's zero is: there it stands between two programs."""
    past_mm = past_displacement([triangle(5.0), Motion(np.array([0.0, 1.0]), np.array([2.0, 2.0]))], 10.0, -1.0)
    assert past_mm[int((5 + 10) * SIMULATED_HZ) - 2] == 2.0
    assert past_mm[-1] == -1.0
    assert np.abs(np.diff(past_mm)).max() <= 1.0 / SIMULATED_HZ * 1.5 * (1 + 1e-9)


def test_a_campaign_with_a_past_is_made_again_from_its_own_folder(tmp_path):
    wish = _second(tmp_path)
    simulate_campaign(wish, tmp_path / "b", played(wish.program, 25.0)[0])
    wish.program.unlink()
    assert problems(tmp_path / "b") == []
    assert made_again(tmp_path / "b").differences == ()
    assert read_manifest(tmp_path / "b")[0].recipe["rest_s"] == 30.0
    (tmp_path / "b" / "before-1.tap").unlink()
    with pytest.raises(UserError, match=r"before-1\.tap: missing"):
        plan_of(tmp_path / "b")


def test_each_recording_of_a_sensor_has_noise_and_sampling_times_of_its_own_with_one_seed(tmp_path):
    first = plan(tmp_path, seed=2)
    motion, _ = played(first.program, 25.0)
    third = replace(first, past=(first.program, first.program))
    stamps = [one.rig(motion).readings().micros for one in (first, _second(tmp_path), third)]
    steps = [tuple(np.diff(one)[:20]) for one in stamps]
    assert len({*steps}) == 3


def test_past_campaigns_are_followed_back_to_the_first(tmp_path):
    wish = _second(tmp_path)
    simulate_campaign(wish, tmp_path / "b", played(wish.program, 25.0)[0])
    before, rests_s = programs_before([tmp_path / "b"], wish.model, 25.0, 600.0)
    assert [path.name for path in before] == ["before-1.tap", "program.tap"]
    assert rests_s == (30.0, 600.0)
    with pytest.raises(UserError, match="campaign of another sensor"):
        programs_before([tmp_path / "b"], wish.model.without("drift"), 25.0, 600.0)
    with pytest.raises(UserError, match="gauge length is 25 mm, this one's 40 mm"):
        programs_before([tmp_path / "b"], wish.model, 40.0, 600.0)
    with pytest.raises(UserError, match="no such campaign or program"):
        programs_before([tmp_path / "c"], wish.model, 25.0, 600.0)


def test_a_campaign_that_is_named_beside_the_one_it_came_after_does_not_count_twice(tmp_path):
    """It did, and its earlier rests were those of the new one: another state of the sensor, without a word."""
    wish = _second(tmp_path)
    motion = played(wish.program, 25.0)[0]
    simulate_campaign(replace(wish, past=()), tmp_path / "a", motion)
    simulate_campaign(wish, tmp_path / "b", motion)
    alone, together = (
        programs_before(named, wish.model, 25.0, 600.0)
        for named in ([tmp_path / "b"], [tmp_path / "a", tmp_path / "b"])
    )
    assert together == alone
    third = replace(wish, past=alone[0], rest_s=alone[1])
    simulate_campaign(third, tmp_path / "c", motion)
    assert plan_of(tmp_path / "c").rest_s == (30.0, 600.0)
    manifest = json.loads((tmp_path / "c" / "datapackage.json").read_text())
    assert made_again(tmp_path / "c").differences == ()
    assert len(third.rig(motion).past_mm) == pytest.approx((2 * motion.duration_s + 630) * SIMULATED_HZ, abs=4)
    with pytest.raises(UserError, match="went through other programs than those that you name before it"):
        programs_before([tmp_path / "a", tmp_path / "a", tmp_path / "b"], wish.model, 25.0, 600.0)
    manifest["knitbench"]["recipe"]["rest_s"].append(1.0)
    (tmp_path / "c" / "datapackage.json").write_text(sealed(manifest))
    with pytest.raises(UserError, match="names 2 earlier programs and 3 rests"):
        plan_of(tmp_path / "c")


OWN_EFFECT = """from testbench.knit.effect import Effect, Stage, parameter
class Mine(Effect):
    "G *= 1 + gain e. Source: a test. Valid: here."
    name, stage, strength, look = "mine", Stage.ELECTRICAL, "gain", "a test"
    reads, writes = ("strain", "conductance_S"), ("conductance_S",)
    gain: float = parameter(0.1, unit="1", low=-5, high=5, doc="gain")
    def apply(self, signals, dt_s):
        return {"conductance_S": signals["conductance_S"] * (1 + self.gain * signals["strain"])}
"""


def test_a_recorder_replaces_no_campaign_and_offers_no_option_that_it_has_not(campaign, capsys):
    words = ["record", "--port", "/dev/null", "--program", str(campaign / "program.tap"), "-o", str(campaign)]
    assert cli.main(words) == 2
    assert "a campaign that was simulated, which is not overwritten; choose another\n" in capsys.readouterr().err


def test_results_are_written_before_they_are_told(tmp_path, monkeypatch):
    """They were written after it, and lost where nobody took what was told."""

    class Found:
        def to_dict(self):
            return {"found": 1}

        def __str__(self):
            raise OSError("no space left")

    with pytest.raises(OSError, match="no space left"):
        show(Found(), str(tmp_path / "found.json"))
    assert json.loads((tmp_path / "found.json").read_text()) == {"found": 1}


def test_a_file_of_own_effects_that_the_sensor_has_none_of_is_not_kept(tmp_path):
    """It was, and the campaign could not be made again without it."""
    own = tmp_path / "mine.py"
    own.write_text(OWN_EFFECT)
    program = plan(tmp_path).program
    made = tb.run("pes", program, tmp_path / "c", effects=own)
    assert not (made.folder / "effects.py").exists()
    assert "effects_sha256" not in made.recording.metadata["recipe"]
    assert tb.verify(made.folder, again=True).intact


def test_a_campaign_with_own_effects_carries_them_and_asks_before_it_runs_them(tmp_path, capsys):
    own = tmp_path / "mine.py"
    own.write_text(OWN_EFFECT)
    model = baseline() + load_catalogue(own)["mine"]()
    wish = replace(plan(tmp_path), model=model, effects=own)
    simulate_campaign(wish, tmp_path / "c", played(wish.program, 25.0)[0])
    own.unlink()
    words = ["verify", "--again", str(tmp_path / "c")]
    assert cli.main(words) == 2
    assert "effects of somebody's own; read" in capsys.readouterr().err
    assert cli.main([*words, "--effects", str(tmp_path / "c" / "effects.py")]) == 0
    other = tmp_path / "other.py"
    other.write_text(OWN_EFFECT.replace("0.1", "0.2"))
    assert cli.main([*words, "--effects", str(other)]) == 2
    assert "other.py: not the effects that" in capsys.readouterr().err


@pytest.mark.parametrize("how", [simulate_campaign, simulate_live])
def test_a_run_without_a_single_sample_is_not_complete(tmp_path, how):
    """Its room is hotter than the digits of a line: all were refused, and it ended as if all were well."""
    instruments = Instruments(room=Room(mean_C=1e7))
    with pytest.raises(UserError, match=r"none of the simulated rig's \d+ lines was accepted"):
        how(hot := replace(plan(tmp_path), instruments=instruments), tmp_path / "hot", triangle())
    assert not matches(tmp_path / "hot", hot)  # run again, it would be called intact


def test_what_nobody_could_read_is_not_run(tmp_path):
    """It was, as complete: a single sample, a stretch beyond any knit, a seed that no manifest keeps."""
    wish = plan(tmp_path)
    slow = tb.Instruments(clock={"rate_hz": 0.01})
    with pytest.raises(UserError, match=r"took one sample in 20 s, and a recording needs two"):
        simulate_campaign(replace(wish, instruments=slow), tmp_path / "slow", triangle())
    with pytest.raises(UserError, match=r" s: a displacement of 5 mm at a gauge length of 0.2 mm is a strain of 25"):
        tb.run("pes", wish.program, tmp_path / "c", gauge_length_mm=0.2)
    with pytest.raises(UserError, match="seed: must be at most 18446744073709551615, got"):
        tb.run("pes", wish.program, tmp_path / "c", seed=1 << 64)
    assert not {"slow", "c"} & {path.name for path in tmp_path.iterdir()}


def test_an_unfinished_campaign_is_continued_by_what_may_be_pasted(tmp_path):
    shown = Campaign(25.0, "recorded", IN_PROGRESS, {"sensor": ""}, {}, {})
    folder = tmp_path / "knit 7"
    folder.mkdir()
    recipe = {"port": "/dev/ttyUSB0", "baud": 1, "max_force_N": None, "max_strain": None, "program": "program.tap"}
    write_manifest(folder, replace(shown, recipe={**shown.recipe, **recipe, "program_sha256": "1" * 64}), [])
    assert problems(folder) == [f"{folder}: unfinished; continue it with `testbench record --resume -o '{folder}'`"]


def test_a_room_swings_as_rooms_do(tmp_path, capsys):
    words = ["run", "--sensor", "pes", "--program", str(program(tmp_path)), "-o", str(tmp_path / "c")]
    assert cli.main([*words, "--room-swing-c", "1e6"]) == 2
    assert "error: --room-swing-c: Input should be less than or equal to 60" in capsys.readouterr().err
    assert not (tmp_path / "c").exists()
