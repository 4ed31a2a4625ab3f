"""Reading recordings: what a lab's file may look like, and the one sentence for what it may not."""

from __future__ import annotations

import numpy as np
import pytest

from gcode.support.errors import UserError
from testbench import cli
from testbench.recordings.files import read_recording, write_recording_csv
from testbench.recordings.recording import Recording
from tests.testbench.rig.rigs import program

HEAD = "time_s,displacement_mm,force_N,resistance_ohm\n"
GOOD = HEAD + "0,0,0.1,1000\n0.1,0.5,0.2,900\n0.2,1,0.3,800\n"

FINE = {
    "plain": GOOD,
    "byte order mark": "\ufeff" + GOOD,
    "carriage returns": GOOD.replace("\n", "\r\n"),
    "no last line feed": GOOD[:-1],
    "quotes": GOOD.replace("0.2,900", '"0.2",900'),
    "spaces": GOOD.replace(",", ", "),
    "a column of remarks": GOOD.replace("ohm\n", "ohm,note\n").replace("00\n", "00,fine\n"),
    "a comma that ends each row": GOOD.replace("\n", ",\n"),
    "a comma that ends the header": GOOD.replace("ohm\n", "ohm,\n"),
}
BAD = {
    "": "the file is empty",
    "\n\n": "the file is empty",
    HEAD: "at least 2 samples, got 0",
    HEAD + "0,0,0,1\n": "at least 2 samples, got 1",
    GOOD.replace("0.2,900", "nan,900"): r"row 3: force_N is nan \(1 such row\); `testbench import --drop-bad`",
    GOOD.replace("0.2,900", ",900"): r"row 3: force_N is nan \(1 such row\)",
    GOOD.replace("0.2,900", "abc,900"): r"row 3: force_N must be a number, got 'abc'; `testbench import --drop-bad`",
    GOOD.replace("900", "-900"): r"row 3: resistance_ohm must be positive, got -900",
    GOOD.replace("900", "1e400"): r"row 3: resistance_ohm is inf",
    GOOD.replace(
        "0.1,0.5", "0.5,0.5"
    ): r"row 4: time must increase, got 0.2 s after 0.5 s; `testbench import --sort`",
    GOOD.replace("0.1,0.5", "0.0,0.5"): r"row 3: time must increase, got 0 s after 0 s",
    GOOD.replace(",", ";"): "semicolons between the columns; turn it into a recording with `testbench import`",
    GOOD.replace(",", ";").replace(".", ","): "semicolons between the columns",
    GOOD.replace(",", "\t"): "tabs between the columns",
    GOOD.replace("time_s", "t"): r"no column time_s \(found: t, displacement_mm, force_N, resistance_ohm\)",
    "time,displacement_mm,force_N\n00:01,0,1\n00:02,1,2\n": r"no column time_s \(found: time \(text\), displ",
    "time_s,Weg,force_N,\n0,0 mm,1,\n1,1 mm,2,\n": r"no column displacement_mm \(found: Weg \(text\), force_N\)",
    "time_s,displacement_mm,Kraft\n0,0,1 N\n1,1,2 N\n": "no column force_N, but one called 'Kraft': name it",
    GOOD.replace("displacement_mm", "displacement_m"): r"no column displacement_mm \(found: displacement_m",
    GOOD.replace("force_N", "displacement_mm"): "row 1 names the column 'displacement_mm' twice",
    GOOD.replace("force_N", "Kraft"): "no column force_N, but one called 'Kraft': name it with `testbench import`",
    GOOD.replace("force_N", "load_N"): "no column force_N, but one called 'load_N'",
    GOOD.replace("_ohm", "_kohm"): "no column resistance_ohm, but one called 'resistance_kohm'",
    GOOD + "1,2,3,4,5,6\n": "row 5 has 6 cells, the rows above 4",
    HEAD + "0,0,0,1,\n1,0,0,1,\n": "row 2 has 5 cells, the header 4",
    GOOD.replace("_ohm", "_ohm,").replace("900", "900,5"): "row 1 .* column 5 has numbers and no name; name it, or",
    HEAD.replace("_ohm", "_ohm,") + "0,0,0,1,5\n1,0,0,1,x\n": "column 5 has numbers and no name",
    GOOD.replace("0.5", '"0.5'): "a quotation mark in row 3 has no other that closes it; mend it",
    GOOD + "0.3,1.2": "row 5: force_N is nan",
}


def written(folder, text):
    path = folder / "recording.csv"
    path.write_text(text, encoding="utf-8", newline="")
    return path


@pytest.mark.parametrize("name", ["strain", "cycle", "Index", "phase"])
def test_a_column_that_is_neither_force_nor_resistance_hides_none(tmp_path, name):
    recording = read_recording(written(tmp_path, GOOD.replace("resistance_ohm", name)), 25.0)
    assert recording.has("force_N")
    assert not recording.has("resistance_ohm")


@pytest.mark.parametrize("name", ["temp_C", "temperature_K", "Temp"])
def test_a_thermometer_of_another_name_is_not_overlooked_in_silence(tmp_path, caplog, name):
    (tmp_path / "a.csv").write_text(f"time_s,displacement_mm,force_N,{name}\n0,0,0,20\n1,1,1,21\n2,0,0,22\n")
    read_recording(tmp_path / "a.csv", 25)
    assert f"column {name!r} is not taken for the temperature" in caplog.text
    caplog.clear()
    (tmp_path / "b.csv").write_text("time_s,displacement_mm,force_N,temporary_V\n0,0,0,20\n1,1,1,21\n2,0,0,22\n")
    read_recording(tmp_path / "b.csv", 25)
    assert not caplog.text


def test_a_mark_that_quotes_nothing_hides_no_rows(tmp_path):
    lines = [f"{0.1 * n:.1f},{n},0.1,900,fine" for n in range(60)]
    lines[18], lines[38] = f'{lines[18][:-4]}"a', f'{lines[38][:-4]}"a'
    text = "\n".join([f"{HEAD.strip()},note", *lines]) + "\n"
    with pytest.raises(UserError, match="a quotation mark in row 20 is closed only in row 40, so the rows between"):
        read_recording(written(tmp_path, text), 25.0)
    text = text.replace('"a', '"two\nlines"', 1).replace('"a', "fine")
    assert len(read_recording(written(tmp_path, text), 25.0)) == 60


def test_other_channels_may_stand_beside_or_instead(tmp_path):
    text = GOOD.replace("resistance_ohm", "displacement_planned_mm").replace("force_N", "temperature_C")
    assert list(read_recording(written(tmp_path, text), 25.0).channels) == [
        "displacement_mm",
        "temperature_C",
        "displacement_planned_mm",
    ]


@pytest.mark.parametrize("text", FINE.values(), ids=FINE)
def test_a_good_file_reads(tmp_path, text):
    recording = read_recording(written(tmp_path, text), 25.0)
    assert list(recording.channels) == ["displacement_mm", "force_N", "resistance_ohm"]
    assert recording["force_N"].tolist() == [0.1, 0.2, 0.3]


def test_numbers_of_the_rows_stand_in_a_column_without_a_name(tmp_path):
    """As pandas writes them unless told not to."""
    rows = [f"{number},{line}" for number, line in enumerate(GOOD.split()[1:])]
    recording = read_recording(written(tmp_path, "\n".join([f",{HEAD[:-1]}", *rows])), 25.0)
    assert recording["force_N"].tolist() == [0.1, 0.2, 0.3]


@pytest.mark.parametrize(("text", "message"), BAD.items())
def test_a_bad_file_is_refused_in_one_sentence(tmp_path, text, message):
    with pytest.raises(UserError, match=message) as caught:
        read_recording(written(tmp_path, text), 25.0)
    assert str(caught.value).startswith(str(tmp_path / "recording.csv"))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("data", [bytes(range(256)), GOOD.encode("utf-16")])
def test_a_file_that_is_no_text_is_refused(tmp_path, data):
    path = tmp_path / "recording.csv"
    path.write_bytes(data)
    with pytest.raises(UserError, match="not plain"):
        read_recording(path, 25.0)


@pytest.mark.parametrize("gauge_mm", [0.0, -1.0, 1e300, float("nan"), float("inf")])
def test_a_gauge_length_that_is_no_length_is_refused(tmp_path, gauge_mm):
    with pytest.raises(UserError, match="gauge length must be a positive number"):
        read_recording(written(tmp_path, GOOD), gauge_mm)


def test_a_bare_csv_needs_a_gauge_length_and_a_path_must_exist(tmp_path):
    with pytest.raises(UserError, match="give `gauge_length_mm`"):
        read_recording(written(tmp_path, GOOD))
    with pytest.raises(UserError, match="no such recording"):
        read_recording(tmp_path / "nothing.csv", 25.0)
    with pytest.raises(UserError, match=r"no datapackage\.json"):
        read_recording(tmp_path)


def test_what_is_written_reads_back_to_the_last_decimal(tmp_path):
    rng = np.random.default_rng(1)
    time_s = np.cumsum(rng.uniform(0.001, 0.1, 2000)).round(6)
    channels = {
        "temperature_C": rng.normal(20, 5, 2000).round(6),
        "resistance_ohm": rng.uniform(1, 1e7, 2000).round(3),
        "displacement_mm": rng.normal(0, 10, 2000).round(6),
    }
    write_recording_csv(tmp_path / "r.csv", Recording(time_s, channels, 25.0))
    again = read_recording(tmp_path / "r.csv", 25.0)
    assert list(again.channels) == ["displacement_mm", "resistance_ohm", "temperature_C"]
    assert np.array_equal(again.time_s, time_s)
    assert all(np.array_equal(again[name], values) for name, values in channels.items())


MODELS = {
    "[]": "not a knitbench model",
    '{"format": "knitbench-model", "version": 7, "effects": []}': "model version 7",
    '{"format": "knitbench-model", "version": 1, "effects": '
    '[{"name": "x", "effect": "magic", "parameters": {}}]}': "magic",
    '{"format": "knitbench-model", "version": 1, "effects": '
    '[{"name": "elasticity", "effect": "elasticity", "parameters": {"stiffness_N": -1}}]}': "stiffness_N",
    '{"format": "knitbench-model", "version": 1, "effects": []}': "neither force_N nor conductance_S",
    "{": "not a model: line 1 is not valid JSON",
}


@pytest.mark.parametrize(("text", "message"), MODELS.items())
def test_a_bad_model_file_is_refused_and_nothing_is_written(tmp_path, capsys, text, message):
    (tmp_path / "m.json").write_text(text)
    words = [
        "run",
        "--model",
        str(tmp_path / "m.json"),
        "--program",
        str(program(tmp_path)),
        "-o",
        str(tmp_path / "c"),
    ]
    assert cli.main(words) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == ["m.json", "two_triangles.tap"]


@pytest.mark.parametrize("ohm", [1e-3, 0.98, 42.0, 1e3, 4.4e5])
def test_a_resistance_keeps_its_digits_however_small_it_is(tmp_path, ohm):
    values = ohm * (1 + np.linspace(0, 0.1, 50))
    channels = {"displacement_mm": np.zeros(50), "resistance_ohm": values}
    write_recording_csv(tmp_path / "r.csv", Recording(np.arange(50.0), channels, 25.0))
    assert read_recording(tmp_path / "r.csv", 25.0)["resistance_ohm"] == pytest.approx(values, rel=1e-6)


def test_where_a_board_began_anew_is_said(tmp_path, caplog):
    """Its encoder counts from there: the displacement jumped without a word."""
    rows = "".join(f"{n / 10},{n % 40 / 10},{n}\n" for n in range(80))
    (tmp_path / "a.csv").write_text("time_s,displacement_mm,force_N\n" + rows)
    assert cli.main(["import", str(tmp_path / "a.csv"), "--gauge-length-mm", "40", "-o", str(tmp_path / "a")]) == 0
    events = [
        '{"event": "loss", "time_s": 1.5, "lost": 1}',
        "{cut",
        '{"event": "reboot", "time_s": 4.0, "from_s": 3.9}',
    ]
    for lines, told in ((events[:2], 0), (events, 1)):
        (tmp_path / "a" / "events.jsonl").write_text("\n".join(lines))
        assert len(read_recording(tmp_path / "a")) == 80
        said = [record.message for record in caplog.records if "began anew" in record.message]
        assert len(said) == told
    assert "the board began anew at 4 s, with a displacement of 0 mm after 3.9 mm: if its zero is" in said[0]
