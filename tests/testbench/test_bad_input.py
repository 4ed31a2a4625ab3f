"""Bad recordings, models and effects: one sentence, exit code 2, no verdict."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from gcode.support.errors import UserError
from testbench.cli import main
from testbench.comparing.ladder import ladder_step
from testbench.knit.catalogue import load_catalogue
from testbench.knit.model import inputs
from testbench.measurements.preparing import prepare
from testbench.results.model_file import ModelFile
from tests.testbench.builders import motion, own_effect, record, truth, write_csv

BAD = {
    "force[7] = np.nan; return {'force_N': force}": "returned force_N with 1 values that are not finite",
    "return {'force_N': force[:5]}": r"returned force_N of shape \(5,\)",
    "return {'force_N': list(force)}": "returned force_N as list",
    "return {'force_N': force + 0j}": "returned force_N of type complex128",
    "return {'strain': force}": "must return force_N, got strain",
    "return force": "must return force_N, got ndarray",
    "raise RuntimeError('out of yarn')": "raised RuntimeError: out of yarn",
}


def refused(capsys, *argv: str) -> str:
    """The one sentence with which a command line is refused."""
    assert main(list(argv)) == 2
    shown = capsys.readouterr()
    assert "missing" not in shown.out
    assert "Traceback" not in shown.err
    lines = [line for line in shown.err.strip().splitlines() if not line.endswith("...")]
    assert len(lines) == 1, shown.err
    return lines[0]


@pytest.fixture
def csv(tmp_path):
    return write_csv(record(truth(), 120, 12.0), tmp_path / "run.csv")


def misbehaving(folder: Path, body: str) -> Path:
    """A user's file with an effect that ends so."""
    path = folder / "mine.py"
    path.write_text(own_effect("mine", body))
    return path


@pytest.mark.parametrize(("body", "match"), BAD.items())
def test_a_users_effect_that_misbehaves_is_named(tmp_path, body, match):
    mine = load_catalogue(misbehaving(tmp_path, body))["mine"]()
    with pytest.raises(UserError, match=f"effect mine {match}.* --check"):
        truth().plus(mine).simulate(inputs(*motion(5.0, 20.0)), 0.05)


@pytest.mark.parametrize(("body", "match"), list(BAD.items())[::6])
def test_a_users_effect_that_misbehaves_ends_a_diagnosis(tmp_path, csv, capsys, body, match):
    mine = str(misbehaving(tmp_path, body))
    error = refused(capsys, "diagnose", csv, "--gauge-length-mm", "25", "--effects", mine, "--quiet")
    assert re.search(f"effect mine {match}.* --check", error)


def test_starts_of_a_users_effect_that_misbehave_are_named(tmp_path):
    path = misbehaving(tmp_path, "return {'force_N': force}")
    path.write_text(
        path.read_text() + "\n    def starts(self, signals, residual):\n        return [residual['nothing'][0]]\n"
    )
    mine, signals = load_catalogue(path)["mine"](), inputs(*motion(5.0, 20.0))
    with pytest.raises(UserError, match=r"effect mine: starts raised KeyError: 'nothing'; .* --check"):
        mine.started(signals, {})


CASES = {
    "too short to identify": record(truth(), 15),
    "too short to fit on one part": record(truth(), 25, 10),
    "too still": record(truth(), 120, strain=lambda t: 0.1 + 1e-4 * np.sin(t)),
    "on which the model is fitted": record(
        truth(), 120, strain=lambda t: np.where(t < 100, 0.1, 0.1 + 0.1 * np.sin(t))
    ),
}


@pytest.mark.parametrize("match", CASES)
@pytest.mark.parametrize("command", ["fit", "diagnose"])
def test_recordings_that_tell_nothing(tmp_path, capsys, command, match):
    path = write_csv(CASES[match], tmp_path / "run.csv")
    out = tmp_path / "model.json"
    assert match in refused(capsys, command, path, "--gauge-length-mm", "25", "-o", str(out))
    assert not out.exists()


def test_a_recording_that_is_hardly_too_short_is_not_said_to_be_long_enough(tmp_path, capsys):
    path = write_csv(record(truth(), 19.99), tmp_path / "run.csv")
    error = refused(capsys, "fit", path, "--gauge-length-mm", "25", "-o", str(tmp_path / "model.json"))
    assert "samples in 19.9 s, at least" in error


def test_a_constant_channel(tmp_path, capsys):
    source = record(truth(), 120)
    channels = {**source.channels, "resistance_ohm": np.full(len(source), 470.0)}
    path = write_csv(type(source)(source.time_s, channels, 25.0), tmp_path / "run.csv")
    assert "resistance_ohm is constant (470)" in refused(capsys, "diagnose", path, "--gauge-length-mm", "25")


def test_a_held_out_recording_of_other_channels(tmp_path, csv, capsys):
    other = write_csv(record(truth(), 120, channels=("force_N",)), tmp_path / "other.csv")
    error = refused(capsys, "fit", csv, "--held-out", other, "--gauge-length-mm", "25")
    assert "both need the same channels" in error


@pytest.mark.parametrize("command", ["compare", "diagnose"])
def test_a_model_of_another_gauge_length(tmp_path, csv, capsys, command):
    measurement = prepare(record(truth(), 120, 12.0))
    step = ladder_step("baseline", truth(), measurement, measurement)
    ModelFile(truth(), 60.0, "r", "h", {}, (step,)).save(tmp_path / "model.json")
    error = refused(capsys, command, csv, "--model", str(tmp_path / "model.json"), "--gauge-length-mm", "25")
    assert "fitted at a gauge length of 60 mm" in error


@pytest.mark.parametrize("command", ["compare", "diagnose", "propose", "report"])
def test_a_model_that_was_fitted_on_fewer_channels(tmp_path, csv, capsys, command):
    """Of the force it knows nothing, though it simulates one."""
    measurement = prepare(record(truth(), 120, 12.0, channels=("resistance_ohm",)))
    step = ladder_step("baseline", truth(), measurement, measurement)
    ModelFile(truth(), 25.0, "r", "h", {}, (step,)).save(tmp_path / "model.json")
    words = {
        "propose": [csv, "-o", str(tmp_path / "my_law.py")],
        "report": ["--recording", csv, "-o", str(tmp_path / "r.html")],
    }.get(command, [csv])
    error = refused(capsys, command, *words, "--model", str(tmp_path / "model.json"), "--gauge-length-mm", "25")
    assert "model.json: fitted on conductance alone, but" in error
    assert "has force_N, too" in error


def test_a_held_out_recording_alone_is_no_report(tmp_path, csv, capsys):
    measurement = prepare(record(truth(), 120, 12.0))
    step = ladder_step("baseline", truth(), measurement, measurement)
    ModelFile(truth(), 25.0, "r", "h", {}, (step,)).save(tmp_path / "model.json")
    words = ["--held-out", csv, "--gauge-length-mm", "25", "-o", str(tmp_path / "r.html")]
    for beside in (["--model", str(tmp_path / "model.json")], ["--recording", csv]):
        assert "--held-out is what a model is judged on, beside" in refused(capsys, "report", *beside, *words)


def test_a_report_says_that_what_is_held_out_is_what_was_fitted_on(tmp_path, csv, caplog):
    measurement = prepare(record(truth(), 120, 12.0))
    step = ladder_step("baseline", truth(), measurement, measurement)
    ModelFile(truth(), 25.0, "r", "h", {}, (step,)).save(tmp_path / "model.json")
    words = ["--held-out", csv, "--gauge-length-mm", "25", "-o", str(tmp_path / "r.html")]
    assert main(["report", "--recording", csv, "--model", str(tmp_path / "model.json"), *words]) == 0
    assert "holds the same samples as what is fitted on" in caplog.text


@pytest.mark.parametrize(
    ("words", "match"),
    [
        ("--plot q.png", "--plot draws one effect"),
        ("stress_relaxation --check --plot q.png", "--plot draws one effect"),
        ("stress_relaxation --markdown", "--markdown is the list of all effects"),
        ("--markdown -o list.md", "-o says where --new NAME"),
        ("--new foo stress_relaxation", "--new writes a template and nothing else"),
    ],
)
def test_options_of_effects_that_nothing_has_a_use_for(tmp_path, monkeypatch, capsys, words, match):
    monkeypatch.chdir(tmp_path)
    assert match in refused(capsys, "effects", *words.split())
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "words", ["diagnose a.csv --repeat", "propose a.csv -o b.py --laws", "investigate pes -o i --repeat"]
)
@pytest.mark.parametrize("number", ["0", "-1", "1.5", "x", ""])
def test_a_count_is_a_whole_number_from_1(capsys, words, number):
    with pytest.raises(SystemExit, match="2"):
        main([*words.split(), number])
    assert re.search(r"must be a whole number, 1 or more, got|expected one argument", capsys.readouterr().err)
