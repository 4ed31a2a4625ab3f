"""What docs/datasets.md says of loading a data set is run as it stands there, on a data set of this version."""

from __future__ import annotations

import re
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

import gcode
import testbench as tb

PAGE = Path(__file__).parents[2] / "docs" / "datasets.md"
BLOCKS = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
pytestmark = [
    pytest.mark.skipif(find_spec("pyarrow") is None, reason="Parquet needs pyarrow"),
    pytest.mark.filterwarnings("ignore"),  # of the libraries that load it
]


@pytest.fixture(scope="module")
def frame(tmp_path_factory) -> Any:
    """Every sample of the training split, as it was recorded; the data set lies in the folder ``knits`` below."""
    folder = tmp_path_factory.mktemp("page")
    gcode.generate("paper-1", seed=3, duration_s=20).write(folder)
    sensors = ", ".join(f'"pes@{number}"' for number in range(5))
    (folder / "knits.toml").write_text(f'sensors = [{sensors}]\nprograms = ["*.tap"]\nseeds = [1, 2]\n')
    made = tb.dataset(folder / "knits.toml", folder / "knits", format="parquet", workers=1, progress=False)
    listed = made.to_frame()
    train = listed[listed.split == "train"]
    frames = {name: tb.read(folder / "knits" / name).to_frame() for name in sorted(train.campaign)}
    return folder, frames


def run(frame, monkeypatch, library: str) -> dict[str, Any]:
    """The names that the page's block about a library leaves behind."""
    block = _block(library)
    for module in re.findall(r"^(?:import|from) (\w+)", block, re.MULTILINE):
        if not is_there(module):
            pytest.skip(f"{module} is not among the tests' tools; the page was tried with it")
    monkeypatch.chdir(frame[0])
    monkeypatch.setenv("HF_DATASETS_CACHE", str(frame[0] / "cache"))
    names: dict[str, Any] = {}
    exec(block, names)
    return names


def is_there(module: str) -> bool:
    """Whether a library is installed; the folder ``datasets`` of this repository is none."""
    spec = find_spec(module)
    return spec is not None and spec.origin is not None


def _block(library: str) -> str:
    (block,) = [block for block in BLOCKS if f"import {library}" in block or f"from {library}" in block]
    return block


def samples(frame) -> int:
    return sum(len(one) for one in frame[1].values())


def test_no_library_on_the_page_is_left_out_here():
    assert len(BLOCKS) == len(LIBRARIES)
    assert {_block(library) for library in LIBRARIES} == set(BLOCKS)


def pandas_reads(names, frame) -> None:
    train = names["train"]
    for name, recorded in frame[1].items():
        mine = train[train.campaign == name]
        assert (mine.force_N.to_numpy() == recorded.force_N.to_numpy()).all()
        assert (mine.time_s.to_numpy() == recorded.time_s.to_numpy()).all()
    assert len(train) == samples(frame)


def polars_reads(names, frame) -> None:
    train = names["train"].collect()
    assert train.height == samples(frame)
    assert train["force_N"].sum() == pytest.approx(sum(one.force_N.sum() for one in frame[1].values()))


def datasets_reads(names, frame) -> None:
    assert set(names["data"]) == {"train", "validation", "test"}
    assert names["data"]["train"].num_rows == samples(frame)
    assert set(names["data"]["train"].unique("campaign")) == set(frame[1])


def torch_reads(names, frame) -> None:
    tensors = list(names["train"])
    assert [tuple(one.shape) for one in tensors] == [(len(one), 4) for one in frame[1].values()]
    assert (tensors[0][:, 2].numpy() == next(iter(frame[1].values())).force_N.to_numpy()).all()


def mlcroissant_reads(names, frame) -> None:
    records = list(names["records"])
    assert len(records) == samples(frame)
    assert {one["train/campaign"].decode() for one in records} == set(frame[1])


LIBRARIES = {
    "pandas as pd\n\ntrain": pandas_reads,
    "polars": polars_reads,
    "datasets": datasets_reads,
    "torch": torch_reads,
    "mlcroissant": mlcroissant_reads,
}


@pytest.mark.parametrize("library", LIBRARIES)
def test_the_lines_of_the_page_load_every_sample(library, frame, monkeypatch):
    LIBRARIES[library](run(frame, monkeypatch, library), frame)
