"""A data set as Parquet and Croissant: what tools that never heard of us load is what was recorded."""

from __future__ import annotations

import json

import numpy as np
import pytest

from testbench.campaigns.dataset import make, write_parquet
from testbench.campaigns.dataset_tasks import Task
from testbench.campaigns.splits import SPLITS, split_of
from testbench.knit.catalogue import baseline
from testbench.recordings.files import read_recording
from testbench.recordings.instruments import Instruments
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
    assert counts == {"train": 32, "validation": 4, "test": 4}
    assert split_of(reversed(names)) == splits
    assert set(split_of(["a", "b", "c"]).values()) == set(SPLITS)
    assert split_of(["a", "b"]) == {"a": "train", "b": "train"}


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


def test_what_is_there_is_not_written_again_and_what_is_stale_goes(made):
    out, tasks = made
    stale = out / "parquet" / "train" / "old.parquet"
    stale.write_bytes(b"")
    assert write_parquet(out, tasks, workers=1) == 0
    assert not stale.exists()
    (out / "parquet").joinpath(*_file(out, tasks[0])).unlink()
    assert write_parquet(out, tasks, workers=1) == 1


def _file(out, task) -> tuple[str, str]:
    split = split_of(f"s{number}" for number in range(3))[task.specimen]
    return split, f"{task.folder.name}.parquet"


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
