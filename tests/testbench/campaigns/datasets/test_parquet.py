"""A data set as Parquet and Croissant: what tools that never heard of us load is what was recorded."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gcode.support.errors import UserError
from testbench.api.files.verifying import verify
from testbench.campaigns.datasets import parquet
from testbench.campaigns.datasets.dataset import drop_stale_parquet, make, write_index, write_parquet
from testbench.campaigns.datasets.parquet_checksums import CHECKSUMS, parquet_problems
from testbench.campaigns.datasets.splits import SPLITS, split_of
from testbench.campaigns.datasets.tasks import Task
from testbench.knit.catalogue import baseline
from testbench.knit.model import KnitModel
from testbench.recordings.files import read_recording
from testbench.recordings.instruments import Instruments
from testbench.recordings.manifest import NAME
from tests.testbench.rig.rigs import program

pytest.importorskip("pyarrow", reason="Parquet needs pyarrow")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Three specimens with two campaigns each, as Parquet."""
    out = tmp_path_factory.mktemp("knits")
    path, model, tools = program(out), baseline().to_dict(), Instruments()
    tasks = [
        Task(out / f"s{specimen}-{seed}", path, f"s{specimen}", model, 25.0, seed, tools, specimen=f"s{specimen}")
        for specimen in range(3)
        for seed in range(2)
    ]
    for task in tasks:
        make(task)
    assert write_parquet(out, tasks, workers=1) == 6
    return out, tasks


def test_a_specimen_is_in_one_split_only_and_each_split_has_one():
    names = [f"pes@{number}" for number in range(40)]
    splits = split_of(names * 3)
    counts = {split: list(splits.values()).count(split) for split in SPLITS}
    assert counts["train"] >= 26
    assert counts["validation"] >= 1
    assert counts["test"] >= 1
    assert split_of(reversed(names)) == splits
    assert set(split_of(["a", "b", "c"]).values()) == set(SPLITS)
    assert split_of(["a", "b"]) == {"a": "train", "b": "train"}


@given(st.integers(0, 1_000), st.integers(12, 60), st.integers(1, 60))
def test_what_was_trained_with_is_never_held_out_when_a_data_set_grows(sensor, count, more):
    """A score on it would be of what the network knows. Of fewer than a dozen all hashes may be low."""
    names = [f"s{sensor}@{number}" for number in range(count + more)]
    before, after = split_of(names[:count]), split_of(names)
    assert {after[name] for name, split in before.items() if split == "train"} == {"train"}


def test_about_a_tenth_is_held_out_for_each():
    splits = list(split_of(f"pes@{number}" for number in range(5_000)).values())
    assert splits.count("test") == pytest.approx(500, abs=60)
    assert splits.count("validation") == pytest.approx(500, abs=60)


def test_pandas_reads_back_every_sample(made):
    import pandas as pd

    out, tasks = made
    frame = pd.read_parquet(out / "parquet")
    assert frame.campaign.nunique() == len(tasks)
    for task in tasks:
        recording, mine = read_recording(task.folder), frame[frame.campaign == task.folder.name]
        assert np.array_equal(mine.time_s, recording.time_s)
        assert np.array_equal(mine.resistance_ohm, recording["resistance_ohm"])
        assert set(mine.specimen) == {task.specimen}


def test_sensors_of_fewer_channels_leave_theirs_to_the_others(tmp_path):
    import pandas as pd

    path, tools = program(tmp_path), Instruments()
    model = baseline()
    of_force = KnitModel({name: effect for name, effect in model.effects.items() if "force_N" in effect.writes})
    tasks = [
        Task(tmp_path / name, path, name, one.to_dict(), 25.0, 1, tools, specimen=name)
        for name, one in (("force", of_force), ("both", model))
    ]
    for task in tasks:
        make(task)
    write_parquet(tmp_path, tasks, workers=1)
    frame = pd.read_parquet(tmp_path / "parquet")
    assert frame.resistance_ohm.isna().groupby(frame.campaign).mean().to_dict() == {"both": 0.0, "force": 1.0}
    described = json.loads((tmp_path / "croissant.json").read_text())["recordSet"][0]["field"]
    assert any(one["name"] == "resistance_ohm" for one in described)


def test_what_was_changed_or_broken_is_written_anew_and_what_is_stale_goes(made):
    out, tasks = made
    files = sorted((out / "parquet").rglob("*.parquet"))
    before = [file.read_bytes() for file in files]
    stale = out / "parquet" / "train" / "old.parquet"
    stale.write_bytes(b"")
    files[0].write_bytes(b"no Parquet")
    middle = len(before[1]) // 2
    files[1].write_bytes(before[1][:middle] + bytes([before[1][middle] ^ 1]) + before[1][middle + 1 :])
    write_parquet(out, tasks, workers=1)
    assert not stale.exists()
    assert [file.read_bytes() for file in files] == before


def test_what_is_there_is_not_written_again(made, tmp_path):
    """Every file was written anew by each run, though the page of data sets says that a run resumes."""
    out = tmp_path / "d"
    shutil.copytree(made[0], out)
    tasks = [replace(task, folder=out / task.folder.name) for task in made[1]]
    files = sorted((out / "parquet").rglob("*.parquet"))
    before = [file.stat().st_mtime_ns for file in files]
    assert write_parquet(out, tasks, workers=1) == 0
    assert [file.stat().st_mtime_ns for file in files] == before
    make(replace(next(task for task in tasks if task.folder.name == files[2].stem), seed=9))
    files[4].unlink()
    assert write_parquet(out, tasks, workers=1) == 2
    now = [file.stat().st_mtime_ns for file in files]
    assert [one == other for one, other in zip(before, now, strict=True)] == [True, True, False, True, False, True]
    assert not parquet_problems(out)


def test_a_specimen_of_another_name_and_a_broken_list_are_written_anew(made, tmp_path):
    import pandas as pd

    out = tmp_path / "d"
    shutil.copytree(made[0], out)
    tasks = [replace(task, folder=out / task.folder.name, specimen=f"{task.specimen}#1") for task in made[1]]
    write_parquet(out, tasks, workers=1)
    assert set(pd.read_parquet(out / "parquet").specimen) == {"s0#1", "s1#1", "s2#1"}
    (out / CHECKSUMS).write_text("{", encoding="utf-8")
    write_parquet(out, tasks, workers=1)
    assert not parquet_problems(out)


def test_what_was_written_before_a_break_is_not_written_again(made, tmp_path, monkeypatch):
    out = tmp_path / "d"
    shutil.copytree(made[0], out)
    tasks = [replace(task, folder=out / task.folder.name) for task in made[1]]
    shutil.rmtree(out / "parquet")
    (out / CHECKSUMS).unlink()
    write, broken = parquet.write_part, tasks[3].folder
    monkeypatch.setattr(
        parquet, "write_part", lambda part, channels: write(part, channels) if part.campaign != broken else 1 / 0
    )
    with pytest.raises(ZeroDivisionError):
        write_parquet(out, tasks, workers=1)
    there = {file: file.stat().st_mtime_ns for file in (out / "parquet").rglob("*.parquet")}
    assert len(there) == 3
    monkeypatch.undo()
    write_parquet(out, tasks, workers=1)
    assert {file: file.stat().st_mtime_ns for file in there} == there
    assert not parquet_problems(out)


def test_nothing_is_written_or_removed_through_a_link(made, tmp_path):
    out, tasks = made
    (tmp_path / "train").mkdir()
    (tmp_path / "train" / "theirs.parquet").write_bytes(b"theirs")
    place = out / "parquet"
    place.rename(out / "kept")
    try:
        place.symlink_to(tmp_path)
        with pytest.raises(UserError, match="is a link"):
            write_parquet(out, tasks, workers=1)
    finally:
        place.unlink()
        (out / "kept").rename(place)
    assert [path.read_bytes() for path in (tmp_path / "train").iterdir()] == [b"theirs"]


def test_verify_finds_what_is_wrong_with_parquet_files(made, tmp_path, caplog):
    out = tmp_path / "d"
    shutil.copytree(made[0], out)
    (tmp_path / "d.toml").write_text('sensors = ["s0"]', encoding="utf-8")
    write_index(out, tmp_path / "d.toml", [replace(task, folder=out / task.folder.name) for task in made[1]])
    assert verify(out).intact
    first, second, *_ = sorted((out / "parquet").glob("*/*.parquet"))
    first.write_bytes(first.read_bytes()[:-1] + b"x")
    second.rename(second.with_name("other.parquet"))
    wrong = "\n".join(verify(out).problems)
    assert f"{first.name}: its checksum is another; write them anew" in wrong
    assert f"{second.name}: missing" in wrong
    assert "other.parquet: parquet-checksums.json does not list it" in wrong
    (out / CHECKSUMS).unlink()
    assert verify(out).intact
    assert "parquet: not verified, these files carry no checksum" in caplog.text


def test_parquet_files_of_campaigns_that_are_others_now_do_not_stay(made, tmp_path):
    """They would be loaded as if they were of the data set."""
    out = tmp_path / "d"
    shutil.copytree(made[0], out)
    tasks = [replace(task, folder=out / task.folder.name) for task in made[1]]
    assert drop_stale_parquet(out, tasks) == 0
    changed = tasks[0].folder / NAME
    changed.write_bytes(changed.read_bytes() + b" ")
    assert drop_stale_parquet(out, tasks[:-1]) == 2
    kept = {path.stem for path in (out / "parquet").glob("*/*.parquet")}
    assert kept == {task.folder.name for task in tasks[1:-1]}
    assert not (out / "croissant.json").exists()


@pytest.mark.filterwarnings("ignore")  # of the libraries that mlcroissant uses
def test_croissant_is_valid_and_loads_the_samples_of_a_split(made):
    mlcroissant = pytest.importorskip("mlcroissant", reason="Croissant is validated by mlcroissant")
    out, tasks = made
    data = mlcroissant.Dataset(jsonld=str(out / "croissant.json"))
    assert not data.metadata.ctx.issues.errors
    records = list(data.records(record_set="test"))
    split = split_of(task.specimen for task in tasks)
    folders = sorted(task.folder for task in tasks if split[task.specimen] == "test")
    forces = np.concatenate([read_recording(folder)["force_N"] for folder in folders])
    assert sorted(record["test/force_N"] for record in records) == pytest.approx(sorted(forces))
    assert {record["test/campaign"].decode() for record in records} == {folder.name for folder in folders}


def test_croissant_says_the_units(made):
    out, _ = made
    fields = json.loads((out / "croissant.json").read_text())["recordSet"][0]["field"]
    told = {field["name"]: field["description"] for field in fields}
    assert told["displacement_mm"] == "displacement_mm, in mm"
    assert told["resistance_ohm"] == "resistance_ohm, in ohm"
