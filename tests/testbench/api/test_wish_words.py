"""What is wrong with a foreign file is told in Python in the words of Python."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import testbench as tb
from testbench.api.files.importing import FIELDS, in_python

ROOT = Path(__file__).parents[3]


def lab(tmp_path: Path, *lines: str) -> Path:
    path = tmp_path / "lab.csv"
    path.write_text("\n".join(lines) + "\n")
    return path


def test_what_python_says_mends_what_python_asks(tmp_path):
    """It said ``--force-unit`` alone, which is no argument of anything in Python."""
    path = lab(tmp_path, "time_s,displacement_mm,Load", "0,0,1", "1,1,2", "2,2,3")
    with pytest.raises(tb.UserError, match=re.escape("--force-unit is units={'force': ...}")):
        tb.import_file(path, gauge_length_mm=25)
    found = tb.import_file(path, tb.Wish(gauge_length_mm=25, units={"force": "N"}))
    assert found.recording["force_N"].tolist() == [1, 2, 3]
    with pytest.raises(tb.UserError, match="--gauge-length-mm is gauge_length_mm="):
        tb.import_file(path, tb.Wish(units={"force": "N"}))


def test_doubts_are_told_in_python_too(tmp_path):
    path = lab(tmp_path, "time_s,displacement_mm,force_N", *(f"{k},{-k},{k}" for k in range(40)))
    doubts = [doubt for doubt in tb.import_file(path, gauge_length_mm=100).doubts if "--" in doubt]
    assert doubts
    assert all("in Python, of testbench.Wish:" in doubt for doubt in doubts)


@pytest.mark.parametrize(
    ("option", "field"),
    [
        ("--force 4", "--force is columns={'force': ...}"),
        ("--relative-unit %", "--relative-unit is units={'relative': ...}"),
        ("--relative-resistance 3", "--relative-resistance is columns={'relative': ...}"),
        ("--decimal ,", "--decimal is hints=Hints(decimal=...)"),
        ("--time-of force=3", "--time-of is time_of={'force': ...}"),
        ("--negate displacement", "--negate is negate={'displacement'}"),
        ("--drop-bad", "--drop-bad is drop_bad=True"),
        ("--rest-ohm R0", "--rest-ohm is r0_ohm=..."),
    ],
)
def test_every_kind_of_option_has_its_field(option, field):
    assert (
        in_python(f"say {option} or {option}") == f"say {option} or {option} (in Python, of testbench.Wish: {field})"
    )
    assert in_python("b.csv: no such file") == "b.csv: no such file"


@pytest.mark.parametrize("name", ["day--force.csv", "12--time 3.csv", "a.--sort.csv"])
def test_the_name_of_a_file_stays_as_it_is(name):
    message = f"/data/{name}: say --drop-bad"
    assert in_python(message) == f"{message} (in Python, of testbench.Wish: --drop-bad is drop_bad=True)"


def test_no_message_of_the_import_names_an_option_that_has_no_field():
    """Whatever option a message of testbench/importing names, Python's words for it are known."""
    sources = "\n".join(path.read_text() for path in (ROOT / "testbench" / "importing").rglob("*.py"))
    named = set(re.findall(r"(--[a-z][a-z0-9-]+)", sources))
    assert len(named) > 15
    assert not sorted(named - FIELDS.keys())
