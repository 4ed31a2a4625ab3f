"""``testbench investigate`` and `tb.investigate`: exit codes, what is kept and printed, and what is refused."""

from __future__ import annotations

import json

import pytest
from matplotlib.figure import Figure

import testbench as tb
from gcode.support.errors import UserError
from testbench.cli import main
from testbench.investigating import loop
from testbench.investigating.state import NAME
from testbench.knit.catalogue import load_catalogue
from tests.testbench.builders import own_effect
from tests.testbench.investigating.samples import SET, hidden, scripted_belief

BRIEF = ["--run-minutes", "2", "--budget-minutes", "4", "--trials", "1", "--rest-s", "5", "--quiet"]


@pytest.fixture
def sensor(tmp_path) -> str:
    """A model.json of the hidden sensor."""
    path = tmp_path / "hidden.json"
    path.write_text(json.dumps(hidden().to_dict()))
    return str(path)


def test_a_sure_one_ends_with_0_and_a_spent_one_with_1_and_both_are_kept(tmp_path, sensor, monkeypatch, capsys):
    scripted_belief(monkeypatch, 0.6, 0.99)
    folder, out = tmp_path / "i", tmp_path / "out.json"
    assert main(["investigate", sensor, "-o", str(folder), *BRIEF, "--json", str(out)]) == 0
    said = capsys.readouterr().out
    assert "run 1, 2.0 min: noise 32 s to 30 %, to 30 % at 8.7 mm/s, hold 15 s, back to zero" in said
    assert "expected to tell" in said
    assert "permanent set: 99 % after 3." in said or "permanent set: 99 % after 4." in said
    assert json.loads(out.read_text()) == json.loads((folder / NAME).read_text())
    for number in (1, 2):
        assert (folder / f"belief-{number}.png").read_bytes().startswith(b"\x89PNG")
    scripted_belief(monkeypatch, 0.6, 0.7)
    assert main(["investigate", sensor, "-o", str(tmp_path / "j"), *BRIEF, "--motion", "perlin"]) == 1
    said = capsys.readouterr().out
    assert "run 1, 2.0 min: random motion" in said
    assert "the time is spent" in said
    # Both have ended: going on changes nothing and needs no sensor.
    assert main(["investigate", "--resume", "-o", str(folder), "--quiet"]) == 0
    assert main(["investigate", "--resume", "-o", str(tmp_path / "j"), "--quiet"]) == 1


def test_the_result_shows_itself(tmp_path, monkeypatch):
    scripted_belief(monkeypatch, 0.6, 0.99)
    found = tb.investigate(
        hidden(), tmp_path / "i", run_minutes=2, budget_minutes=4, trials=1, rest_s=5, progress=False
    )
    assert (found.hypothesis, found.probability, found.is_sure) == (SET, 0.99, True)
    frame = found.to_frame()
    assert list(frame["run"]) == [1, 2]
    assert list(frame["probability"]) == [0.6, 0.99]
    assert found.minutes == pytest.approx(frame["minutes"].sum())
    assert list(found.beliefs()[SET]) == [0.6, 0.99]
    axis = Figure().subplots()
    assert found.plot(axis) is axis
    assert list(axis.lines[0].get_ydata()) == [60, 99]
    assert "permanent set: 99 %" in found._repr_html_()
    assert json.loads(json.dumps(found.to_dict()))["ended"] == "sure"
    again = tb.investigate(folder=tmp_path / "i", resume=True, progress=False)
    assert again.to_dict() == found.to_dict()


@pytest.mark.parametrize(
    ("argv", "match"),
    [
        ([], "SENSOR"),
        (["absent.json"], "no such model.json"),
        (["pes", "--port", "/dev/null"], "SENSOR"),
        (["pes", "--sure", "2"], "sure"),
        (["pes", "--budget-minutes", "1"], "less than one run"),
        (["pes", "--run-minutes", "0.5"], "error: --run-minutes: an experiment takes 1 min to 24 h, got 0.5 min"),
        (["pes", "--effects", "absent.py"], "absent.py"),
        (["--resume"], "no investigation"),
        (["--resume", "--trials", "24"], "--trials: an investigation goes on as it began"),
        (["--resume", "--v-max", "9"], "--v-max: an investigation goes on as it began"),
        (["--resume", "--fresh"], "--fresh: an investigation goes on as it began"),
        (["pes", "--resume"], "leave SENSOR out"),
        (["--resume", "--model", "pes"], "--model: an investigation goes on as it began"),
        (["--port", "/dev/knitbench-is-not-there"], "/dev/knitbench-is-not-there"),
        (["--port", "/dev/null", "--speed", "3"], "speed: is that of the simulated rig"),
        (["--port", "http://here"], "http://here"),
    ],
)
def test_bad_input_is_one_sentence_and_leaves_nothing(tmp_path, capsys, argv, match):
    folder = tmp_path / "i"
    assert main(["investigate", *argv, "-o", str(folder)]) == 2
    said = capsys.readouterr().err.strip()
    assert match in said
    assert "Traceback" not in said
    assert not folder.exists()


def test_a_diagnosis_may_look_for_any_number_of_effects(tmp_path, sensor, monkeypatch, capsys):
    """More than ten were refused, by the name of an entry of the file."""
    scripted_belief(monkeypatch, 0.99)
    assert main(["investigate", sensor, "-o", str(tmp_path / "i"), *BRIEF, "--repeat", "99"]) == 0
    with pytest.raises(tb.UserError, match="most: effects to find must be a whole number, 1 or more, got 0"):
        tb.investigate("pes", tmp_path / "j", most=0)


def test_minutes_and_sureness_can_be_said_anew(tmp_path, sensor, monkeypatch):
    scripted_belief(monkeypatch, 0.6, 0.7, 0.8)
    folder = tmp_path / "i"
    assert main(["investigate", sensor, "-o", str(folder), *BRIEF]) == 1
    on = ["investigate", "--resume", "-o", str(folder), "--quiet"]
    assert main([*on, "--sure", "0.65"]) == 0
    scripted_belief(monkeypatch, 0.8)
    assert main([*on, "--sure", "0.9", "--budget-minutes", "6"]) == 1
    state = json.loads((folder / NAME).read_text())
    assert (len(state["runs"]), state["settings"]["budget_s"], state["settings"]["sure"]) == (3, 360, 0.9)


def test_one_of_the_simulated_rig_does_not_go_on_with_a_real_sensor(tmp_path, sensor, monkeypatch, capsys):
    scripted_belief(monkeypatch, 0.6, 0.7, 0.8)
    folder = tmp_path / "i"
    assert main(["investigate", sensor, "-o", str(folder), *BRIEF]) == 1
    assert main(["investigate", "--resume", "-o", str(folder), "--port", "/dev/null", "--quiet"]) == 2
    assert "was made on the simulated rig" in capsys.readouterr().err


def test_a_folder_that_is_taken_and_a_damaged_state_are_refused(tmp_path, sensor, capsys):
    folder = tmp_path / "i"
    folder.mkdir()
    (folder / NAME).write_text('{"format": "knitbench-investigation"')
    assert main(["investigate", sensor, "-o", str(folder)]) == 2
    assert "--resume" in capsys.readouterr().err
    assert main(["investigate", "--resume", "-o", str(folder)]) == 2
    assert "not valid JSON" in capsys.readouterr().err


LAW = own_effect("law_x")


@pytest.fixture
def law(tmp_path) -> str:
    """A file with an effect of somebody's own."""
    path = tmp_path / "law_x.py"
    path.write_text(LAW)
    return str(path)


@pytest.fixture
def starts(monkeypatch) -> list:
    """What each diagnosis starts from: the model, and whether the own effect is in the catalogue."""
    believing, seen = scripted_belief(monkeypatch, 0.6, 0.6, 0.6, 0.6), []

    def spied(measurement, runs, catalogue, start=None, most=1, tell=None):
        seen.append((start and start.to_dict(), "law_x" in catalogue.effects))
        return believing(measurement, runs, catalogue, start, most, tell)

    monkeypatch.setattr(loop, "belief_after", spied)
    return seen


def test_it_goes_on_with_the_model_and_the_effects_that_it_began_with(tmp_path, sensor, law, starts, capsys):
    folder = tmp_path / "i"
    own = ["--model", sensor, "--effects", law, "--motion", "perlin"]
    assert main(["investigate", sensor, "-o", str(folder), *BRIEF, *own]) == 1
    on = ["investigate", "--resume", "-o", str(folder), "--quiet", "--budget-minutes", "6"]
    assert main([*on, "--effects", str(folder / "effects.py")]) == 1
    assert starts == [(hidden().to_dict(), True)] * 3
    capsys.readouterr()
    assert main(on) == 2
    assert f"give --effects {folder / 'effects.py'}" in capsys.readouterr().err
    other = tmp_path / "other.py"
    other.write_text(LAW.replace("0.1", "0.2"))
    assert main([*on, "--effects", str(other)]) == 2
    assert "other.py: not the effects that" in capsys.readouterr().err


def test_it_refuses_other_effects_in_python_and_another_model(tmp_path, law, starts):
    own, folder = load_catalogue(law), tmp_path / "i"
    brief = {"run_minutes": 2, "budget_minutes": 4, "rest_s": 5, "motion": "perlin", "progress": False}
    on = {"folder": folder, "resume": True, "progress": False, "budget_minutes": 6}
    tb.investigate(hidden(), folder, effects=own, **brief)
    with pytest.raises(UserError, match=r"began with \(law_x\), got none; give the same"):
        tb.investigate(**on)
    with pytest.raises(UserError, match="leave model out"):
        tb.investigate(**on, effects=own, model=hidden())
    tb.investigate(**on, effects=own["law_x"])
    assert starts == [(None, True)] * 3


def test_one_of_an_older_version_goes_on(tmp_path, sensor, law, starts):
    folder = tmp_path / "i"
    assert main(["investigate", sensor, "-o", str(folder), *BRIEF, "--motion", "perlin"]) == 1
    state = json.loads((folder / NAME).read_text())
    for name in ("effects_sha256", "own_effects"):
        del state["settings"][name]
    (folder / NAME).write_text(json.dumps(state))
    again = ["investigate", "--resume", "-o", str(folder), "--quiet", "--budget-minutes", "6", "--effects", law]
    assert main(again) == 1
    assert starts[-1] == (None, True)


def test_bad_words_take_only_away_what_was_made(tmp_path, capsys):
    """The folder was there before, and behind a link: the fault of the port is told, not one of the clearing."""
    (tmp_path / "empty").mkdir()
    link = tmp_path / "link"
    link.symlink_to("empty")
    assert main(["investigate", "--port", "/dev/knitbench-is-not-there", "-o", str(link)]) == 2
    assert "/dev/knitbench-is-not-there" in capsys.readouterr().err
    assert link.is_symlink()
    assert list((tmp_path / "empty").iterdir()) == []
