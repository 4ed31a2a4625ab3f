"""What is wrong with a foreign file is told in Python in the words of Python."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import testbench as tb
from testbench.api.files.wish_words import in_python

ROOT = Path(__file__).parents[3]
FIELDS = " (testbench.Wish has these fields)"


def lab(tmp_path: Path, *lines: str) -> Path:
    path = tmp_path / "lab.csv"
    path.write_text("\n".join(lines) + "\n")
    return path


def test_what_python_says_mends_what_python_asks(tmp_path):
    """It said ``--force-unit``, which is no argument of anything in Python."""
    path = lab(tmp_path, "time_s,displacement_mm,Load", "0,0,1", "1,1,2", "2,2,3")
    with pytest.raises(tb.UserError, match=re.escape("say units={'force': ...} (N,")) as caught:
        tb.import_file(path, gauge_length_mm=25)
    assert "--" not in str(caught.value)
    found = tb.import_file(path, tb.Wish(gauge_length_mm=25, units={"force": "N"}))
    assert found.recording["force_N"].tolist() == [1, 2, 3]
    with pytest.raises(tb.UserError, match="say gauge_length_mm, the length between the clamps"):
        tb.import_file(path, tb.Wish(units={"force": "N"}))


def test_doubts_are_told_in_python_too(tmp_path):
    path = lab(tmp_path, "time_s,displacement_mm,force_N", *(f"{k},{-k},{k}" for k in range(40)))
    doubts = tb.import_file(path, gauge_length_mm=100).doubts
    assert doubts
    assert not [doubt for doubt in doubts if "--" in doubt]


@pytest.mark.parametrize(
    ("command", "python"),
    [
        (
            "say which, --force 4 (or --force none)",
            "say which, columns={'force': '4'} (or columns={'force': 'none'})",
        ),
        ("say --time COL, or --rate-hz F where", "say columns={'time': ...}, or rate_hz=... where"),
        ("say --decimal , or --decimal .", "say hints=Hints(decimal=',') or hints=Hints(decimal='.')"),
        ("say --thousands ,; if", "say hints=Hints(thousands=','); if"),
        ("say which one with --sheet NAME", "say which one with hints=Hints(sheet=...)"),
        ("say --relative-unit %", "say units={'relative': '%'}"),
        ("--relative-resistance 3", "columns={'relative': '3'}"),
        ("where a channel has its own, --time-of force=3", "where a channel has its own, time_of={'force': '3'}"),
        ("add --zero displacement to", "add zero={'displacement': None} to"),
        ("--zero force= needs a number", "zero['force'] needs a number"),
        ("leave --negate force out", "leave negate={'force'} out"),
        ("--negate can be said of force", "negate can be said of force"),
        ("--drop-bad leaves such rows out", "drop_bad=True leaves such rows out"),
        ("say --rest-ohm R0 in Ω", "say r0_ohm=... in Ω"),
    ],
)
def test_every_kind_of_option_has_its_field(command, python):
    assert in_python(command) == python + FIELDS
    assert in_python("b.csv: no such file") == "b.csv: no such file"


@pytest.mark.parametrize("name", ["day--force.csv", "12--time 3.csv", "a.--sort.csv"])
def test_the_name_of_a_file_stays_as_it_is(name):
    """``day--force.csv`` was told as ``daycolumns={'force': ...}.csv``."""
    assert in_python(f"/data/{name}: say --sort") == f"/data/{name}: say sort=True{FIELDS}"


def test_no_message_of_the_import_names_an_option_that_has_no_field():
    """Whatever option a message of testbench/importing names, Python's words for it are known."""
    sources = "\n".join(path.read_text() for path in (ROOT / "testbench" / "importing").rglob("*.py"))
    named = set(re.findall(r"(--[a-z][a-z0-9-]+)", sources))
    assert len(named) > 15
    assert not [flag for flag in named if "--" in in_python(f"say {flag} force")]
