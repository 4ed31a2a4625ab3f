"""The first lines of Python that a reader meets, those of README (the first page shows them), run as they stand."""

from __future__ import annotations

import re
import textwrap
from pathlib import Path

import matplotlib as mpl
import pytest

import testbench as tb

mpl.use("Agg")
ROOT = Path(__file__).parents[2]
README = re.findall(r"(?:^    .*\n|^\n)+", (ROOT / "README.md").read_text(encoding="utf-8"), re.MULTILINE)
FIRST = next(textwrap.dedent(block) for block in README if "import gcode" in block)


@pytest.mark.slow
def test_the_first_lines_run_and_show_themselves(tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    for seed, name in ((1, "a.csv"), (2, "b.csv")):
        recording = tb.example(tb.effects.StressRelaxation(fraction=0.3), seed=seed, duration_s=90)
        recording.to_frame().to_csv(name, index=False)
    names: dict = {}
    exec(FIRST, names)
    found = names["found"]
    assert found.effect == "stress_relaxation"
    assert next(iter(found.probabilities)) == "stress_relaxation"
    assert names["where"].words
    for result in (names["rec"], names["fit"], names["where"], found, found.ladder, names["sim"]):
        assert "<" in result._repr_html_()
        assert len(result.to_frame()) > 0
        assert result.to_dict()
        assert result.plot() is not None
    mpl.pyplot.close("all")
