"""A place that no file can be written to is refused before the work, and a device is never replaced by a file."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from gcode.support.errors import UserError
from gcode.support.files import check_place, write_text
from testbench.cli import main


@pytest.fixture
def places(tmp_path: Path) -> dict[str, Path]:
    """Each kind of place, by name."""
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    (tmp_path / "folder").mkdir()
    (tmp_path / "link to it").symlink_to(tmp_path / "folder")
    (tmp_path / "file").write_text("old")
    there = {name: tmp_path / name for name in ("pipe", "folder", "link to it", "file")}
    lost = {"nowhere": "no/such", "inside": "file/x", "in a circle": "loop/x"}
    return there | {name: tmp_path / where for name, where in lost.items()}


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("pipe", "a device or a pipe"),
        ("folder", "is a folder"),
        ("link to it", "is a folder"),
        ("nowhere", "its folder does not exist"),
        ("inside", "its folder does not exist"),
        ("in a circle", "cannot write"),
    ],
)
def test_a_place_without_use_is_refused_by_its_name(places, name, said):
    with pytest.raises(UserError, match=said) as refused:
        check_place(places[name])
    assert f"cannot write {places[name]}: " in str(refused.value)


def test_no_place_standard_output_a_file_and_a_new_name_are_let_through(places):
    for place in (None, "-", places["file"], places["file"].with_name("new")):
        check_place(place)


@pytest.mark.parametrize("name", ["pipe", "folder", "link to it"])
def test_what_is_no_file_is_never_replaced(places, name):
    before = places[name].lstat()
    with pytest.raises(UserError, match=r"it is a (device or a pipe|folder); give the name of a file"):
        write_text(places[name], "new")
    assert os.path.samestat(before, places[name].lstat())


@pytest.mark.parametrize(
    "words",
    [
        "fit nothing.csv -o {}",
        "diagnose nothing.csv -o {}",
        "diagnose nothing.csv --json {}",
        "add hysteresis --model nothing.json --fit nothing.csv -o {}",
        "propose nothing.csv -o law.py --json {}",
        "propose nothing.csv -o law.py --save-model {}",
        "propose nothing.csv -o no/such.py",
        "experiment nothing.json nothing.json --json {}",
        "experiment nothing.json nothing.json --plot {}",
        "report --recording nothing.csv -o {}",
        "investigate pes -o folder --json {}",
    ],
)
def test_commands_say_so_before_they_read_anything(words, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(words.format("no/such.json").split()) == 2
    said = capsys.readouterr().err
    assert "its folder does not exist" in said
    assert list(tmp_path.iterdir()) == []
