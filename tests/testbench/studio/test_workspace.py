"""The workspace: what it lists, what it refuses, what it keeps."""

from __future__ import annotations

import itertools
import shutil
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

import tests.testbench.report.samples as samples
from gcode.support.errors import UserError
from testbench.cli import main
from testbench.recordings.files import write_recording_csv
from testbench.studio import workspace
from testbench.studio.studio import Studio
from testbench.studio.workspace import Workspace


def test_campaigns_are_found_and_described(studio: Studio) -> None:
    found = studio.workspace.campaigns()
    assert [campaign.name for campaign in found] == ["sleeve"]
    assert found[0].origin == "imported"
    assert found[0].gauge_length_mm == 25.0
    assert found[0].columns == {"time_s", "displacement_mm", "force_N", "resistance_ohm"}
    assert studio.workspace.problems("sleeve") == []


def test_a_flipped_byte_is_found_though_the_answer_was_kept(studio: Studio) -> None:
    assert studio.workspace.problems("sleeve") == []
    path = studio.workspace.campaign("sleeve").folder / "recording.csv"
    raw = bytearray(path.read_bytes())
    raw[-5] ^= 1
    path.write_bytes(bytes(raw))
    assert "checksum differs" in studio.workspace.problems("sleeve")[0]


def test_two_who_ask_at_once_share_one_reading(studio: Studio, monkeypatch: pytest.MonkeyPatch) -> None:
    read: list[str] = []
    true = workspace.read_json

    def counted(path: str, *more: object) -> object:
        read.append(str(path))
        return true(path, *more)

    monkeypatch.setattr(workspace, "read_json", counted)
    fresh = Workspace(studio.workspace.root)
    with ThreadPoolExecutor(4) as pool:
        lists = [asked.result() for asked in [pool.submit(fresh.campaigns) for _ in range(4)]]
    assert [[one.name for one in found] for found in lists] == [["sleeve"]] * 4
    assert len(read) == 1


def test_a_foreign_manifest_is_listed_not_thrown(studio: Studio) -> None:
    folder = studio.workspace.root / "other"
    folder.mkdir()
    (folder / "datapackage.json").write_text("[]")
    assert {campaign.name: campaign.gauge_length_mm for campaign in studio.workspace.campaigns()}["other"] is None
    assert studio.workspace.problems("other")


def test_a_recording_is_read_once_until_its_file_changes(studio: Studio) -> None:
    first = studio.workspace.recording("sleeve")
    assert studio.workspace.recording("sleeve") is first
    lab = studio.workspace.root / "lab.csv"
    write_recording_csv(lab, samples.recording(2000))
    columns = ["--time", "time_s", "--displacement", "displacement_mm", "--gauge-length-mm", "25", "--overwrite"]
    assert main(["import", str(lab), *columns, "-o", str(studio.workspace.root / "sleeve")]) == 0
    assert len(studio.workspace.recording("sleeve")) == 2000


def test_a_manifest_that_is_changed_later_is_refused_though_the_recording_was_kept(studio: Studio) -> None:
    studio.workspace.recording("sleeve")
    path = studio.workspace.root / "sleeve" / "datapackage.json"
    path.write_text(path.read_text().replace('"gauge_length_mm": 25.0', '"gauge_length_mm": 35.0'))
    with pytest.raises(UserError, match="changed since it was written"):
        studio.workspace.recording("sleeve")


@pytest.mark.parametrize("name", ["../..", "absent", "sleeve/../../x", "/etc", "a\0b", "a" * 300])
def test_names_cannot_leave_the_workspace(studio: Studio, name: str) -> None:
    with pytest.raises(UserError, match="no campaign"):
        studio.workspace.campaign(name)


@pytest.mark.parametrize("name", ["", "  ", "..", "../x", "sleeve", "a\0b"])
def test_new_campaigns_need_a_free_name_inside(studio: Studio, name: str) -> None:
    with pytest.raises(UserError, match=r"needs a name that is a folder inside|name is taken"):
        studio.workspace.free_name(name)


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("results/x", "the studio keeps its own things under 'results'"),
        ("deleted", "keeps its own things"),
        ("running", "keeps its own things"),
        ("rig", "keeps its own things"),
        ("notes.json", "keeps its own things"),
        (".hid", "hidden, and the list would not show it"),
        ("a/.hid", "hidden, and the list would not show it"),
        ("1/2/3/4/5", "at most 4 folders deep, and this would be 5"),
        ("ü" * 128, "longer than the 255 bytes"),
        ("/".join(["a" * 90] * 3), "too long for the folder of its results"),
    ],
)
def test_names_that_the_studio_cannot_handle_are_refused_with_words(studio: Studio, name: str, why: str) -> None:
    with pytest.raises(UserError, match=why):
        studio.workspace.free_name(name)


def test_the_longest_name_can_be_made_deleted_and_brought_back(studio: Studio) -> None:
    name = f"a/{'b' * 200}"
    folder = studio.workspace.free_name(name)
    shutil.copytree(studio.workspace.root / "sleeve", folder)
    studio.make_results(f"model:{name}")
    studio.deleted.restore(studio.deleted.add(name))
    assert studio.workspace.campaign(name).folder == folder


def test_no_two_campaigns_share_their_results() -> None:
    assert workspace.results_name("a-b_c.1") == "a-b_c.1"
    assert workspace.results_name("a/b") == "a__b", "as they have always been"
    parts = ["a", "_", "/", "%", "%5F", "b"]
    names = {"".join(some) for some in itertools.product(parts, repeat=5)}
    names = {name for name in names if "//" not in name and not name.startswith("/") and not name.endswith("/")}
    assert len({workspace.results_name(name) for name in names}) == len(names)


def test_a_file_or_a_slip_of_the_name_is_no_workspace(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(UserError, match="works in a folder, and this is a file"):
        Workspace(tmp_path / "file")
    with pytest.raises(UserError, match="slip: the studio works in a folder, and there is none; make it first"):
        Workspace(tmp_path / "slip")
    assert not (tmp_path / "slip").exists()
