"""The columns of a recording: what is no number is refused, and shown short."""

from __future__ import annotations

import pytest

from gcode.support.errors import UserError
from testbench.recordings.csv_columns import read_columns


def test_true_and_false_are_no_numbers(tmp_path):
    path = tmp_path / "r.csv"
    path.write_text("time_s,displacement_mm,force_N\n0,0.1,True\n1,0.2,False\n2,0.3,True\n")
    with pytest.raises(UserError, match="row 2: force_N must be a number, got 'True'"):
        read_columns(path)


def test_a_long_cell_is_shown_short(tmp_path):
    path = tmp_path / "r.csv"
    path.write_text(f"time_s,displacement_mm,force_N\n0,0.1,1\n1,0.2,{'1' * 5000}\n2,0.3,2\n")
    with pytest.raises(UserError, match=r"row 3: force_N must be a number, got '1+; ") as caught:
        read_columns(path)
    assert len(str(caught.value)) < 300 + len(str(path))


def test_a_name_that_would_fill_every_message_is_refused(tmp_path):
    path = tmp_path / "r.csv"
    path.write_text(f"time_s,displacement_mm,{'x' * 5000}\n0,0.1,1\n1,0.2,2\n")
    with pytest.raises(UserError, match="row 1 names a column in 5000 characters; a name has at most 300"):
        read_columns(path)
