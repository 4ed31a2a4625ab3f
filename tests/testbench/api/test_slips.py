"""What a person is likely to pass by mistake in Python is refused in one sentence that says what is wanted."""

from __future__ import annotations

import re

import pandas as pd
import pytest

import gcode
import testbench as tb

TIMES = {"time_s": [0, 1, 2], "displacement_mm": [0, 1, 0]}
SLIPS = {
    "a list": (lambda: tb.read([1, 2]), "must be a path, a data frame or a mapping of columns, got list"),
    "commas in numbers": (
        lambda: tb.read(pd.DataFrame(TIMES | {"force_N": ["1,5", "2,0", "1,5"]}), 25),
        "read: force_N must be numbers, could not convert string to float: '1,5'",
    ),
    "a table in a column": (
        lambda: tb.read(TIMES | {"force_N": [[0, 1, 2]]}, 25),
        "got shape (1, 3)",
    ),
    "a length as text": (
        lambda: tb.read(TIMES | {"force_N": [0, 1, 2]}, "25"),
        "got '25' (str)",
    ),
    "an effect by its name": (
        lambda: tb.baseline() + "stress_relaxation",
        "must be an effect",
    ),
    "an effect where its name is wanted": (
        lambda: tb.add(tb.baseline(), tb.effects.StressRelaxation(), "a.csv"),
        "effect: must be a name such as 'stress_relaxation', got StressRelaxation(",
    ),
    "effects by their names": (
        lambda: tb.fit("a.csv", effects=["stress_relaxation"]),
        "effects: must be a file, or classes of your own effects, got 'stress_relaxation'",
    ),
    "effects that are none": (lambda: tb.fit("a.csv", effects=7), "classes of your own effects, got 7"),
    "a number for a file": (lambda: gcode.read(5), "got int, not the path of a program"),
    "a program that was not written": (
        lambda: tb.record("/dev/no-port", gcode.generate("paper-1", seed=1, duration_s=20), "knit"),
        "got Made, not the path of a program",
    ),
}


@pytest.mark.parametrize("slip", SLIPS)
def test_a_slip_is_refused_in_a_sentence(slip, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    call, said = SLIPS[slip]
    with pytest.raises(tb.UserError, match=re.escape(said)):
        call()


def test_a_coordinate_that_is_none_is_refused_with_those_there_are():
    recording = tb.example(duration_s=60)
    with pytest.raises(tb.UserError, match=r"coordinate must be one of strain, .*; got 'speed'"):
        tb.compare(recording, tb.baseline()).plot(coordinate="speed")
