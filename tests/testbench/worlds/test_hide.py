"""`testbench hide`: recordings in one folder, the truth in another, and no word of it between."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from testbench.api.files import hiding
from testbench.cli import main
from testbench.commands import hide
from testbench.recordings.files import read_recording
from testbench.worlds.base import WORLDS
from testbench.worlds.motions import PROTOCOLS

WORDS = ["hide", "--effect", "clamp_slip", "--seed", "3", "--minutes", "2", "--rate-hz", "20"]


def test_a_case_on_disk(tmp_path: Path, capsys):
    assert main([*WORDS, "-o", str(tmp_path / "case")]) == 0
    recording = read_recording(tmp_path / "case/recordings/calibration.csv", 25.0)
    assert recording.duration_s == pytest.approx(120, rel=0.02)
    truth = json.loads((tmp_path / "case/sealed/truth.json").read_text())
    assert truth["effects"][0]["effect"] == "clamp_slip"
    open_text = capsys.readouterr().out + (tmp_path / "case/README.txt").read_text()
    assert "clamp_slip" not in open_text
    assert "Gauge length: 25 mm" in open_text


def test_the_same_words_write_the_same_bytes(tmp_path: Path):
    for name in ("a", "b"):
        main([*WORDS, "-o", str(tmp_path / name)])
    for file in ("recordings/calibration.csv", "recordings/held_out.csv", "sealed/truth.json"):
        assert (tmp_path / "a" / file).read_bytes() == (tmp_path / "b" / file).read_bytes()


def test_a_folder_in_use_is_left_alone(tmp_path: Path, capsys, monkeypatch):
    monkeypatch.setattr(hiding, "make_case", lambda *_, **__: pytest.fail("the case was made first"))
    (tmp_path / "mine.txt").write_text("notes")
    assert main([*WORDS, "-o", str(tmp_path)]) == 2
    assert "the folder is not empty; choose another" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]


def test_a_bad_request_leaves_no_folder(tmp_path: Path, capsys):
    assert main(["hide", "--world", "flat", "-o", str(tmp_path / "case")]) == 2
    assert "world: must be one of" in capsys.readouterr().err
    assert not (tmp_path / "case").exists()


def test_help_names_every_world_and_motion():
    assert all(world in hide.WORLDS_HELP for world in WORLDS)
    assert all(motion in hide.MOTIONS_HELP for motion in PROTOCOLS)
