"""A type checker without any plugin takes what the documentation shows, and knows what comes out of it."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from mypy import api

ROOT = Path(__file__).parents[3]
SCRIPT = """
import gcode
import testbench as tb

class Mine(tb.Effect):
    name = "mine"

recording = tb.read("a.csv", gauge_length_mm=25)
fit = tb.fit(recording, effects=Mine)
model = fit.model + tb.effects.StressRelaxation(fraction=0.2)
pieces = gcode.Hold(duration_s=5) + gcode.Noise(duration_s=600)
slow = gcode.Limits(v_max_mm_per_s=0.5)
simulated = tb.simulate(model, gcode.generate(pieces, seed=3), instruments=tb.Instruments())
reveal_type(model)
reveal_type(tb.effects.StressRelaxation)
reveal_type(simulated)
"""


@pytest.mark.slow
def test_a_script_of_a_user_passes_a_type_checker_without_plugins(tmp_path, monkeypatch):
    monkeypatch.setenv("MYPYPATH", str(ROOT))
    script = tmp_path / "script.py"
    script.write_text(SCRIPT)
    words = ["--config-file=", "--cache-dir", str(tmp_path / "cache"), "--follow-imports", "silent"]
    said, _, code = api.run([*words, "--ignore-missing-imports", str(script)])
    assert code == 0, said
    known = re.findall(r'Revealed type is "(.*)"', said)
    assert [name.rpartition(".")[2] for name in known] == ["KnitModel", "Effect]", "Recording"]
