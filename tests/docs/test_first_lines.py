"""The first lines of Python that a reader meets, in README and on the first page, run as they stand there."""

from __future__ import annotations

import ast
import re
import textwrap
from pathlib import Path

import matplotlib as mpl
import pytest

import testbench as tb

mpl.use("Agg")
ROOT = Path(__file__).parents[2]
README = re.findall(r"(?:^    .*\n|^\n)+", (ROOT / "README.md").read_text(encoding="utf-8"), re.MULTILINE)
PAGE = re.findall(r"```python\n(.*?)```", (ROOT / "docs" / "index.md").read_text(encoding="utf-8"), re.DOTALL)
BLOCKS = {
    "README.md": next(textwrap.dedent(block) for block in README if "import gcode" in block),
    "docs/index.md": PAGE[0],
}


def assigned(text: str) -> dict[str, str]:
    """What each name stands for, as written, where a line gives one thing one name."""
    lines = [line for line in ast.parse(text).body if isinstance(line, ast.Assign)]
    return {ast.unparse(line.targets[0]): ast.unparse(line.value) for line in lines}


def test_both_pages_make_the_same_of_the_same_names() -> None:
    readme, page = (assigned(BLOCKS[where]) for where in ("README.md", "docs/index.md"))
    both = readme.keys() & page.keys()
    assert {"fit", "where", "model", "sim"} <= both
    assert {name: readme[name] for name in both} == {name: page[name] for name in both}


@pytest.mark.slow
@pytest.mark.parametrize("where", BLOCKS)
def test_the_first_lines_run_and_show_themselves(where, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    for seed, name in ((1, "a.csv"), (2, "b.csv")):
        recording = tb.example(tb.effects.StressRelaxation(fraction=0.3), seed=seed, duration_s=90)
        recording.to_frame().to_csv(name, index=False)
    names: dict = {}
    exec(BLOCKS[where], names)
    found = names["found" if "found" in names else "d"]
    assert found.effect == "stress_relaxation"
    assert next(iter(found.probabilities)) == "stress_relaxation"
    assert names["where"].words
    for result in (names["rec"], names["fit"], names["where"], found, found.ladder, names["sim"]):
        assert "<" in result._repr_html_()
        assert len(result.to_frame()) > 0
        assert result.to_dict()
        assert result.plot() is not None
    mpl.pyplot.close("all")
