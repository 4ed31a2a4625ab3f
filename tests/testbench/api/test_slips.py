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
    "a force of another name and unit": (
        lambda: tb.read(pd.DataFrame(TIMES | {"Force (kN)": [0, 1, 2]}), 25),
        "column 'Force (kN)' is not taken for the force; call it force_N, in N, or leave it out",
    ),
    "dates for times": (
        lambda: tb.read(pd.DataFrame(TIMES | {"time_s": pd.to_datetime([0, 1, 2], unit="s")}), 25),
        "read: time_s must be numbers, got dates or durations (datetime64[",
    ),
    "a number as text": (lambda: tb.diagnose(tb.example(duration_s=20), most="2"), "got '2'"),
    "half a law": (
        lambda: tb.propose("a.csv", most=1.5),
        "most: laws to find must be a whole number, 1 or more, got 1.5",
    ),
    "a seed as text": (
        lambda: tb.simulate("pes", gcode.generate("paper-1", seed=1, duration_s=20), seed="a"),
        "seed: must be a whole number, 0 or more, got 'a'",
    ),
    "a seed as text, to hide": (
        lambda: tb.hide("none", "case", seed="a"),
        "must be a whole number, 0 or more, got 'a'",
    ),
    "a channel without its unit": (lambda: tb.hide("none", "case", seed=1, channels="force"), "got ['force']"),
    "a trajectory for a program": (
        lambda: tb.simulate("pes", gcode.generate("paper-1", seed=1, duration_s=20).trajectory),
        "program: must be what gcode.generate made, or the path of one, got Trajectory",
    ),
    "play as text": (
        lambda: tb.fit(tb.example(duration_s=20), tb.example(seed=2, duration_s=20), clamp_play_mm="0.1"),
        "clamp play: must be from 0 to 2.5 mm (10% of the gauge length), got '0.1'",
    ),
    "a diagnosis that is none": (
        lambda: tb.contribution({}, "stress_relaxation", tb.example(duration_s=20)),
        "diagnosis: ",
    ),
    "a wish as a mapping": (
        lambda: tb.import_file("a.csv", {"gauge_length_mm": 25}),
        "wish: must be a testbench.Wish, got dict",
    ),
    "a data frame to report on": (
        lambda: tb.make_report(tb.example(duration_s=20).to_frame()),
        "got DataFrame; testbench.read makes a Recording of a data frame",
    ),
    "a report under the name of a picture": (
        lambda: tb.make_report(tb.example(duration_s=20)).write("a.pdf"),
        "a.pdf: a report as html ends in .html or .htm; give another name",
    ),
    "a page under the name of Markdown": (
        lambda: tb.make_report(tb.example(duration_s=20)).write("a.md"),
        "write it as md, or give another name",
    ),
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
