"""What is there already is not lost to what a command writes: recordings, files that are read, protected ones."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest
from attack_commands import an_ordinary_user

import gcode.cli
import testbench.cli
from tests.testbench.builders import record, truth, write_csv
from tests.testbench.rig.rigs import program


def called(words: str | list[str]) -> int:
    """The exit code of a command."""
    package, *rest = words.split() if isinstance(words, str) else words
    return {"gcode": gcode.cli, "testbench": testbench.cli}[package].main(rest)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("there")
    for name in ("a.csv", "b.csv"):
        write_csv(record(truth(), 30), folder / name)
    wish = shutil.copy(program(folder), folder / "program.tap")
    assert called(f"testbench run --sensor pes --program {wish} --gauge-length-mm 25 -o {folder / 'campaign'}") == 0
    assert called(f"testbench fit {folder / 'a.csv'} --gauge-length-mm 25 -o {folder / 'model.json'}") == 0
    return folder


@pytest.fixture
def place(made, tmp_path, monkeypatch):
    """Two bare recordings, a campaign, a model and a program, in the folder that commands are started in."""
    shutil.copytree(made, tmp_path / "place")
    monkeypatch.chdir(tmp_path / "place")
    return tmp_path / "place"


def contents(folder: Path) -> dict[Path, bytes]:
    """Every file and what is in it."""
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize(
    ("words", "why"),
    [
        ("testbench fit a.csv --gauge-length-mm 25 -o a.csv", "is read, and would be written over"),
        ("testbench fit a.csv --gauge-length-mm 25 -o ./link.csv", "is read, and would be written over"),
        ("testbench fit a.csv --gauge-length-mm 25 -o b.csv", "a recording is there"),
        ("testbench fit a.csv --gauge-length-mm 25 -o campaign/recording.csv", "a recording is there, or a part of"),
        ("testbench fit a.csv --gauge-length-mm 25 -o campaign/datapackage.json", "a recording is there"),
        ("testbench diagnose a.csv --gauge-length-mm 25 --json x -o ./x", "would be written twice"),
        ("testbench diagnose a.csv --gauge-length-mm 25 --model model.json --json model.json", "written over"),
        ("testbench report --recording campaign --figures f -o campaign/events.jsonl", "a recording is there"),
        ("testbench import a.csv --gauge-length-mm 25 -o b.csv", "a recording is there"),
        ("testbench import a.csv --gauge-length-mm 25 --overwrite -o campaign/recording.csv", "a recording is there"),
        ("testbench hide --minutes 1 -o x\0", "a zero byte"),
        ("testbench fit a.csv --gauge-length-mm 25 -o=--", "-- is no value"),
        ("testbench fit a.csv --gauge-length-mm 25 --output=--", "-- is no value"),
        (
            "gcode generate --preset paper-1 --seed 1 --duration-s 20 --gauge-length-mm 25 -o campaign",
            "a recording is there",
        ),
        ("gcode play program.tap -o campaign/program.tap", "a recording is there"),
        ("gcode play program.tap -o other.TAP", "has the name of a program, and a table is written"),
        ("gcode play program.tap -o program.tap", "is read, and would be written over"),
    ],
)
def test_what_was_recorded_is_kept(place, capsys, words, why):
    (place / "link.csv").symlink_to(place / "a.csv")
    before = contents(place)
    assert called(words) == 2
    assert why in capsys.readouterr().err
    assert contents(place) == before


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("bom.csv", "\ufefftime_s,force_N\n0,1\n"),
        ("quoted.csv", '"time_s","force_N"\n0,1\n'),
        ("blanks.csv", "time_s, force_N\n0,1\n"),
        ("time_last.csv", "cycle,force_N,time_s\n1,1,0\n"),
        ("text.txt", "time_s;force_N\n0;1\n"),
        ("tester.csv", "Zeit [s];Kraft [mN]\n0;1\n"),
        ("position.csv", "time_s,position_mm,force_N\n0,1,1\n"),
        ("by_hand.tap", "G21\nG1 X1 F60\n"),
    ],
)
def test_data_and_programs_of_others_are_kept(place, capsys, name, text):
    (place / name).write_text(text, encoding="utf-8")
    assert called(f"gcode play program.tap -o {name}") == 2
    assert "choose another place" in capsys.readouterr().err
    assert (place / name).read_text(encoding="utf-8") == text


def test_what_a_command_wrote_it_may_write_again(place):
    predicted = "time_s,force_N,low_N,high_N,status\n0,1,1,1,0\n"
    for name, text in (("predicted.csv", predicted), ("empty.csv", ""), ("new.csv", "time_s,position_mm\n0,1\n")):
        (place / name).write_text(text)
        for _ in range(2):
            assert called(f"gcode play program.tap -o {name}") == 0


def test_an_imported_file_is_replaced_only_where_that_is_said(place, capsys):
    words = "testbench import a.csv --gauge-length-mm 25 -o again.csv"
    (place / "again.csv").write_text("time_s,position_mm\n0,1\n")
    assert called(words) == 2
    assert "is there; choose another place, or give --overwrite" in capsys.readouterr().err
    for _ in range(2):
        assert called(f"{words} --overwrite") == 0


def test_a_model_may_take_the_place_of_the_one_it_came_from(place):
    assert called("testbench fit a.csv --gauge-length-mm 25 --model model.json -o model.json") == 0


def test_a_protected_file_is_kept(place, capsys):
    (place / "model.json").chmod(0o444)
    with an_ordinary_user():
        assert called("testbench fit a.csv --gauge-length-mm 25 -o model.json") == 2
    assert "it is write-protected" in capsys.readouterr().err


@pytest.mark.parametrize("name", [os.fsdecode(b"\xff.csv"), "\x1b[31m.csv"])
def test_a_name_that_is_no_text_is_shown_as_one(place, capsys, name):
    shutil.copy("a.csv", name)
    assert called(["testbench", "report", "--recording", name, "--gauge-length-mm", "25", "-o", "report.html"]) == 0
    assert called(["testbench", "fit", name, "--gauge-length-mm", "25", "-o", f"{name}.json"]) == 0
    assert "\x1b" not in capsys.readouterr().out
