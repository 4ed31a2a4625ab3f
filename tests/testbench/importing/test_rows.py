"""Rows of a file: which are samples, which are whole, and where another table or test begins."""

from __future__ import annotations

import pytest

from gcode.support.errors import UserError
from testbench.importing.files import text_file
from testbench.importing.from_file import import_file
from testbench.importing.wish import Wish
from tests.testbench.importing.exports import import_csv


def written(folder, text):
    path = folder / "lab.csv"
    path.write_bytes(text.encode())
    return path


RATED = ["Displacement (mm),Force (N)", "0,0", "1,1", "2,2", "3,3"]


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r\r\n", "\n\n"])
def test_blank_lines_are_no_samples_of_a_rate(tmp_path, end):
    """A file with the ends of lines of two systems had half its rate, without a word."""
    recording = import_csv(written(tmp_path, end.join(RATED) + end), Wish(40.0, rate_hz=10.0)).recording
    assert recording.time_s.tolist() == pytest.approx([0, 0.1, 0.2, 0.3])


@pytest.mark.parametrize("lost", ["2,OL,2", "OL,2,2", ",,2", "NaN,NaN,2", "nan,NA,NaN"])
def test_a_row_that_is_left_out_was_a_sample_of_a_rate(tmp_path, lost):
    rows = ["Displacement (mm),Force (N),Cycle", "0,0,2", "1,1,2", lost, "3,3,2"]
    done = import_csv(written(tmp_path, "\n".join(rows)), Wish(40.0, rate_hz=10.0, drop_bad=True))
    assert done.recording.time_s.tolist() == pytest.approx([0, 0.1, 0.3])


def test_rows_of_no_number_between_others_are_no_blank_lines(tmp_path):
    """They were left out without a word, and what followed came too early."""
    rows = [*RATED[:2], "NaN,NaN", "", "NaN,NaN", *RATED[3:], "NaN,NaN"]
    path = written(tmp_path, "\n".join(rows) + "\n")
    with pytest.raises(UserError, match=r"row 3: displacement_mm must be a finite number, got nan \(2 such rows\)"):
        import_csv(path, Wish(40.0, rate_hz=10.0))
    done = import_csv(path, Wish(40.0, rate_hz=10.0, drop_bad=True))
    assert done.recording.time_s.tolist() == pytest.approx([0, 0.3, 0.4])
    assert done.dropped == 2


def blanks(*changed):
    rows = [f"  {0.1 * n:.1f}   {0.5 * n:.2f}   {0.2 * n:.2f}      {n // 3}" for n in range(8)]
    for at, row in changed:
        rows[at] = row
    return "Time(s)  Disp(mm)  Force(N)  Cycle\n" + "\n".join(rows) + "\n"


def test_a_missing_cell_between_blanks_does_not_move_the_others(tmp_path):
    """Force 0.4 was displacement, and the number of the cycle force, as nobody uses the last column."""
    path = written(tmp_path, blanks((2, "  0.2            0.40      0")))
    with pytest.raises(
        UserError, match=r"row 4: Time\(s\) must be a number, got '0.2 0.40 0 .fewer than 4 cells.*--drop"
    ):
        import_csv(path, Wish(40.0))
    recording = import_csv(path, Wish(40.0, drop_bad=True)).recording
    assert recording["force_N"].tolist() == pytest.approx([0, 0.2, 0.6, 0.8, 1.0, 1.2, 1.4])


COUNTED = ["Time (s),Displacement (mm),Force (N),Cycle", *(f"{n}.0,{5 * n}.0,{n}.5,{n // 5}" for n in range(40))]


@pytest.mark.parametrize("last", ["", ",", ",ok"])
@pytest.mark.parametrize(
    ("row", "said"),
    [
        ("2.0,103.0,0", "fewer"),  # the displacement was 103
        ("2.010.0,2.5,0", "fewer"),
        ("2.0,10.0,2", "fewer"),  # the force was 2
        ("2,0,10.0,2.5,0", "more"),
        ("2.0,10.0,1,#INF,0", "more"),  # the force was 1
    ],
)
def test_a_row_that_lost_a_separator_or_has_one_too_many_is_no_row(tmp_path, row, said, last):
    """Its cells stood in columns that are not theirs, without a word where nobody uses the last one."""
    lines = [line + last for line in COUNTED]
    lines[3] = row + last
    path = written(tmp_path, "\n".join(lines) + "\n")
    with pytest.raises(
        UserError, match=rf"row 4: .* must be a number, got '{row}.*{said} .*than \d cells\)'; --drop"
    ):
        import_csv(path, Wish(40.0))
    recording = import_csv(path, Wish(40.0, drop_bad=True)).recording
    assert recording["force_N"].tolist() == [n + 0.5 for n in range(40) if n != 2]


def test_a_file_that_was_cut_in_its_last_row(tmp_path):
    path = written(tmp_path, "\n".join(COUNTED)[:-3])
    with pytest.raises(UserError, match=r"row 41: .*got '39.0,195.0,39. .fewer than 4 cells"):
        import_csv(path, Wish(40.0))


def test_what_was_not_finite_is_seen_behind_the_last_column(tmp_path):
    path = written(tmp_path, "\n".join([*COUNTED[:9], "9.0,4.0,3.0,1,#INF", *COUNTED[10:]]))
    with pytest.raises(UserError, match=r"row 10: .*got '9.0,4.0,3.0,1,#INF .more than 4 cells"):
        import_csv(path, Wish(40.0, {"force": "4"}, {"force": "N"}))


@pytest.mark.parametrize("block", [lambda line: line.rpartition(",")[0], lambda line: f"{line},,,"])
def test_empty_cells_that_a_spreadsheet_leaves_out_or_adds_at_the_end_of_rows_shift_nothing(tmp_path, block):
    lines = [*COUNTED[:9], *map(block, COUNTED[9:25]), *COUNTED[25:]]
    lines[5] += ",,washed twice"
    recording = import_csv(written(tmp_path, "\n".join(lines)), Wish(40.0)).recording
    assert recording["force_N"].tolist() == [n + 0.5 for n in range(40)]


def test_a_column_that_ends_before_the_others_shifts_nothing(tmp_path):
    """As that of a slower clock does, or the last rows of a spreadsheet that have no remark."""
    lines = [*COUNTED[:-3], *(line.rpartition(",")[0] for line in COUNTED[-3:]), ""]
    assert len(import_csv(written(tmp_path, "\n".join(lines)), Wish(40.0)).recording) == 40


@pytest.mark.parametrize("remark", ['"one, two"', '2" wide, 3" long', '"so ""called"", it is"', "strip, cut"])
def test_a_remark_with_separators_and_quotation_marks_is_no_lost_cell(tmp_path, remark):
    lines = [*COUNTED[:5], f"{COUNTED[5]},{remark}", *COUNTED[6:]]
    assert len(import_csv(written(tmp_path, "\n".join(lines)), Wish(40.0)).recording) == 40


def test_cells_that_moved_are_seen_below_a_remark_of_two_lines(tmp_path):
    lines = [*COUNTED[:5], f'{COUNTED[5]},"washed\ntwice"', *COUNTED[6:20], "19,5,95.0,19.5,3", *COUNTED[21:]]
    with pytest.raises(UserError, match=r"row \d+: .*got '19,5,95.0,19.5,3 .more than 4 cells"):
        import_csv(written(tmp_path, "\n".join(lines)), Wish(40.0))
    lines[20] = COUNTED[20]
    assert len(import_csv(written(tmp_path, "\n".join(lines)), Wish(40.0)).recording) == 40


def test_words_in_quotation_marks_between_blanks_are_one_cell(tmp_path):
    lines = [f'{line.replace(",", " ")} "knit 1"' for line in COUNTED[1:]]
    path = written(tmp_path, "\n".join(["t_s x_mm F_N Cycle Specimen", *lines]))
    assert import_csv(path, Wish(40.0)).recording["force_N"].tolist() == [n + 0.5 for n in range(40)]


def test_the_unit_behind_a_name_that_says_nothing_is_read_where_a_person_says_what_it_is(tmp_path):
    path = written(tmp_path, "\n".join(["t_s,ext_cm,dms_mN", *(f"{n},{n},{n}" for n in range(9))]))
    recording = import_csv(path, Wish(40.0, {"displacement": "ext_cm", "force": "3"})).recording
    assert (recording["displacement_mm"][1], recording["force_N"][1]) == (10, 0.001)


def test_a_remark_between_blanks_is_no_other_table(tmp_path):
    path = written(tmp_path, blanks((2, "paused by an operator")))
    with pytest.raises(UserError, match=r"row 4: Time\(s\) must be a number, got 'paused'.*--drop"):
        import_csv(path, Wish(40.0))
    assert len(import_csv(path, Wish(40.0, drop_bad=True)).recording) == 7


def test_a_last_cell_that_is_no_number_and_a_blank_line_are_no_missing_cell(tmp_path):
    for last in ("  0.7   3.50   1.40      nan", ""):
        recording = import_csv(written(tmp_path, blanks((7, last))), Wish(40.0)).recording
        assert len(recording.time_s) == 8 - (not last)


def kiloohm(*below):
    return (
        "\n".join(["Time (s),Displacement (mm),R (kOhm)", "0,0,900", "1,1,901", *below, "2,2,902", "3,3,0.9"]) + "\n"
    )


@pytest.mark.parametrize(
    "again", ["Time (s),Displacement (mm),R (MOhm)", "Time,Displacement (mm),R (kOhm)", "No.,Pmax,Pmin"]
)
def test_names_with_one_other_unit_begin_another_table(tmp_path, again):
    """With --drop-bad the row of names was left out, and megaohms were read as kiloohms."""
    with pytest.raises(UserError, match="row 4 has other names or units"):
        import_csv(written(tmp_path, kiloohm(again)), Wish(40.0, drop_bad=True))


@pytest.mark.parametrize(
    "row", ["Time (s),Displacement (mm),R (kOhm)", "1.5,1.5,OL ohm", "end of force,,", "OL,OL,OL"]
)
def test_the_same_names_and_single_words_do_not(tmp_path, row):
    done = import_csv(written(tmp_path, kiloohm(row)), Wish(40.0, drop_bad=True))
    assert done.recording["resistance_ohm"].tolist() == [900_000, 901_000, 902_000, 900]


def timed(*times):
    return "\n".join(["Time (s),Displacement (mm),Force (N)", *(f"{t:.2f},{t:.2f},1" for t in times)]) + "\n"


FIRST = [0.1 * n for n in range(40)]


@pytest.mark.parametrize("start", [0.0, 0.03, 1.0])
@pytest.mark.parametrize("sort", [False, True])
@pytest.mark.parametrize("tests", [2, 3])
def test_two_tests_in_one_file_are_never_sorted_into_each_other(tmp_path, start, sort, tests):
    path = written(tmp_path, timed(*FIRST, *[start + t for t in FIRST] * (tests - 1)))
    with pytest.raises(UserError, match=r"row 42: .*the time starts again there.*part it into one file each"):
        import_csv(path, Wish(40.0, sort=sort))


def test_rows_that_came_late_are_sorted(tmp_path):
    late = [*FIRST[:5], *FIRST[18:], *FIRST[5:18]]
    done = import_csv(written(tmp_path, timed(*late)), Wish(40.0, sort=True))
    assert done.recording.time_s.tolist() == pytest.approx(FIRST)
    shuffled = [FIRST[7 * n % 40] for n in range(40)]
    done = import_csv(written(tmp_path, timed(*shuffled)), Wish(40.0, sort=True))
    assert done.recording.time_s.tolist() == pytest.approx(FIRST)
    one = [*FIRST[:5], *FIRST[6:30], FIRST[5], *FIRST[30:]]
    done = import_csv(written(tmp_path, timed(*one)), Wish(40.0, sort=True))
    assert done.recording.time_s.tolist() == pytest.approx(FIRST)


def test_a_sparse_temperature_can_be_left_out_and_not_only_its_rows(tmp_path):
    rows = "".join(f"{n},{n},{n},{25 if n % 10 == 0 else ''}\n" for n in range(30))
    path = written(tmp_path, "Time (s),Displacement (mm),Force (N),Temperature (C)\n" + rows)
    with pytest.raises(
        UserError, match=r"row 3: temperature_.*; --temperature none leaves the temperature out, --drop"
    ):
        import_csv(path, Wish(40.0))
    assert len(import_csv(path, Wish(40.0, {"temperature": "none"})).recording.time_s) == 30


@pytest.mark.parametrize(
    ("sign", "negate", "said"),
    [
        (-1, set(), "add --negate displacement force"),
        (1, {"displacement", "force"}, "leave --negate displacement force"),
    ],
)
def test_signs_that_were_turned_are_not_advised_to_be_turned_again(tmp_path, sign, negate, said):
    rows = "".join(f"{t:.2f},{sign * t:.2f},{2 * sign * t:.2f}\n" for t in FIRST)
    path = written(tmp_path, "Time (s),Displacement (mm),Force (N)\n" + rows)
    done = import_csv(path, Wish(40.0, negate=frozenset(negate)))
    assert any(said in doubt for doubt in done.doubts)


REMARKS = {
    "a remark": "paused by operator",
    "a remark behind a sign": "# paused by operator",
    "two remarks": "paused\nresumed; all is well",
    "no values": "---,---,---",
    "a meter out of range for a while": "\n".join(["2.55,OL,OL"] * 12),
    "a row cut short": "2.55",
}


@pytest.mark.parametrize("place", [2, 30])
@pytest.mark.parametrize("name", REMARKS)
def test_a_row_between_others_is_a_row_that_cannot_be_used(tmp_path, name, place):
    """Near the top it ended the table: no names were found, and the rows above it were left out without a word."""
    names, *rows = timed(*[0.1 * n for n in range(90)]).splitlines()
    path = written(tmp_path, "\n".join([names, *rows[: place - 1], *REMARKS[name].split("\n"), *rows[place - 1 :]]))
    with pytest.raises(UserError, match=rf"row {place + 1}: .*; --drop-bad leaves"):
        import_csv(path, Wish(40.0))
    done = import_csv(path, Wish(40.0, drop_bad=True))
    assert len(done.recording) == 90
    assert done.dropped == len(REMARKS[name].split("\n"))


def test_the_same_names_above_a_second_test_do_not_hide_the_first(tmp_path):
    first, again = timed(*FIRST[:20]), timed(*FIRST, *[0.1 * n for n in range(40, 99)])
    path = written(tmp_path, f"Test 1\n{first}\nTest 2\n{again}")
    done = import_file(path, Wish(40.0))
    assert [(one.label, len(one.recording)) for one in done] == [("1", 20), ("2", len(FIRST) + 59)]


def test_a_value_beyond_all_limits_is_named_by_its_row_in_the_file(tmp_path):
    """It was counted as if the names stood in row 1 and no row had been left out."""
    text = timed(*FIRST).replace("0.50,0.50,1", "x,,").replace("0.70,0.70,1", "0.70,900,1")
    with pytest.raises(UserError, match=r"row 11: a displacement of 900 mm"):
        import_csv(written(tmp_path, f"Title\n\n{text}"), Wish(40.0, drop_bad=True))


def test_whole_seconds_at_a_higher_rate_are_not_advised_to_be_sorted(tmp_path):
    """Following the advice left 3 of 60 rows."""
    rows = "".join(f"23:59:{57 + n // 20},{n},1\n" for n in range(60))
    path = written(tmp_path, "Time,Displacement (mm),Force (N)\n" + rows)
    with pytest.raises(
        UserError, match=r"57 of 60 rows have the time of the row above.* say --rate-hz F.*\(on average 20\)"
    ):
        import_csv(path, Wish(40.0))
    recording = import_csv(path, Wish(40.0, columns={"time": "none"}, rate_hz=20.0)).recording
    assert recording.time_s[[0, 1, -1]].tolist() == pytest.approx([0, 0.05, 2.95])
    seldom = timed(*FIRST, FIRST[-1])
    with pytest.raises(UserError, match="; --sort puts rows in order and drops repeated times"):
        import_csv(written(tmp_path, seldom), Wish(40.0))


@pytest.mark.parametrize(
    ("names", "units", "cell"), [(f"Force {'x' * 200} [N]", "", "OL"), ("Force", f"s,mm,{'x' * 5000}\n", "1")]
)
def test_names_and_units_are_shown_short(tmp_path, names, units, cell):
    path = written(tmp_path, f"Time [s],Displacement [mm],{names}\n{units}0,0,1\n1,1,{cell}\n2,2,2\n3,3,3\n")
    with pytest.raises(UserError, match="x…") as caught:
        import_csv(path, Wish(40.0))
    assert len(str(caught.value)) < 300 + len(str(path))


def test_rows_that_leave_out_what_is_empty_are_not_looked_at_one_by_one(tmp_path, monkeypatch):
    """A file whose notes end early was read ten times as slowly."""
    rows = [f"{n},{n % 7},{n % 5}{',x' * (n < 300)}" for n in range(1000)]
    path = written(tmp_path, "\n".join(["Time (s),Extension (mm),Load (N),Note", *rows]))
    lines, split = [], text_file._split
    monkeypatch.setattr(text_file, "_split", lambda some, separator: lines.extend(some) or split(some, separator))
    assert len(import_csv(path, Wish(40.0)).recording) == 1000
    assert max(lines.count(row) for row in rows[300:]) == 0
