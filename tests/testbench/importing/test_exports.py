"""Exports of testers, a script, a spreadsheet and LabVIEW: all the same test, all read without any column option."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from gcode.support.errors import UserError
from testbench.cli import main
from testbench.importing.from_file import import_file
from testbench.importing.sheet import Hints
from testbench.importing.wish import Wish
from testbench.recordings.files import read_recording
from tests.testbench.importing import exports
from tests.testbench.importing.exports import import_csv

FOREIGN = Path(__file__).parents[3] / "../shared/data/foreign"
REAL = Path(__file__).parents[3] / "../shared/data/real"
needs_foreign = pytest.mark.skipif(not FOREIGN.is_dir(), reason="the heads of foreign files are not here")
needs_real = pytest.mark.skipif(not REAL.is_dir(), reason="the measured recordings are not here")


def test_testxpert_has_its_units_in_a_row_and_the_conversion_is_shown(tmp_path, capsys):
    path = exports.testxpert(tmp_path)
    assert main(["import", str(path), "--gauge-length-mm", "40", "-o", str(tmp_path / "out")]) == 0
    exports.check_same(read_recording(tmp_path / "out"))
    said = capsys.readouterr().out
    assert "resistance: column 4 'Widerstand' in kΩ (row 2): 439.377 kΩ read as 439 377 Ω" in said
    assert "force: column 3 'Standardkraft' in kN (row 2): 0.0002 kN read as 0.2 N" in said


@pytest.mark.parametrize(
    "header", ["# t (s), x (mm), F (N), R (ohm)", "t (s);x (mm);F (N);R (ohm)", "t (s) x (mm) F (N) R (ohm)"]
)
def test_names_with_blanks_may_stand_over_columns_that_blanks_part(tmp_path, header):
    """As `numpy.savetxt(..., header="t (s), x (mm), ...")` writes them."""
    rows = [f"{0.1 * n:.1f} {abs(n % 40 - 20) * 0.2:.1f} {2 + 0.05 * n:.2f} {300 - n}" for n in range(60)]
    (tmp_path / "lab.txt").write_text("\n".join([header, *rows]) + "\n")
    recording = import_csv(tmp_path / "lab.txt", Wish(40.0)).recording
    assert recording["force_N"] == pytest.approx(2 + 0.05 * np.arange(60))
    assert recording["resistance_ohm"] == pytest.approx(300 - np.arange(60))


def test_an_import_that_fails_leaves_the_earlier_one(tmp_path, monkeypatch, capsys):
    words = ["import", str(exports.testxpert(tmp_path)), "--gauge-length-mm", "40", "-o", str(tmp_path / "out")]
    assert main(words) == 0
    before = {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()}

    def full(*_args):
        raise UserError("no space left")

    monkeypatch.setattr("testbench.importing.imported.write_manifest", full)
    assert main([*words, "--overwrite"]) == 2
    assert main([*words[:-1], str(tmp_path / "new")]) == 2
    assert {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()} == before
    assert not (tmp_path / "new").exists()
    assert not list(tmp_path.glob(".*"))
    monkeypatch.undo()
    assert main([*words, "--overwrite"]) == 0


def test_a_channel_that_is_declined_is_not_looked_for(tmp_path):
    done = import_csv(exports.testxpert(tmp_path), Wish(40.0, {"force": "none"}))
    assert not any("force" in doubt for doubt in done.doubts)
    assert "without force_N: as you said" in done.notes


def test_bluehill_has_titles_a_results_table_and_two_positions(tmp_path):
    path = exports.bluehill(tmp_path)
    done = import_csv(path, Wish(40.0))
    exports.check_same(done.recording)
    assert done.taken["displacement"].startswith("column 2 'Extension' in mm (row 9)")
    assert any("Corrected Position" in note for note in done.notes)


def test_testsuite_has_the_separator_in_its_preamble(tmp_path):
    exports.check_same(import_csv(exports.testsuite(tmp_path), Wish(40.0)).recording, resistance=False)


def test_electropuls_has_commas_in_its_names_and_two_times(tmp_path):
    done = import_csv(exports.electropuls(tmp_path), Wish(40.0))
    exports.check_same(done.recording, resistance=False)
    assert done.taken["time"].startswith("column 1 'Total Time (s)'")


HEADERLESS = {
    "columns": {"resistance": "1", "time": "2", "displacement": "3", "force": "5"},
    "units": {"resistance": "ohm", "time": "s", "displacement": "mm", "force": "N"},
    "time_of": {"displacement": "4", "force": "6"},
}


def test_without_a_header_columns_are_numbered_and_clocks_brought_together(tmp_path):
    path = exports.headerless(tmp_path)
    with pytest.raises(
        UserError, match=r"no header was found above the 6 columns, which are numbered from 1 \(row 1: 1 = 439377"
    ):
        import_csv(path, Wish(40.0))
    with pytest.raises(UserError, match=r"time .column 2.: the file does not say its unit"):
        import_csv(path, Wish(40.0, HEADERLESS["columns"]))
    done = import_csv(path, Wish(40.0, negate=frozenset({"displacement"}), **HEADERLESS))
    recording, inside = done.recording, slice(1, -1)  # force begins later, position ends earlier
    assert recording.time_s == pytest.approx(exports.TIME_S[inside] - exports.TIME_S[1], abs=1e-6)
    shifted = np.interp(exports.TIME_S + 0.03, exports.TIME_S, exports.EXTENSION_MM)
    assert recording["displacement_mm"] == pytest.approx(shifted[inside], abs=2e-3)
    assert recording["resistance_ohm"] == pytest.approx(exports.RESISTANCE_OHM[inside])


def test_a_displacement_that_runs_the_wrong_way_is_said(tmp_path):
    done = import_csv(exports.headerless(tmp_path), Wish(40.0, **HEADERLESS))
    assert any("runs the wrong way; add --negate displacement" in doubt for doubt in done.doubts)
    turned = import_csv(exports.headerless(tmp_path), Wish(40.0, negate=frozenset({"displacement"}), **HEADERLESS))
    assert not turned.doubts


def test_zero_and_sign(tmp_path):
    path = tmp_path / "lab.csv"
    path.write_text("t [s],x [cm],F [kN]\n0,-2.5,0.5\n1,-2.4,0.4\n2,-2.3,0.3\n")
    found = import_csv(path, Wish(40.0, zero={"displacement": None, "force": "0.5"}, negate=frozenset({"force"})))
    assert found.recording["displacement_mm"] == pytest.approx([0, 1, 2])
    assert found.recording["force_N"] == pytest.approx([0, 100, 200])
    assert "0.5 kN read as 500 N is the zero of force" in found.notes
    found = import_csv(path, Wish(40.0, zero={"force": "0.5 N"}))
    assert found.recording["force_N"] == pytest.approx([499.5, 399.5, 299.5])
    assert any("starts at -25 mm, a zero of its own" in doubt for doubt in found.doubts)
    for wrong in ("x", "1 mm"):
        with pytest.raises(UserError, match="--zero force= needs a number in kN, or with its unit"):
            import_csv(path, Wish(40.0, zero={"force": wrong}))
    with pytest.raises(UserError, match="--negate can be said of displacement, force, got time"):
        import_csv(path, Wish(40.0, negate=frozenset({"time"})))


def test_a_displacement_that_begins_far_from_zero_is_said(tmp_path):
    path = tmp_path / "clamps.csv"
    rows = "".join(f"{n},{40 + 0.1 * n:.1f},{n}\n" for n in range(30))
    path.write_text(f"Time [s],Position [mm],Load [N]\n{rows}")
    (doubt,) = import_csv(path, Wish(40.0)).doubts
    assert "starts at 40 mm and then moves by 2.9 mm" in doubt
    assert import_csv(path, Wish(40.0, zero={"displacement": None})).doubts == []


def test_a_length_of_no_known_name_is_said_where_no_displacement_was_found(tmp_path):
    path = tmp_path / "length.csv"
    path.write_text("Time [s],Load [N],R [kOhm],Gap [cm]\n0,0,5,1.0\n1,1,6,1.1\n2,2,7,1.2\n")
    (doubt,) = import_csv(path, Wish()).doubts
    assert doubt.endswith("'Gap [cm]' is in cm: if it is the displacement, say --displacement 4")
    assert import_csv(path, Wish(40.0, {"displacement": "4"}, zero={"displacement": None})).doubts == []


def test_the_sign_of_a_conductance_is_turned_where_that_is_said_once(tmp_path):
    path = tmp_path / "leads.csv"
    path.write_text("Time [s],Extension [mm],Conductance [mS]\n0,0,-1\n1,1,-2\n2,2,-4\n")
    with pytest.raises(UserError, match="add --negate conductance"):
        import_csv(path, Wish(40.0))
    found = import_csv(path, Wish(40.0, negate=frozenset({"conductance"})))
    assert found.recording["resistance_ohm"] == pytest.approx([1000, 500, 250])
    with pytest.raises(UserError, match="can be said of displacement, conductance, got resistance"):
        import_csv(path, Wish(40.0, negate=frozenset({"resistance"})))
    path.write_text(path.read_text().replace("-", ""))
    with pytest.raises(UserError, match="leave --negate conductance out"):
        import_csv(path, Wish(40.0, negate=frozenset({"conductance"})))


def test_a_resistance_whose_leads_were_the_other_way_round_is_turned_and_not_dropped(tmp_path):
    path = tmp_path / "leads.csv"
    path.write_text("Time [s],Extension [mm],R [kOhm]\n0,0,-1.5\n1,1,-1.6\n2,2,-1.7\n")
    with pytest.raises(UserError, match=r"got -1500 \(3 such rows\); .* add --negate resistance"):
        import_csv(path, Wish(40.0))
    found = import_csv(path, Wish(40.0, negate=frozenset({"resistance"})))
    assert found.recording["resistance_ohm"] == pytest.approx([1500, 1600, 1700])
    assert "the sign of resistance was turned" in found.notes
    with pytest.raises(UserError, match="--zero can be said of displacement, got resistance"):
        import_csv(path, Wish(40.0, negate=frozenset({"resistance"}), zero={"resistance": None}))


@pytest.mark.parametrize(
    ("name", "factor", "lengths"),
    [("Strain", 1.0, "80 mm or 8000 mm"), ("Strain [%]", 100.0, "80 mm"), ("Strain [1]", 1.0, "80 mm")],
)
def test_a_strain_beside_the_displacement_knows_the_gauge_length(tmp_path, name, factor, lengths):
    path = tmp_path / "both.csv"
    rows = "".join(f"{n},{n % 9},{n % 5},{factor * (n % 9) / 80 - 0.01:.9f}\n" for n in range(50))
    path.write_text(f"Time [s],Extension [mm],Load [N],{name}\n{rows}")
    said = f"is that of a gauge length of {lengths}, and --gauge-length-mm says 40"
    assert any(said in doubt for doubt in import_csv(path, Wish(40.0)).doubts)
    assert import_csv(path, Wish(80.5)).doubts == []


def test_a_strain_of_something_else_says_nothing_of_the_gauge_length(tmp_path):
    path = tmp_path / "both.csv"
    rows = "".join(f"{n},{n % 9},{n % 5},{(n * n) % 11}\n" for n in range(50))
    path.write_text(f"Time [s],Extension [mm],Load [N],Transverse strain [%]\n{rows}")
    assert import_csv(path, Wish(40.0)).doubts == []


REFUSED = [
    ("Time [s],Extension [mm],Position [mm]\n", "both fit displacement: say which, e.g. --displacement 3"),
    ("Time [s],Extension,Load [N]\n", "the file does not say its unit; say --displacement-unit"),
    ("Time [s],Extension [mm],Load [mV]\n", "its unit .mV. cannot be read as one; .*, or --force none"),
    ("Time [s],Extension [mm],Load (kN)\ns,mm,N\n", r"its unit 'kN \| N' cannot be read as one"),
    ("Time [s],Extension [mm],Load, cell 2 [N]\n", "row 1 has 4 names, the rows of numbers below it 3 columns"),
    ("Time [s],Extension [mm]\n", "row 1 has 2 names, the rows of numbers below it 3 columns"),
    ("Time [s],Speed [mm/s],Load [N]\n", "no displacement found, nor force and resistance both"),
    ("Date,Extension [mm],Load [N]\n", "no time found: say --time COL, or --rate-hz"),
    ("Time [s],Extension [mm],dR/R0\n", "say --rest-ohm"),
]


@pytest.mark.parametrize(("head", "message"), REFUSED)
def test_where_it_cannot_be_told_it_is_refused(tmp_path, head, message):
    path = tmp_path / "lab.csv"
    path.write_text(head + "0,0,0.1\n1,0.5,0.2\n2,1.0,0.3\n")
    with pytest.raises(UserError, match=message) as caught:
        import_csv(path, Wish(40.0))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("cells", "value"),
    [
        ("0,5;1,5;1.234,5", 1234.5),
        ("0,5;1,5;12 345,5", 12345.5),
        ("0,5;1,5;12\u00a0345,5", 12345.5),
        ("0,5;1,5;12\u202f345,5", 12345.5),
        ("0.5;1.5;1,234.5", 1234.5),
        ("0.5;1.5;1'234", 1234),
    ],
)
def test_thousands_that_a_number_proves(tmp_path, cells, value):
    path = tmp_path / "lab.csv"
    point = "," if "0,5" in cells else "."
    path.write_text(f"t [s];x [mm];R [Ohm]\n{cells}\n{cells.replace(f'0{point}5', f'0{point}9')}\n", encoding="utf-8")
    assert import_csv(path, Wish(40.0)).recording["resistance_ohm"][0] == value


@pytest.mark.parametrize("cells", ["0,5;1,5;1.234", "0.5;1.5;1,234"])
def test_thousands_that_nothing_proves_are_refused(tmp_path, cells):
    path = tmp_path / "lab.csv"
    path.write_text(f"t [s];x [mm];R [Ohm]\n{cells}\n{cells}\n")
    mark = "." if "1.234" in cells else ","
    said = rf"R \[Ohm\] must be a number, got '1.234'; if '\{mark}' parts thousands, say --thousands \{mark}"
    with pytest.raises(UserError, match=said):
        import_csv(path, Wish(40.0))
    with pytest.raises(UserError, match="time must increase"):
        import_csv(path, Wish(40.0, hints=Hints(thousands=mark)))


def test_force_and_resistance_are_a_recording_too(tmp_path, capsys):
    path = tmp_path / "film.csv"
    rows = "".join(f"{0.1 * n:.1f},{1 + np.sin(n / 9):.4f},{900 + 50 * np.sin(n / 9):.3f}\n" for n in range(300))
    path.write_text("Time (s),Force (N),R (kΩ)\n" + rows, encoding="utf-8")
    assert main(["import", str(path), "-o", str(tmp_path / "film")]) == 0
    assert main(["verify", str(tmp_path / "film")]) == 0
    recording = read_recording(tmp_path / "film")
    assert sorted(recording.channels) == ["force_N", "resistance_ohm"]
    assert json.loads((tmp_path / "film" / "datapackage.json").read_text())["knitbench"]["gauge_length_mm"] is None
    capsys.readouterr()
    assert main(["fit", str(tmp_path / "film"), "-o", str(tmp_path / "m.json")]) == 2
    assert "no displacement was recorded, and a model of the sensor needs it" in capsys.readouterr().err
    assert main(["report", "--recording", str(tmp_path / "film"), "-o", str(tmp_path / "r.html")]) == 0
    assert "Gauge length" not in (tmp_path / "r.html").read_text()


def test_the_gauge_length_is_asked_where_there_is_a_displacement(tmp_path):
    with pytest.raises(UserError, match="the gauge length is not known: say --gauge-length-mm"):
        import_csv(exports.testxpert(tmp_path), Wish())


def test_as_json(tmp_path, capsys):
    path = exports.testxpert(tmp_path)
    assert main(["import", str(path), "--gauge-length-mm", "40", "--json", "-o", str(tmp_path / "out")]) == 0
    (made,) = json.loads(capsys.readouterr().out)["recordings"]
    assert made["details"]["columns"]["resistance"]["unit"] == "kΩ"
    assert made["channels"]["resistance_ohm"][1] == pytest.approx(439_377.0)


@needs_foreign
@pytest.mark.real_data
def test_foreign_gbk_file_is_found_by_itself():
    done = import_csv(FOREIGN / "gbk-units-row.csv", Wish(50.0))
    assert sorted(done.recording.channels) == ["displacement_mm", "force_N"]
    assert done.recording["displacement_mm"].max() == pytest.approx(40.1032)


@needs_foreign
@pytest.mark.real_data
def test_foreign_electropuls_file_has_two_positions():
    path = FOREIGN / "electropuls-quoted-header.csv"
    with pytest.raises(UserError, match=r"column 7 .* and column 9 .* both fit displacement"):
        import_csv(path, Wish(50.0))
    done = import_csv(path, Wish(50.0, {"displacement": "7"}, zero={"displacement": None}, sort=True))
    assert done.recording["displacement_mm"][-1] == pytest.approx(20.0, abs=0.01)
    assert done.recording.mean_rate_hz == pytest.approx(0.25, rel=0.05)


@needs_foreign
@pytest.mark.real_data
@pytest.mark.parametrize("name", ["headerless-7-columns.csv", "bom-headerless-12-columns.csv"])
def test_foreign_files_without_header_are_asked_about(name):
    with pytest.raises(UserError, match=r"no header was found above the (7|12) columns"):
        import_csv(FOREIGN / name, Wish(50.0))


@needs_real
@pytest.mark.real_data
def test_measured_pulls_of_one_fabric_are_five_recordings():
    done = import_file(REAL / "knit_fabric_uniaxial" / "acrylic_yarn_garter_x.csv", Wish(91.6))
    assert [one.label for one in done] == ["1", "2", "3", "4", "5"]


def test_a_held_out_recording_beyond_the_calibrated_strain_is_said(capsys):
    from testbench.api.models.fitting import beyond_calibration
    from testbench.measurements.splitting import split
    from testbench.recordings.recording import Recording

    time_s = np.arange(0, 60, 0.1)
    stretch = np.sin(time_s / 3) ** 2
    parts = [
        Recording(time_s, {"displacement_mm": reach * stretch - 1e-3, "force_N": reach * stretch}, 40.0, name)
        for reach, name in ((4.0, "small"), (6.0, "large"))
    ]
    said = beyond_calibration(*split(*parts))
    assert said.startswith("large: the held-out strain, 0.0 to 15.0 %, leaves the 0.0 to 10.0 % that was fitted on")
    assert beyond_calibration(*split(*parts[::-1])) == ""
