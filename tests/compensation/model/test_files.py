"""A compensator from a stranger: its checksum is right, and what it holds may be anything."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from compensation.cli import main
from compensation.memories.history import History
from compensation.model import files
from compensation.model.compensator import Scaling
from compensation.training.options import Options
from gcode.support.errors import UserError
from testbench.recordings.files import write_recording_csv
from tests.compensation.conftest import train


@pytest.fixture(scope="module")
def place(recordings, tmp_path_factory):
    """A folder with a compensator, ``c.json``, and a recording, ``r.csv``."""
    folder = tmp_path_factory.mktemp("strangers")
    options = Options(sizes=(3,), count=4, restarts=1, history=History((0.5,), (0.5,)), engine="fast")
    files.save(folder / "c.json", train(recordings[:1], "force", options))
    write_recording_csv(folder / "r.csv", recordings[1])
    return folder


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        (("scaling_in", "scale"), 1e-300, "scaling_in.scale"),
        (("scaling_out", "scale"), 1e300, "scaling_out.scale"),
        (("networks", 0, "weights", 0, 0, 0), 1e300, "networks.0.weights.0.0.0"),
        (("rate_hz",), 1e300, "rate_hz"),
        (("alphas", 0), 1e-300, "alphas.0"),
        (("alphas", 0), 2.0, "alphas.0"),
        (("history", "settle_s"), 1e-300, "history.settle_s"),
        (("history", "play_radii", 0), 1e300, "history.play_radii.0"),
        (("seen", "low"), 1e9, "seen: the lower end"),
        (("seen", "inputs_low", 0), 1e9, "seen: the lower end"),
        (("margins",), [1.0, -1.0], "margins: the lower end"),
        (("recipe", "trained_on"), 5, "recipe.trained_on"),
        (("recipe", "cross_validated"), "x", "recipe.cross_validated"),
        (("recipe", "recalibrated"), 5, "recipe.recalibrated"),
        (("recipe", "recalibrated"), {"on": 5}, "recipe.recalibrated.0.on"),
        (
            ("recipe", "recalibrated"),
            [{"on": "r.csv", "marks": ["00"]}],
            "recipe.recalibrated.0.marks.0",
        ),
        (("networks", 0, "weights", 0, 0), [1.0], "a layer has rows of weights of different lengths"),
        (("networks", 0, "biases"), [[0.0]] * 20_001, "networks.0.biases: List should have at most 9 items"),
        (("networks", 0, "biases", 0), [0.0] * 257, "networks.0.biases.0: List should have at most 256 items"),
    ],
    ids=lambda one: ".".join(map(str, one)) if isinstance(one, tuple) else "",
)
def test_numbers_that_nothing_could_run_are_refused_in_one_sentence(place, capsys, path, value, words):
    data = json.loads((place / "c.json").read_text())
    inner = data
    for key in path[:-1]:
        inner = inner[key]
    inner[path[-1]] = value
    data["sha256"] = files._digest({key: held for key, held in data.items() if key != "sha256"})
    (place / "strange.json").write_text(json.dumps(data))
    strange, recording, out = (str(place / name) for name in ("strange.json", "r.csv", "out"))
    for argv in (
        ["predict", recording, "--compensator", strange, "-o", out],
        ["score", strange, recording],
        ["export", strange, "-o", out],
        ["recalibrate", strange, recording, "-o", out],
    ):
        assert main(argv) == 2
        assert f"not a usable compensator: {words}" in capsys.readouterr().err


def test_what_is_honest_is_read_as_it_was_written(place):
    read = files.load(place / "c.json")
    files.save(place / "again.json", read)
    assert json.loads((place / "again.json").read_text()) == json.loads((place / "c.json").read_text())


def test_a_network_that_is_dead_is_told_wherever_it_is_used(place, caplog):
    """`train` warned once; a constant force with status 0 would be believed by whoever gets the file."""
    live = files.load(place / "c.json")
    files.save(place / "dead.json", replace(live, recipe={**live.recipe, "dead_networks": 1, "restarts": 1}))
    assert not caplog.text
    assert (
        main(["predict", str(place / "r.csv"), "--compensator", str(place / "dead.json"), "-o", str(place / "p")])
        == 0
    )
    assert "dead.json: its network is dead, its output hardly moves; train with another --seed" in caplog.text


def test_what_could_not_be_read_is_not_written(place):
    """Siemens by the billionth of a billionth of a billionth: no chip holds their spread."""
    read = files.load(place / "c.json")
    tiny = replace(read, scaling_in=Scaling(read.scaling_in.mean, 1e-33))
    nan = replace(read, margins=(float("nan"), 1.0))
    for wrong, words in ((tiny, r"scaling_in\.scale: .*got 1e-33; bring"), (nan, "not written.*; bring conductance")):
        with pytest.raises(UserError, match=words):
            files.save(place / "unreadable.json", wrong)
        assert not (place / "unreadable.json").exists()


@pytest.mark.parametrize(
    "words",
    [
        ["predict", "r.csv", "--compensator", "c.json", "-o", "r.csv"],
        ["predict", "r.csv", "--compensator", "c.json", "-o", "c.json"],
        ["recalibrate", "c.json", "r.csv", "-o", "r.csv"],
        ["train", "r.csv", "--target", "force", "-o", "r.csv"],
        ["score", "c.json", "r.csv", "-o", "r.csv"],
        ["export", "c.json", "-o", "c.json"],
    ],
    ids=lambda words: f"{words[0]}-{words[-1]}",
)
def test_what_is_read_is_never_replaced(place, capsys, monkeypatch, words):
    monkeypatch.chdir(place)
    before = {name: (place / name).read_bytes() for name in ("c.json", "r.csv")}
    assert main(words) == 2
    assert f"{words[-1]}: is read, and would be written over" in capsys.readouterr().err
    assert {name: (place / name).read_bytes() for name in before} == before
