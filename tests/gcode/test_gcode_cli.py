"""The commands, from options to files; bad input is one sentence, exit 2 and no file."""

from __future__ import annotations

import json
import re
import subprocess
import sys

import numpy as np
import pytest

import gcode
from gcode.cli import main
from gcode.programs import make
from gcode.trajectories import noise_fit
from gcode.trajectories.trajectory import read_csv

GENERATE = ["generate", "--preset", "paper-1", "--seed", "3", "--gauge-length-mm", "25"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("run")
    assert main([*GENERATE, "--plot", "-o", str(place)]) == 0
    return place


def test_generate_writes_three_files_and_a_picture(folder):
    assert sorted(path.name for path in folder.iterdir()) == [
        "program.tap",
        "trajectory.csv",
        "trajectory.json",
        "trajectory.png",
    ]
    about = json.loads((folder / "trajectory.json").read_text())
    assert about["seed"] == 3
    assert about["spec"]["name"] == "paper-1"
    assert about["statistics"]["v_mean_mm_per_s"] == pytest.approx(0.943, rel=0.03)
    assert (folder / "trajectory.png").read_bytes().startswith(b"\x89PNG")


def test_play_gives_the_planned_positions_on_time(folder, tmp_path, capsys):
    assert main(["play", str(folder / "program.tap"), "-o", str(tmp_path / "e.csv"), "--rate-hz", "20"]) == 0
    executed, planned = read_csv(tmp_path / "e.csv"), read_csv(folder / "trajectory.csv")
    size = min(len(executed.time_s), len(planned.time_s))
    assert np.abs(executed.position_mm[:size] - planned.position_mm[:size]).max() < 0.05
    assert "100 mm/s2" in capsys.readouterr().out


def test_a_controller_without_acceleration_plays_nothing(folder, tmp_path, capsys):
    """It was as if nothing had been said."""
    assert main(["play", str(folder / "program.tap"), "-o", str(tmp_path / "e.csv"), "--acceleration", "0"]) == 2
    assert re.search("error: --acceleration: .*greater than 0", capsys.readouterr().err)


def test_check_tells_good_from_bad(folder, capsys):
    limits = ["--v-max", "4.4", "--a-max", "20", "--x-min", "0", "--x-max", "7.5"]
    assert main(["check", str(folder / "program.tap"), *limits]) == 0
    assert "ok: this program may run" in capsys.readouterr().out
    assert main(["check", str(folder / "program.tap"), *limits[:-1], "5", "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert not found["ok"]
    assert "soft limits" in found["problems"][0]["reason"]


def test_the_program_alone_makes_all_files_again(folder, tmp_path):
    assert main(["generate", "--again", str(folder / "program.tap"), "-o", str(tmp_path)]) == 0
    for name in ("program.tap", "trajectory.csv", "trajectory.json"):
        assert (tmp_path / name).read_bytes() == (folder / name).read_bytes()


@pytest.mark.parametrize("option", ["--seed", "--gauge-length-mm", "--v-max", "--duration-s", "--x-min"])
def test_what_the_header_says_is_not_said_again(folder, tmp_path, capsys, option):
    assert main(["generate", "--again", str(folder / "program.tap"), option, "1", "-o", str(tmp_path / "n")]) == 2
    assert f"as its header says; leave {option} out" in capsys.readouterr().err
    assert not (tmp_path / "n").exists()


def test_a_gauge_length_that_the_target_does_not_suit_is_noted(tmp_path, capsys):
    words = ["generate", "--preset", "paper-1", "--seed", "1", "--gauge-length-mm", "80", "-o", str(tmp_path)]
    assert main(words) == 0
    shown = capsys.readouterr().out
    assert "note: the target is missed" in shown
    assert "note: strain reaches" in shown


@pytest.mark.slow
def test_fit_finds_a_spec_that_generate_takes(tmp_path, capsys):
    wanted = ["--v-mean", "0.6", "--v-sd", "0.38", "--a-mean", "0.9", "--a-sd", "0.85"]
    assert main(["fit", *wanted, "-o", str(tmp_path / "mine.toml")]) == 0
    assert "near: every mean is within 3 %" in capsys.readouterr().out
    run = ["--spec", str(tmp_path / "mine.toml"), "--seed", "9", "--gauge-length-mm", "25"]
    assert main(["generate", *run, "-o", str(tmp_path)]) == 0
    found = json.loads((tmp_path / "trajectory.json").read_text())["statistics"]
    assert found["a_mean_mm_per_s2"] == pytest.approx(0.9, rel=0.04)


@pytest.mark.parametrize(
    ("words", "match"),
    [
        (["--preset", "paper-7", "--seed", "1", "--gauge-length-mm", "25"], "preset must be one of"),
        (["--preset", "paper-1", "--seed", "1"], "--gauge-length-mm"),
        (["--preset", "paper-1", "--seed", "-1", "--gauge-length-mm", "25"], "seed"),
        (["--preset", "paper-1", "--seed", "1", "--gauge-length-mm", "0"], "gauge length"),
        (["--preset", "paper-1", "--seed", "1", "--gauge-length-mm", "nan"], "gauge length"),
        (["--preset", "paper-1", "--seed", "1", "--gauge-length-mm", "25", "--x-max", "5"], "travel"),
        (["--preset", "paper-1", "--seed", "1", "--gauge-length-mm", "25", "--v-max", "-1"], "error: --v-max: "),
        (["--preset", "paper-1", "--seed", "1", "--gauge-length-mm", "25", "--a-max", "nan"], "error: --a-max: "),
        (
            ["--preset", "paper-1", "--seed", "1", "--gauge-length-mm", "25", "--duration-s", "1e9"],
            "error: --duration-s: ",
        ),
        (["--preset", "paper-1", "--seed", "1", "--gauge-length-mm", "25", "--a-max", "0.001"], "a max"),
        (["--spec", "absent.toml", "--seed", "1", "--gauge-length-mm", "25"], "absent.toml"),
        (["--again", "absent.tap"], "absent.tap"),
    ],
)
def test_bad_input_is_one_sentence_and_no_file(words, match, tmp_path, capsys):
    assert main(["generate", *words, "-o", str(tmp_path / "out")]) == 2
    message = capsys.readouterr().err
    assert match in message
    assert message.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_a_folder_that_cannot_be_written_is_refused(tmp_path, capsys):
    (tmp_path / "file").write_text("in the way")
    assert main([*GENERATE, "--duration-s", "100", "-o", str(tmp_path / "file" / "run")]) == 2
    assert "choose another" in capsys.readouterr().err


@pytest.mark.parametrize("content", [b"\xff\xfe\x00binary", None])
def test_an_unreadable_program_is_exit_two(content, tmp_path, capsys):
    path = tmp_path / "program.tap"
    if content is not None:
        path.write_bytes(content)
    assert main(["check", str(path), "--v-max", "5", "--a-max", "20", "--x-min", "0", "--x-max", "9"]) == 2
    assert "program.tap" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("accelerations", "most"),
    [(["--a-mean", "0.2", "--a-sd", "1"], "0.333"), (["--a-mean", "20", "--a-sd", "9"], "12")],
)
def test_accelerations_that_no_noise_has_are_refused_before_they_are_sought(accelerations, most, capsys, monkeypatch):
    """The search took half a minute, and then refused them."""
    monkeypatch.setattr(noise_fit, "_fit_shape", lambda *_: pytest.fail("it was sought"))
    assert main(["fit", "--v-mean", "1", "--v-sd", "0.6", *accelerations]) == 2
    assert f"{most} " in capsys.readouterr().err


@pytest.mark.parametrize("length", ["-3", "nan", "0", "1e9"])
def test_a_spec_is_sought_for_gauge_lengths_only_that_are_planned(length, capsys):
    wanted = ["--v-mean", "1", "--v-sd", "0.6", "--a-mean", "1.4", "--a-sd", "1.3"]
    assert main(["fit", *wanted, "--gauge-length-mm", length]) == 2
    assert "gauge length must be 0.001 to 10000 mm" in capsys.readouterr().err


@pytest.mark.parametrize("lowest", ["-1e-3", "-0.5", "-1", "-.5E+1"])
def test_a_negative_number_is_no_option_however_it_is_written(lowest, capsys):
    assert main([*GENERATE, "--x-min", lowest, "--x-max", "-2e1", "-o", "unused"]) == 2
    assert "--x-min must be below --x-max" in capsys.readouterr().err


def test_a_place_that_cannot_be_written_is_told_before_the_work(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(noise_fit, "fit", lambda *_, **__: pytest.fail("it was sought"))
    monkeypatch.setattr(make, "plan", lambda *_, **__: pytest.fail("it was planned"))
    (tmp_path / "file").write_text("a file is no folder")
    (tmp_path / "folder" / "program.tap").mkdir(parents=True)
    wanted = ["--v-mean", "1", "--v-sd", "1", "--a-mean", "1", "--a-sd", "1"]
    for words, place in (
        (GENERATE, "file"),
        (GENERATE, "file/in-it"),
        (GENERATE, "folder"),
        (["fit", *wanted], "folder"),
        (["fit", *wanted], "no/such/folder.toml"),
    ):
        assert main([*words, "-o", str(tmp_path / place)]) == 2
        assert "cannot write" in capsys.readouterr().err


def test_help_does_not_import_numpy():
    code = "import sys; from gcode.cli import main\ntry: main(['--help'])\nexcept SystemExit: pass\n"
    code += "print('numpy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip().endswith("False")


def test_a_program_with_a_line_that_cannot_be_read_is_not_played_and_is_named(tmp_path, capsys):
    path = tmp_path / "mine.tap"
    path.write_text("G90 G21 G94\nG1 X1 F60\nG1 X[#5]\nG1 X2 F60\nM30\n")
    assert main(["play", str(path), "-o", str(tmp_path / "out.csv")]) == 2
    assert f"{path}: line 3: cannot read" in capsys.readouterr().err
    for program in (path, path.read_text()):
        with pytest.raises(gcode.UserError, match="line 3: cannot read"):
            gcode.play(program)
