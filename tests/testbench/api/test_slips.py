"""What a person is likely to pass by mistake in Python is refused in one sentence that says what is wanted."""

from __future__ import annotations

import json
import re

import numpy as np
import pandas as pd
import pytest

import gcode
import testbench as tb
from testbench.api.arguments import as_recording

TIMES = {"time_s": [0, 1, 2], "displacement_mm": [0, 1, 0]}
SLIPS = {
    "a list": (lambda: tb.read([1, 2]), "must be a path, a data frame or a mapping of columns, got list"),
    "commas in numbers": (
        lambda: tb.read(pd.DataFrame(TIMES | {"force_N": ["1,5", "2,0", "1,5"]}), 25),
        "read: force_N must be numbers, could not convert string to float: '1,5'",
    ),
    "a number beyond all others": (
        lambda: tb.read(TIMES | {"force_N": [0, 10**400, 2]}, 25),
        "read: force_N must be numbers, int too large to convert to float",
    ),
    "a sample that is masked": (
        lambda: tb.read(TIMES | {"force_N": np.ma.array([0, 1, 2], mask=[False, True, False])}, 25),
        "nan",
    ),
    "a table in a column": (
        lambda: tb.read(TIMES | {"force_N": [[0, 1, 2]]}, 25),
        "got shape (1, 3)",
    ),
    "a length as text": (
        lambda: tb.read(TIMES | {"force_N": [0, 1, 2]}, "25"),
        "got '25' (str)",
    ),
    "a length as text, for a recording that needs none": (
        lambda: tb.read({"time_s": [0, 1], "force_N": [0, 1], "resistance_ohm": [1, 2]}, "25"),
        "got '25' (str)",
    ),
    "no length": (
        lambda: tb.read(TIMES | {"force_N": [0, 1, 2]}),
        "a table does not know its gauge length; give gauge_length_mm",
    ),
    "a load in kN": (
        lambda: tb.read(pd.DataFrame(TIMES | {"load_kN": [0, 1, 2]}), 25),
        "column 'load_kN' is not taken for the force; call it force_N, in N, or leave it out",
    ),
    "one name for two columns": (
        lambda: tb.read(pd.concat([pd.DataFrame(TIMES), pd.DataFrame(TIMES)], axis=1), 25),
        "read: 2 columns are called 'time_s'; name each column once",
    ),
    "a gap as NaN": (
        lambda: tb.read(pd.DataFrame(TIMES | {"force_N": [0, np.nan, 2]}), 25),
        "force_N is nan (1 such row); `testbench import --drop-bad` leaves them out (in a data frame, select the",
    ),
    "a gap, and where a data frame has it": (
        lambda: tb.read(pd.DataFrame(TIMES | {"force_N": [0, 1, np.nan]}), 25),
        "row 2 (counting from 0): force_N is nan",
    ),
    "a time of day, and all columns that there are": (
        lambda: tb.read(pd.DataFrame({"time": ["00:01", "00:02"], "displacement_mm": [0, 1], "cycle": [1, 1]}), 25),
        "read: no column time_s (found: time (text), displacement_mm, cycle)",
    ),
    "a number among remarks": (
        lambda: tb.read(TIMES | {"note": ["a", "1", "b"]}, 25),
        "read: note must be numbers, could not convert string to float: 'a'; convert it, or leave it out",
    ),
    "rows of a recording": (
        lambda: tb.example(duration_s=20)[0:5],
        "no channel slice(0, 5, None); it has displacement_mm",
    ),
    "an example of no length": (lambda: tb.example(duration_s=0), "duration_s must be a number of 1 or more, got 0"),
    "no rate": (lambda: tb.example(duration_s=20).resampled(0), "must be a number of Hz above 0, got 0"),
    "a rate as text": (lambda: tb.example(duration_s=20).resampled("20"), "a number of Hz above 0, got '20'"),
    "every half sample": (lambda: tb.example(duration_s=20).thinned(0.5), "a whole number, 1 or more, got 0.5"),
    "a piece with a field that it has not": (
        lambda: gcode.Triangle(high_percent=20, speed_mm_per_s=1, cycles=3, low=0),
        "Triangle: low: there is no such entry; leave it out, or mend its name, got 0",
    ),
    "a piece that goes nowhere": (
        lambda: gcode.Triangle(high_percent=-20, speed_mm_per_s=1, cycles=3),
        "Triangle: low_percent must be below `high_percent`, got 0 and -20",
    ),
    "a limit as text": (lambda: gcode.Limits(v_max_mm_per_s="fast"), "Limits: v_max_mm_per_s: Input should be"),
    "a length as text, to plan": (
        lambda: gcode.generate("paper-1", seed=1, gauge_length_mm="25", duration_s=20),
        "mm, got '25'",
    ),
    "a seed as text, to plan": (
        lambda: gcode.generate("paper-1", seed="3", duration_s=20),
        "seed must be a whole number from 0 to 9007199254740991, got '3'",
    ),
    "a feed mode that there is not": (
        lambda: gcode.generate("paper-1", seed=1, duration_s=20, feed_mode="G00"),
        "feed_mode must be G94 or G93, got 'G00'",
    ),
    "a list of effects for a model": (
        lambda: tb.KnitModel.of([tb.effects.StressRelaxation()]),
        "model + [StressRelaxation(",
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
    "nothing for a recording": (lambda: tb.read("", 25), "got an empty text, not the path of a recording; name it"),
    "nothing for a campaign": (lambda: tb.verify(""), "got an empty text, not the path of a campaign; name it"),
    "a number for a campaign": (lambda: tb.verify(5), "got int, not the path of a campaign"),
    "a number for a folder": (lambda: gcode.generate("paper-1", seed=1, duration_s=20).write(5), "path of a folder"),
    "a number for the campaigns to make": (lambda: tb.dataset(5, "knits"), "got int, not the path of a TOML file"),
    "a number for a preset": (lambda: tb.preset(5), "preset: must be one of lycra, pes, got 5"),
    "a force of another name and unit": (
        lambda: tb.read(pd.DataFrame(TIMES | {"Force (kN)": [0, 1, 2]}), 25),
        "column 'Force (kN)' is not taken for the force; call it force_N, in N, or leave it out",
    ),
    "impedances for resistances": (
        lambda: tb.read(TIMES | {"force_N": np.array([0, 1j, 2])}, 25),
        "read: force_N must be real numbers, got complex128; convert it, or leave it out",
    ),
    "truths for forces": (lambda: tb.read(TIMES | {"force_N": np.array([True, False, True])}, 25), "got bool"),
    "a list of pieces": (
        lambda: gcode.generate([gcode.Triangle(high_percent=20, cycles=2, speed_mm_per_s=1)], seed=1),
        "a spec or a piece (join pieces with +), got list",
    ),
    "a truth for a seed": (lambda: gcode.generate("paper-1", seed=True, duration_s=20), "whole number from 0"),
    "a recording beside models": (
        lambda: tb.next_experiment([tb.baseline(), tb.preset("pes")], "a.csv"),
        "models are as they were fitted; leave recording and held_out out",
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
    "another gauge length than the recording's": (
        lambda: tb.fit(tb.example(duration_s=20), gauge_length_mm=30),
        "this recording has a gauge length of 25 mm, got 30 mm; leave gauge_length_mm out, or",
    ),
    "another gauge length than that of what follows": (
        lambda: tb.diagnose([tb.example(duration_s=20)] * 2, gauge_length_mm=24),
        "a gauge length of 25 mm, got 24 mm",
    ),
    "another gauge length than a report's recording has": (
        lambda: tb.make_report(tb.example(duration_s=20), gauge_length_mm=30),
        "a gauge length of 25 mm, got 30 mm",
    ),
    "a gauge length as text beside a recording": (
        lambda: tb.align(tb.example(duration_s=20), __file__, gauge_length_mm="25"),
        "the gauge length must be a number of mm, got '25' (str)",
    ),
    "a data frame to hold out of a report": (
        lambda: tb.make_report(tb.example(duration_s=20), held_out=tb.example(duration_s=20).to_frame()),
        "got DataFrame; testbench.read makes a Recording of a data frame",
    ),
    "a rate as text, to play": (
        lambda: gcode.play(gcode.generate("paper-1", seed=1, duration_s=20), rate_hz="a"),
        "rate_hz must be a number, got 'a'",
    ),
    "a rate as text, to check": (
        lambda: gcode.check(gcode.generate("paper-1", seed=1, duration_s=20), rate_hz="a"),
        "rate_hz must be a number, got 'a'",
    ),
    "limits as a mapping": (
        lambda: gcode.check(gcode.generate("paper-1", seed=1, duration_s=20), {"v_max_mm_per_s": 5}),
        "limits must be of the class Limits, got dict; write Limits(**...) around the mapping",
    ),
    "instruments as a mapping": (
        lambda: tb.simulate("pes", gcode.generate("paper-1", seed=1, duration_s=20), instruments={"clock": {}}),
        "instruments must be of the class Instruments, got dict",
    ),
    "a rest as text": (
        lambda: tb.diagnose(tb.example(duration_s=20), rest_s="a"),
        "rest_s must be a number, got 'a'",
    ),
    "a rest as text, to simulate": (
        lambda: tb.simulate("pes", gcode.generate("paper-1", seed=1, duration_s=20), rest_s="a"),
        "rest_s must be a number of 0 or more, got 'a'",
    ),
    "no as a text, which Python takes for yes": (
        lambda: tb.run("pes", gcode.generate("paper-1", seed=1, duration_s=20), "campaign", overwrite="no"),
        "overwrite must be True or False, got 'no'",
    ),
    "no as a text, for an import": (
        lambda: tb.ImportResult(()).write("campaign", overwrite="no"),
        "overwrite must be True or False, got 'no'",
    ),
    "no as a text, for a report": (
        lambda: tb.make_report(tb.example(duration_s=20), resistance="no"),
        "resistance must be True or False, got 'no'",
    ),
    "no as a text, to verify": (
        lambda: tb.verify("campaign", again="no"),
        "again must be True or False, got 'no'",
    ),
    "one campaign where several may be": (
        lambda: tb.simulate("pes", gcode.generate("paper-1", seed=1, duration_s=20), after="pes-1"),
        "after: must be a list of paths of programs or campaigns, got 'pes-1'",
    ),
    "programs that were not written": (
        lambda: tb.simulate("pes", "a.tap", after=[gcode.generate("paper-1", seed=1, duration_s=20)]),
        "after: must be a list of paths of programs or campaigns, got [<Made paper-1",
    ),
    "a machine as a mapping": (
        lambda: gcode.play(gcode.generate("paper-1", seed=1, duration_s=20), machine={"look_ahead_blocks": 2}),
        "machine must be of the class Machine, got dict; write Machine(**...) around the mapping",
    ),
    "a speed as text": (
        lambda: gcode.check("G21 G90 G94\nG0 X1\nM30\n", rapid_mm_per_s="a"),
        "rapid_mm_per_s must be a number, got 'a'",
    ),
    "a share as text": (
        lambda: tb.serve_rig("pes", gcode.generate("paper-1", seed=1, duration_s=20), faults="a"),
        "faults must be a number, got 'a'",
    ),
    "a time as text": (lambda: tb.example(duration_s=20).between("a", 5), "start_s must be a number, got 'a'"),
    "minutes as text": (lambda: tb.hide("none", "case", seed=1, minutes="a"), "minutes must be a number, got 'a'"),
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
    "effects that are no model": (
        lambda: tb.KnitModel([tb.effects.StressRelaxation()]),
        "effects must be a mapping of names to effects, got list; testbench.KnitModel.of(effect, ...) names them",
    ),
    "an effect without its name": (
        lambda: tb.KnitModel({1: tb.effects.StressRelaxation()}),
        "KnitModel: 1 must name an effect",
    ),
    "two effects and no model": (
        lambda: tb.effects.StressRelaxation() + tb.effects.PermanentSet(),
        "effects are put into a model: testbench.baseline() + effect, or testbench.KnitModel.of(effect, effect)",
    ),
    "an effect before its model": (
        lambda: tb.effects.StressRelaxation() + tb.baseline(),
        "effects are put into a model",
    ),
    "parameters as a list": (
        lambda: tb.baseline().with_parameters(["elasticity.stiffness_N"]),
        "with_parameters: must be a mapping of addresses to numbers, got ['elasticity.stiffness_N']",
    ),
    "a parameter by its number": (
        lambda: tb.baseline().with_parameters({1: 2}),
        "parameter 1: must be effect.parameter, or effect.parameter[2] of a vector",
    ),
    "a place that is no number": (
        lambda: tb.baseline().with_parameters({"elasticity.stiffness_N[a]": 2}),
        "parameter 'elasticity.stiffness_N[a]': must be effect.parameter",
    ),
    "a place in what is no vector": (
        lambda: tb.baseline().with_parameters({"elasticity.stiffness_N[0]": 2}),
        "elasticity.stiffness_N has no number [0]; it is 8.0",
    ),
    "a no that is a yes": (lambda: tb.Wish(sort="no"), "sort must be True or False, got 'no'"),
    "half a repeat": (lambda: tb.Wish(repeat=1.5), "repeat must be a whole number, 0 or more, got 1.5"),
    "a row that is a truth": (
        lambda: tb.Hints(header_row=True),
        "`header_row` (counted from 1, 0: there is none) must be a whole number, 0 or more, got True",
    ),
    "no decimal sign": (lambda: tb.Hints(decimal=""), "`decimal` must be ',' or '.', got ''"),
    "two separators": (lambda: tb.Hints(separator="::"), "`separator` must be one character between columns"),
    "a seed in words": (
        lambda: tb.next_experiment([tb.baseline(), tb.preset("pes")], seed="a"),
        "seed: must be a whole number, 0 or more, got 'a'",
    ),
    "a preset as a list": (lambda: gcode.preset([]), "preset must be one of paper-1, paper-2, paper-3, fast; got []"),
    "a truth for a length": (
        lambda: gcode.generate("paper-1", 1, True),
        "gauge length must be 0.001 to 10000 mm, got True",
    ),
    "a controller as a mapping": (
        lambda: gcode.check(gcode.generate("paper-1", 1, duration_s=20), machine={}),
        "machine must be of the class Machine, got dict",
    ),
    "no channels": (lambda: tb.hide("none", "case", channels=5), "channels: must be force_N, resistance_ohm or both"),
    "effects that are no file": (lambda: tb.verify(".", effects=5), "not the path of a file with your own effects"),
    "workers in words": (lambda: tb.dataset("a.toml", "knits", workers="a"), "workers must be a whole number"),
    "a report of another kind": (
        lambda: tb.make_report(tb.example(duration_s=20)).write("a.html", format="pdf"),
        "format must be html or md, got 'pdf'",
    ),
    "a report without a place": (
        lambda: tb.make_report(tb.example(duration_s=20)).write(5),
        "got int, not the path of a report",
    ),
    "a rest without an end": (
        lambda: tb.simulate("pes", gcode.generate("paper-1", seed=1, duration_s=20), rest_s=float("inf")),
        "rest_s must be at most 100000 s, got inf",
    ),
    "a rig that stands still": (
        lambda: tb.serve_rig("pes", gcode.generate("paper-1", seed=1, duration_s=20), speed=0),
        "speed: must be a positive number, got 0",
    ),
    "rivals that were never fitted": (
        lambda: tb.next_experiment([tb.baseline(), "pes"]),
        "model 1: was never fitted, and knows no noise floor; fit it on a recording first",
    ),
    "a cluster as a number": (
        lambda: tb.dataset("a.toml", "knits", scheduler=5),
        "scheduler: must be an address such as tcp://10.0.0.5:8786, got 5",
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


def test_a_result_that_holds_a_recording_is_told_so(tmp_path):
    """It was told to make a data frame of it."""
    ran = tb.run("pes", gcode.generate("paper-1", seed=3, duration_s=20), tmp_path / "a")
    with pytest.raises(tb.UserError, match="got RunResult; give its `recording`"):
        tb.fit(ran)  # type: ignore[arg-type]


def test_a_coordinate_that_is_none_is_refused_with_those_there_are():
    recording = tb.example(duration_s=60)
    with pytest.raises(tb.UserError, match=r"coordinate must be one of strain, .*; got 'speed'"):
        tb.compare(recording, tb.baseline()).plot(coordinate="speed")


def test_the_gauge_length_that_a_recording_has_may_be_said_again():
    recording = tb.example(duration_s=20)
    assert as_recording(recording, 25) is as_recording(recording, None, usual_mm=30) is recording


@pytest.mark.parametrize(
    ("declared", "amiss"),
    [
        ({"reads": ("force_N",), "writes": ("force_N",)}, "stage"),
        ({"stage": "MECHANICS", "reads": ("force_N",), "writes": ("force_N",)}, "stage"),
        ({"stage": tb.Stage.MECHANICS, "reads": "force_N"}, "reads, writes"),
    ],
)
def test_a_class_of_an_effect_that_does_not_say_where_it_acts_is_told_so(declared, amiss):
    mine = type("Mine", (tb.Effect,), {"name": "mine", "__module__": __name__, **declared})
    with pytest.raises(tb.UserError, match=rf"^Mine: the class must declare its stage .*; amiss: {amiss}$"):
        tb.baseline() + mine()


def test_what_is_made_alike_is_equal_and_presets_stay_as_they_are():
    made = gcode.generate("paper-1", seed=1, duration_s=20)
    assert made == gcode.generate("paper-1", seed=1, duration_s=20)
    assert made != gcode.generate("paper-1", seed=2, duration_s=20)
    with pytest.raises(TypeError, match="not changed in place"):
        gcode.PRESETS.clear()


def test_what_numpy_gives_is_taken():
    assert tb.Hints(header_row=np.int64(1)).header_row == 1
    wish = tb.Wish(repeat=np.int64(2), sort=np.array([1, 2]).max() > 1)
    assert json.dumps([wish.repeat, wish.sort]) == "[2, true]"
    assert tb.baseline().with_parameters(pd.Series({"elasticity.stiffness_N": 9.0}))["elasticity"].stiffness_N == 9


def test_values_without_a_name_are_a_sentence(tmp_path):
    with pytest.raises(tb.UserError, match=r"takes its parameters by name: fraction, tau_s; got 0\.2"):
        tb.effects.StressRelaxation(0.2)
    with pytest.raises(tb.UserError, match=r"Hold takes its fields by name: .*duration_s.*; got 5 without one"):
        gcode.Hold(5)
    with pytest.raises(tb.UserError, match="effect: must be a name such as 'stress_relaxation', got"):
        tb.hide(tb.effects.StressRelaxation(), tmp_path / "case")


@pytest.mark.parametrize("note", [["a", "b", "c"], ["a", None, None], pd.Categorical(["a", "b", "a"])])
def test_remarks_are_left_out_of_a_data_frame_as_of_a_file(tmp_path, note):
    table = pd.DataFrame(TIMES | {"force_N": [0, 1, 2], "note": note})
    table.to_csv(tmp_path / "a.csv", index=False)
    for source in (table, tmp_path / "a.csv"):
        assert list(tb.read(source, 25).channels) == ["displacement_mm", "force_N"]
