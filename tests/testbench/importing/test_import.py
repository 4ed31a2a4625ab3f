"""Foreign files: found, converted, refused in one sentence that names file, row and remedy."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gcode.support.errors import UserError
from testbench import cli
from testbench.importing.sheet import Hints
from testbench.importing.wish import Wish
from testbench.recordings.files import read_recording
from tests.testbench.importing.exports import import_csv

REAL = Path(__file__).parents[3] / "../shared/data/real"
GOOD = "t,x,F,R\n0,0.0,0.1,1000\n0.1,0.5,0.2,900\n0.2,1.0,0.3,800\n"


COLUMNS = {"time": "t", "displacement": "x", "force": "F", "resistance": "R"}
UNITS = {"time": "s", "displacement": "mm", "force": "N", "resistance": "ohm"}


def wish(columns=None, units=None, **changes):
    """All four columns and their units; None in `columns` leaves one out."""
    named = {role: name for role, name in (COLUMNS | (columns or {})).items() if name is not None}
    spoken = {role: unit for role, unit in UNITS.items() if named.get(role, "none") != "none"} | (units or {})
    return Wish(**({"gauge_length_mm": 40.0, "columns": named, "units": spoken} | changes))


def written(folder, text, encoding="utf-8"):
    path = folder / "lab.csv"
    path.write_text(text, encoding=encoding)
    return path


def imported(folder, text, encoding="utf-8", columns=None, units=None, **changes):
    return import_csv(written(folder, text, encoding), wish(columns, units, **changes)).recording


def test_a_file_is_parsed_once(tmp_path, monkeypatch):
    """To see whether a row has a cell beyond the last column, an ordinary file was parsed twice."""
    read_csv, calls = pd.read_csv, []
    monkeypatch.setattr(pd, "read_csv", lambda *given, **more: calls.append(given) or read_csv(*given, **more))
    imported(tmp_path, GOOD)
    assert len(calls) == 1


def test_a_gauge_length_as_text_is_refused(tmp_path):
    with pytest.raises(UserError, match=r"lab.csv: the gauge length must be a number of mm, got '40' \(str\)"):
        imported(tmp_path, GOOD, gauge_length_mm="40")


@pytest.mark.parametrize("above", ["", "Instron 5543\nsample, knit 3\n\n"])
def test_a_quotation_mark_without_another_is_told_by_its_row(tmp_path, above):
    rows = [*f"{above}{GOOD}".split("\n")[:-1], *(f"{0.3 + n / 10:.1f},1.0,0.3,800" for n in range(80))]
    rows[60] = rows[60].replace("1.0", '"1.0')
    with pytest.raises(UserError, match="a quotation mark in row 61 has no other that closes it; check the export"):
        imported(tmp_path, "\n".join(rows))


@pytest.mark.parametrize(
    "text",
    [
        GOOD,
        GOOD.replace(",", ";"),
        GOOD.replace(",", "\t"),
        GOOD.replace(",", ";").replace(".", ","),
        GOOD.replace("\n", "\r\n"),
        "Instron 5543\nsample; knit 3\n\n" + GOOD,
        "t,x,F,R\n(s),(mm),(N),(ohm)\n" + GOOD.partition("\n")[2],
        GOOD + "\n\n",
        "t , x , F , R\n" + GOOD.partition("\n")[2].replace(",", ", "),
        GOOD.replace("R\n", "R,note\n").replace("00\n", "00,ok\n"),
    ],
)
def test_layouts_that_labs_use_all_read_the_same(tmp_path, text):
    recording = imported(tmp_path, text)
    assert recording.time_s.tolist() == [0, 0.1, 0.2]
    assert recording["displacement_mm"].tolist() == [0, 0.5, 1]
    assert recording["force_N"].tolist() == [0.1, 0.2, 0.3]
    assert recording["resistance_ohm"].tolist() == [1000, 900, 800]


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "cp1252"])
def test_encodings(tmp_path, encoding):
    recording = imported(
        tmp_path,
        GOOD.replace("R\n", "Ωµ\n" if encoding != "cp1252" else "Rµ\n"),
        encoding,
        {"resistance": "Ωµ" if encoding != "cp1252" else "Rµ"},
    )
    assert recording["resistance_ohm"].tolist() == [1000, 900, 800]


def test_units(tmp_path):
    units = {"time": "min", "displacement": "in", "resistance": "kΩ"}
    recording = imported(tmp_path, GOOD, units=units)
    assert recording.time_s.tolist() == [0, 6, 12]
    assert recording["displacement_mm"][-1] == 25.4
    assert recording["resistance_ohm"][0] == 1e6


NO_R = {"resistance": None}


def test_strain_conductance_and_relative_resistance(tmp_path):
    recording = imported(tmp_path, GOOD, columns={"displacement": None, "strain": "x"}, units={"strain": "%"})
    assert recording["displacement_mm"].tolist() == pytest.approx([0, 0.2, 0.4])
    recording = imported(tmp_path, GOOD, columns=NO_R | {"conductance": "R"}, units={"conductance": "uS"})
    assert recording.conductance_S.tolist() == pytest.approx([1e-3, 9e-4, 8e-4])
    recording = imported(tmp_path, GOOD, columns=NO_R | {"relative_change": "x"}, r0_ohm=100.0)
    assert recording["resistance_ohm"].tolist() == [100, 150, 200]
    recording = imported(tmp_path, GOOD, columns=NO_R | {"relative": "R"}, r0_ohm=2.0)
    assert recording["resistance_ohm"].tolist() == [2000, 1800, 1600]


def test_force_or_resistance_may_be_absent_and_time_may_be_a_rate(tmp_path):
    recording = imported(tmp_path, GOOD, columns={"force": "none", "time": None}, rate_hz=4.0)
    assert list(recording.channels) == ["displacement_mm", "resistance_ohm"]
    assert recording.time_s.tolist() == [0, 0.25, 0.5]


def test_dates_and_times_become_seconds(tmp_path):
    stamps = ["2026-03-01 23:59:59.9", "2026-03-02 00:00:00", "2026-03-02T00:00:00.250"]
    text = GOOD.replace("\n0,0.0", f"\n{stamps[0]},0.0").replace("0.1,0.5", f"{stamps[1]},0.5")
    text = text.replace("0.2,1.0", f"{stamps[2]},1.0")
    assert imported(tmp_path, text, units={"time": "date"}).time_s.tolist() == pytest.approx([0, 0.1, 0.35])
    with pytest.raises(UserError, match="row 4: t must be a date and time, got 'noon'"):
        imported(tmp_path, text.replace(stamps[2], "noon"), units={"time": "date"})


BAD = [
    ("", "the file is empty"),
    ("   \n\n", "the file is empty"),
    ("\ufeff", "the file is empty"),
    ("\n" * 250 + "t,x,F,R\n0,0,0,1\n", "a table that begins further below is found"),
    ("t,x,F,R\n", "nothing below the header in row 1"),
    ("t,x,F,R\n0,0,0,1\n", "needs at least 2"),
    (GOOD.replace("F", "force"), r"no column 'F'; row 1 has: t, x, force, R"),
    (
        GOOD.replace("0.2,900", "nan,900"),
        r"row 3: force_N must be a finite number, got nan \(1 such row\); --drop-bad",
    ),
    (GOOD.replace("0.2,900", "inf,900"), r"row 3: force_N must be a finite number, got inf"),
    (GOOD.replace("0.2,900", ",900"), r"row 3: force_N must be a finite number"),
    (GOOD.replace("0.2,900", "--,900"), r"row 3: F must be a number, got '--'; --drop-bad"),
    (GOOD.replace("900", "-900"), r"row 3: resistance_ohm must be positive and finite, got -900"),
    (GOOD.replace("0.1,0.5", "0.3,0.5"), r"row 4: time must increase, got 0.2 s after 0.3 s; --sort"),
    (GOOD.replace("0.1,0.5", "0.0,0.5"), r"row 3: time must increase, got 0 s after 0 s; --sort"),
]


@pytest.mark.parametrize(("text", "message"), BAD)
def test_what_cannot_be_used_is_named_with_row_and_remedy(tmp_path, text, message):
    with pytest.raises(UserError, match=message) as caught:
        imported(tmp_path, text)
    assert "lab.csv" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_drop_bad_leaves_out_exactly_the_bad_rows(tmp_path):
    text = GOOD + "0.3,1,nan,700\n0.4,1,0.5,-3\n0.5,?,0.5,600\n0.6,2,0.5,500\n"
    done = import_csv(written(tmp_path, text), wish(drop_bad=True))
    assert done.dropped == 3
    assert done.recording.time_s.tolist() == pytest.approx([0, 0.1, 0.2, 0.6])


@pytest.mark.parametrize("separator", [",", ";"])
def test_a_row_whose_cells_are_shifted_by_a_number_in_two_parts_is_not_taken(tmp_path, separator):
    """Beyond the rows that are looked at first: one decimal comma puts each cell behind it into another column."""
    rows = [f"{n / 10},{n},0.5,{900 + n}" for n in range(400)]
    rows[300], rows[310] = "30.0,300,0,5,1200", "31.0,310,0.5,1210,marked"
    text = "\n".join(["t,x,F,R", *rows]).replace(",", separator)
    with pytest.raises(
        UserError,
        match=rf"row 302: t must be a number, got '30.0{separator}300.*1200 .more than 4 cells.'; --drop-bad",
    ):
        imported(tmp_path, text)
    done = import_csv(written(tmp_path, text), wish(drop_bad=True))
    assert (done.dropped, done.recording["resistance_ohm"].min()) == (1, 900)


def test_drop_bad_leaves_out_the_overload_of_a_meter(tmp_path):
    text = GOOD + "0.3,1,0.5,9.9E+37\n0.4,2,0.5,500\n"
    with pytest.raises(UserError, match=r"row 5: resistance_ohm is 9.9e\+37 .* --drop-bad"):
        imported(tmp_path, text)
    done = import_csv(written(tmp_path, text), wish(drop_bad=True))
    assert done.dropped == 1
    assert done.recording["resistance_ohm"].max() < 1e4


def test_sort_puts_rows_in_order_and_drops_repeated_times(tmp_path):
    text = "t,x,F,R\n0.2,2,0,1\n0.0,0,0,1\n0.1,1,0,1\n0.1,9,0,1\n"
    done = import_csv(written(tmp_path, text), wish(sort=True))
    assert done.recording["displacement_mm"].tolist() == [0, 1, 2]
    assert done.repeated == 1


@pytest.mark.parametrize(("begin", "what"), [(b"PK\x03\x04", "a zip archive"), (b"\x02\x03\x04", "not a text file")])
def test_a_binary_file_is_no_csv(tmp_path, begin, what):
    path = tmp_path / "lab.csv"
    path.write_bytes((begin + b"\x00\x00t,x,F,R\x00") * 50)
    with pytest.raises(UserError, match=what):
        import_csv(path, wish())


def command(path, out, *more):
    words = ["--time", "t", "--displacement", "x", "--force", "F", "--resistance", "R", "--gauge-length-mm", "40"]
    words += ["--time-unit", "s", "--displacement-unit", "mm", "--force-unit", "N", "--resistance-unit", "ohm"]
    return cli.main(["import", str(path), *words, "-o", str(out), *more])


def test_the_command_writes_a_campaign_that_verifies(tmp_path):
    assert command(written(tmp_path, GOOD), tmp_path / "lab", "--resistance-unit", "kohm") == 0
    assert cli.main(["verify", str(tmp_path / "lab")]) == 0
    recording = read_recording(tmp_path / "lab")
    assert recording.gauge_length_mm == 40
    assert recording["resistance_ohm"][0] == 1e6


def test_the_command_writes_a_plain_csv(tmp_path):
    assert command(written(tmp_path, GOOD), tmp_path / "ours.csv") == 0
    assert read_recording(tmp_path / "ours.csv", 40.0)["force_N"].tolist() == [0.1, 0.2, 0.3]


def test_bad_input_leaves_no_file(tmp_path, capsys):
    assert command(written(tmp_path, GOOD.replace("900", "x")), tmp_path / "lab") == 2
    assert "row 3" in capsys.readouterr().err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["lab.csv"]


@pytest.mark.real_data
@pytest.mark.skipif(not REAL.is_dir(), reason="the measured recordings are not here")
def test_measured_recordings_import_unchanged():
    path = REAL / "cb_silicone_strip" / "cb7.5_s2_sine.csv"
    done = import_csv(path, Wish(40.0))
    ours = read_recording(path, 40.0)
    assert np.array_equal(done.recording["resistance_ohm"], ours["resistance_ohm"])


@pytest.mark.parametrize(
    ("said", "message"),
    [
        (["--encoding", "hex"], "--encoding must be one such as utf-8, latin-1, gbk or shift-jis, got 'hex'"),
        (["--separator", "::"], "--separator must be one character between columns, such as ; or \\t, got '::'"),
        (["--separator", '"'], "--separator must be one character"),
        (
            ["--header-row", "-1"],
            "--header-row (counted from 1, 0: there is none) must be a whole number, 0 or more, got",
        ),
        (["--units-row", "-2"], "--units-row (counted from 1, 0: there is none) must be"),
        (["--thousands", "abc"], "--thousands must be one of ',', '.', \"'\", '’', ' ', got 'abc'"),
        (["--thousands", ".", "--decimal", "."], "--thousands must be one of ',', \"'\", '’', ' ', got '.'"),
        (["--sheet", "Data"], "--sheet is of a workbook or a TDMS file"),
    ],
)
def test_what_cannot_be_so_is_a_sentence(tmp_path, capsys, said, message):
    (tmp_path / "lab.csv").write_text("Time [s],Weg [mm]\n0.0,1.0\n0.1,1.5\n0.2,2.5\n")
    argv = ["import", str(tmp_path / "lab.csv"), "--gauge-length-mm", "40", "-o", str(tmp_path / "out")]
    assert cli.main([*argv, *said]) == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_what_parts_thousands_is_not_the_decimal_sign(tmp_path):
    (tmp_path / "lab.csv").write_text("t [s];x [mm];R [Ohm]\n0;1;47.100\n1;2;47.200\n2;3;47.300\n")
    recording = import_csv(tmp_path / "lab.csv", Wish(40.0, hints=Hints(thousands="."))).recording
    assert recording["resistance_ohm"].tolist() == [47_100, 47_200, 47_300]


def test_a_folder_and_a_name_of_many_characters_are_said_short(tmp_path, capsys):
    assert cli.main(["import", str(tmp_path), "--gauge-length-mm", "40", "-o", str(tmp_path / "out")]) == 2
    assert "a folder, no file" in capsys.readouterr().err
    (tmp_path / "lab.csv").write_text(f"Time [s],{'x' * 5000},Weg\n0.0,1.0,1\n0.1,1.5,2\n0.2,2.5,3\n")
    assert cli.main(["import", str(tmp_path / "lab.csv"), "-o", str(tmp_path / "out")]) == 2
    assert len(capsys.readouterr().err) < 400


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--rest-ohm", "100"], "--rest-ohm is R0 of a relative resistance, of which no column is taken"),
        (["--separator", ""], "--separator must be one character between columns, such as ; or \\t, got ''"),
    ],
)
def test_what_would_be_without_effect_is_refused(tmp_path, capsys, words, told):
    path = written(tmp_path, GOOD.replace("t,x,F,R", "t [s],x [mm],F [N],R [ohm]"))
    assert cli.main(["import", str(path), "--gauge-length-mm", "40", "-o", str(tmp_path / "out"), *words]) == 2
    assert told in capsys.readouterr().err
