"""Habits of testers and loggers: a unit before the name, lines that ran together, noise, marks that quote nothing."""

from __future__ import annotations

import numpy as np
import pytest

from gcode.support.errors import UserError
from testbench.importing.sheet import Hints
from testbench.importing.vocabulary.headings import read_heading
from testbench.importing.wish import Wish
from tests.testbench.importing.exports import import_csv

TIME_S = np.round(0.1 * np.arange(40), 1)
ROWS = [f"{time_s},{0.5 * n % 7},{0.2 + 0.5 * n % 7:.1f}" for n, time_s in enumerate(TIME_S)]
HEADER = "Time [s],Extension [mm],Load [N]"


def _lines(path, *lines: str, encoding: str = "utf-8"):
    path.write_bytes(("\n".join(lines) + "\n").encode(encoding))
    return path


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        ("% dR/R0", "%"),
        ("%ΔR/R0", "%"),
        ("Percent change in resistance", "%"),
        ("% of strain", "%"),
        ("pct_strain", "%"),
        ("% t/s", "s"),
        ("% Force [N]", "N"),
    ],
)
def test_a_unit_may_stand_before_the_name(text, unit):
    heading = read_heading(text)
    found = heading.unit(heading.unit_text)
    assert found is not None
    assert found.symbol == unit


@pytest.mark.parametrize("text", ["100 x dR/R0", "100*dR/R0", "100·ΔR/R0", "R / 10³ Ω", "% Strain [mm/mm]"])
def test_a_power_before_the_name_and_two_units_leave_none(text):
    heading = read_heading(text)
    assert heading.roles
    assert heading.unit_text
    assert heading.unit(heading.unit_text) is None


def test_a_change_in_percent_is_not_taken_for_a_share(tmp_path):
    rows = [f"{time_s},{0.01 * n},{0.1 * n}" for n, time_s in enumerate(TIME_S)]
    path = _lines(tmp_path / "film.csv", "Time [s],Extension [mm],% dR/R0", *rows)
    found = import_csv(path, Wish(40.0, r0_ohm=100.0)).recording
    assert found["resistance_ohm"] == pytest.approx(100 + 0.1 * np.arange(40))


@pytest.mark.parametrize("hints", [Hints(), Hints(header_row=0)])
def test_lines_that_ran_together_are_no_row_even_at_the_top(tmp_path, hints):
    lines = [*ROWS[:9], "0.9,4.5,1.0,5.0,5.2", *ROWS[11:]]
    path = _lines(tmp_path / "serial.csv", HEADER, *lines)
    columns = {"time": "1", "displacement": "2", "force": "3"} if hints.header_row == 0 else {}
    units = {"time": "s", "displacement": "mm", "force": "N"} if columns else {}
    with pytest.raises(UserError, match=r"row 11: .* must be a number, got '0.9,4.5,1.0,5.0,5.2 .more than 3 cells"):
        import_csv(path, Wish(40.0, columns, units, hints=hints))
    found = import_csv(path, Wish(40.0, columns, units, drop_bad=True, hints=hints))
    assert (found.dropped, len(found.recording)) == (1, 38)


def test_a_mark_that_quotes_nothing_hides_no_rows(tmp_path):
    lines = list(ROWS)
    lines[10] += ',"slipped'
    lines[20] += ',"gone on'
    path = _lines(tmp_path / "notes.csv", f"{HEADER},Note", *lines)
    for wish in (Wish(40.0), Wish(40.0, drop_bad=True)):
        with pytest.raises(UserError, match="a quotation mark in row 12 is closed only in row 22"):
            import_csv(path, wish)
    lines[10], lines[20] = f'{ROWS[10]},"two\nlines"', f'{ROWS[20]},"2" wide"'
    path = _lines(tmp_path / "notes.csv", f"{HEADER},Note", *lines)
    assert len(import_csv(path, Wish(40.0)).recording) == 40


def test_noise_of_a_port_before_the_table_is_passed_over_and_within_it_refused(tmp_path):
    path = _lines(tmp_path / "serial.txt", "\x93\xfe\x00\x82", "\xff12,3.4,5", HEADER, *ROWS, encoding="latin-1")
    for hints in (Hints(), Hints(encoding="latin-1")):
        assert len(import_csv(path, Wish(40.0, hints=hints)).recording) == 40
    lines = [*ROWS[:20], "2.0,\x81\x02,4\x00.1", *ROWS[21:]]
    path = _lines(tmp_path / "serial.txt", HEADER, *lines, encoding="latin-1")
    with pytest.raises(UserError, match="row 22: "):
        import_csv(path, Wish(40.0))
    assert import_csv(path, Wish(40.0, drop_bad=True)).dropped == 1


def test_a_column_at_the_end_that_nobody_filled_shifts_nothing_where_tabs_part_the_names(tmp_path):
    rows = [row.replace(",", "\t") for row in ROWS]
    head = ["LabVIEW Measurement", "Y_Unit_Label\tmm\tN", "***End_of_Header***\t\t\t"]
    path = _lines(tmp_path / "lab.lvm", *head, "X_Value\tDisplacement\tForce\tComment", *rows)
    said = {"columns": {"time": "X_Value"}, "units": {"time": "s"}}
    found = import_csv(path, Wish(40.0, **said, hints=Hints(units_row=2, header_row=4)))
    assert found.recording["force_N"][1] == pytest.approx(0.7)
    path = _lines(tmp_path / "lab.csv", "Time [s],Extension [mm],Load [N],cell 2", *ROWS)
    with pytest.raises(UserError, match="row 1 has 4 names, the rows of numbers below it 3 columns"):
        import_csv(path, Wish(40.0))


def test_a_part_of_the_time_is_no_time_to_sort_by(tmp_path):
    rows = [f"{n // 5},{200 * (n % 5)},{0.5 * n}" for n in range(40)]
    path = _lines(tmp_path / "logger.csv", "No,Time [ms],Extension [mm]", *rows)
    with pytest.raises(UserError, match=r"the time falls back 7 times, and 35 of 40 rows .* say --time COL"):
        import_csv(path, Wish(40.0))


@pytest.mark.parametrize("row", ["[{time_s}, {n}]", "(t={time_s}) moved by x={n}"])
def test_what_else_stands_in_the_cells_is_told(tmp_path, row):
    path = _lines(tmp_path / "lab.txt", *(row.format(time_s=time_s, n=n) for n, time_s in enumerate(TIME_S)))
    with pytest.raises(UserError, match="words and brackets in the cells are to be taken out"):
        import_csv(path, Wish(40.0))


@pytest.mark.parametrize(
    "header",
    [
        "Temps (s),Déplacement (mm),Force (daN)",
        "Tempo [s],Spostamento [mm],Forza [daN]",
        "Tiempo [s],Desplazamiento [mm],Fuerza [daN]",
        "Zeit [s],Verformung [mm],Kraft [daN]",
    ],
)
def test_plain_words_of_other_languages(tmp_path, header):
    found = import_csv(_lines(tmp_path / "lab.csv", header, *ROWS), Wish(40.0)).recording
    assert found["displacement_mm"][1] == pytest.approx(0.5)
    assert found["force_N"][1] == pytest.approx(7.0)


@pytest.mark.parametrize("name", ["Maximalkraft", "Höchstkraft", "Force maximale", "Vitesse de déplacement"])
def test_words_about_a_quantity_are_not_the_quantity(name):
    assert not read_heading(f"{name} [N]").roles


def test_days_since_an_epoch_are_a_time(tmp_path):
    rows = [f"{46_082.5 + time_s / 86_400:.9f},{n},{n}" for n, time_s in enumerate(TIME_S)]
    path = _lines(tmp_path / "sheet.csv", "Date/Time,Extension [mm],Load [N]", *rows)
    found = import_csv(path, Wish(40.0, units={"time": "d"})).recording
    assert found.time_s == pytest.approx(TIME_S, abs=1e-4)


def test_a_row_of_results_among_the_samples_is_said(tmp_path):
    path = _lines(tmp_path / "lab.csv", HEADER, *ROWS, "", "40,3.2,4.1")
    (doubt,) = import_csv(path, Wish(40.0)).doubts
    assert doubt.startswith("between row 41 and row 43 there is no sample for 36.1 s of the 40 s")
    path = _lines(tmp_path / "lab.csv", HEADER, *ROWS)
    assert import_csv(path, Wish(40.0)).doubts == []


@pytest.mark.parametrize("again", [[HEADER], ["\ufeff" + HEADER], ["Time,Extension,Load", "[s],[mm],[N]"]])
def test_names_and_units_once_more_are_no_other_table(tmp_path, again):
    """A row of the same units was said to be one of others, and so was a name behind the mark of a second file."""
    path = _lines(tmp_path / "lab.csv", *again, *ROWS[:20], *again, *ROWS[20:])
    done = import_csv(path, Wish(40.0))
    assert (done.dropped, len(done.recording)) == (0, 40)
    first = len(again) + 21
    assert f"no samples: row {first} and others, where the names stand once more" in done.notes
    path = _lines(tmp_path / "lab.csv", *again, *ROWS[:20], "[s],[N],[mm]", *ROWS[20:])
    with pytest.raises(UserError, match="another table begins there"):
        import_csv(path, Wish(40.0, drop_bad=True))


def test_a_row_of_units_may_be_a_comment(tmp_path):
    path = _lines(tmp_path / "script.csv", "# Time, Extension, Load", "# s, mm, N", *ROWS)
    assert import_csv(path, Wish(40.0)).recording["force_N"][1] == pytest.approx(0.7)


def test_blanks_may_stand_behind_a_sign(tmp_path):
    rows = [f"{time_s},+  {0.5 * n % 7},-   {0.2 + 0.5 * n % 7:.1f}" for n, time_s in enumerate(TIME_S)]
    found = import_csv(_lines(tmp_path / "graphtec.csv", HEADER, *rows), Wish(40.0)).recording
    assert found["displacement_mm"][1] == pytest.approx(0.5)
    assert found["force_N"][1] == pytest.approx(-0.7)


def test_a_zero_that_was_set_anew_is_said(tmp_path):
    rows = [f"{n},{0.1 * n - 2.0 * (n >= 20):.1f},{0.1 * n:.1f}" for n in range(40)]
    (doubt,) = import_csv(_lines(tmp_path / "lab.csv", HEADER, *rows), Wish(40.0)).doubts
    assert doubt.startswith("between row 21 and row 22 the displacement jumps by -1.9 mm, and the force does not")
    force_too = [f"{n},{0.1 * n + 2.0 * (n >= 20):.1f},{0.1 * n + 2.0 * (n >= 20):.1f}" for n in range(40)]
    one_step = [f"{n},{0.048 * (n >= 2)},{n % 3}" for n in range(40)]
    for rows in (force_too, one_step):
        assert import_csv(_lines(tmp_path / "lab.csv", HEADER, *rows), Wish(40.0)).doubts == []


def test_what_stands_beside_the_table_in_its_first_rows_is_none_of_it(tmp_path):
    for header in (HEADER, f"{HEADER},,Mean load,3.2"):
        path = _lines(tmp_path / "lab.csv", header, f"{ROWS[0]},,max,6.8", f"{ROWS[1]},,min,0.2", *ROWS[2:])
        assert len(import_csv(path, Wish(40.0)).recording) == 40


@pytest.mark.parametrize("separator", [",", ";", "\t", " "])
def test_the_stamps_of_a_serial_monitor_are_a_column_of_their_own(tmp_path, separator):
    stamps = [f"10:00:0{n // 10}.{n % 10}00 -> " for n in range(40)]
    rows = [row.replace(",", separator) for row in ROWS]
    header = "Time_s,Extension_mm,Load_N".replace(",", separator)
    lines = [f"{stamp}{row}" for stamp, row in zip(["10:00:00.000 -> ", *stamps], [header, *rows], strict=True)]
    path = _lines(tmp_path / "serial.log", *lines)
    assert import_csv(path, Wish(40.0)).recording.time_s == pytest.approx(TIME_S)
    found = import_csv(path, Wish(40.0, {"time": "1"})).recording
    assert found.time_s == pytest.approx(TIME_S)
    assert found["force_N"][1] == pytest.approx(0.7)
    lines[5] = lines[5].replace(separator, f" -> {separator}", 1)
    with pytest.raises(UserError, match="row 6: "):
        import_csv(_lines(tmp_path / "serial.log", *lines), Wish(40.0))


@pytest.mark.parametrize("separator", [",", ";", "\t", " "])
def test_the_end_of_a_text_of_dos_is_no_row(tmp_path, separator):
    lines = [line.replace(",", separator) for line in ("Time_s,Extension_mm,Load_N", *ROWS)]
    path = tmp_path / "logger.dat"
    path.write_bytes("\r\n".join([*lines, "\x1a"]).encode())
    done = import_csv(path, Wish(40.0))
    assert (len(done.recording), done.dropped) == (40, 0)
