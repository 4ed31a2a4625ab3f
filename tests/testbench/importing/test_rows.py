"""Rows of a file: which are samples, which are whole, and where another table or test begins."""

from __future__ import annotations

import pytest

from gcode.support.errors import UserError
from testbench.importing.from_file import import_csv
from testbench.importing.wish import Wish


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


@pytest.mark.parametrize("lost", ["2,OL,2", "OL,2,2", ",,2"])
def test_a_row_that_is_left_out_was_a_sample_of_a_rate(tmp_path, lost):
    rows = ["Displacement (mm),Force (N),Cycle", "0,0,2", "1,1,2", lost, "3,3,2"]
    done = import_csv(written(tmp_path, "\n".join(rows)), Wish(40.0, rate_hz=10.0, drop_bad=True))
    assert done.recording.time_s.tolist() == pytest.approx([0, 0.1, 0.3])


def blanks(*changed):
    rows = [f"  {0.1 * n:.1f}   {0.5 * n:.2f}   {0.2 * n:.2f}      {n // 3}" for n in range(8)]
    for at, row in changed:
        rows[at] = row
    return "Time(s)  Disp(mm)  Force(N)  Cycle\n" + "\n".join(rows) + "\n"


def test_a_missing_cell_between_blanks_does_not_move_the_others(tmp_path):
    """Force 0.4 was displacement, and the number of the cycle force, as nobody uses the last column."""
    path = written(tmp_path, blanks((2, "  0.2            0.40      0")))
    with pytest.raises(
        UserError, match=r"row 4: Time\(s\) must be a number, got '0.2 0.4 0.*fewer than 4 cells.*--drop"
    ):
        import_csv(path, Wish(40.0))
    recording = import_csv(path, Wish(40.0, drop_bad=True)).recording
    assert recording["force_N"].tolist() == pytest.approx([0, 0.2, 0.6, 0.8, 1.0, 1.2, 1.4])


def test_what_stands_or_stands_not_behind_the_columns_is_no_missing_cell(tmp_path):
    for last in ("  0.7   3.50   1.40      nan", ""):
        recording = import_csv(written(tmp_path, blanks((7, last))), Wish(40.0)).recording
        assert len(recording.time_s) == 8 - (not last)
    unnamed = blanks().replace("Cycle", "Cycle  Note")
    assert len(import_csv(written(tmp_path, unnamed), Wish(40.0)).recording.time_s) == 8
