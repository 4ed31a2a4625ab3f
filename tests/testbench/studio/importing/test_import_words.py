"""The import's page says its own fields where the command line says options."""

from __future__ import annotations

import argparse
import importlib
from pathlib import Path

import pytest

from testbench.studio.importing.import_form import Choices
from testbench.studio.importing.import_words import left_out_in_words, page_words

command = importlib.import_module("testbench.commands.import")


def flags() -> list[str]:
    parser = argparse.ArgumentParser()
    command.add_arguments(parser)
    return [flag for action in parser._actions for flag in action.option_strings if flag.startswith("--")]


@pytest.mark.parametrize("flag", sorted(set(flags()) - {"--help", "--json"}))
def test_every_option_has_a_field(flag):
    assert "--" not in page_words(f"row 3 is wrong; {flag} leaves it out; say {flag} 7, or add {flag}")


@pytest.mark.parametrize(
    ("said", "page"),
    [
        ("got nan; --drop-bad leaves them out", "got nan; “Leave out rows that cannot be used” leaves them out"),
        ("say --force-unit (N, mN)", "choose “Unit of force” (N, mN)"),
        ("say --time COL, or --rate-hz F where", "choose “Column of time”, or “Sampling rate / Hz” where"),
        ("add --negate displacement force", "choose “Turn the sign” at displacement force"),
        ("say which, e.g. --displacement 9 (or --displacement none)",
         "say which, e.g. “Column of displacement” (or “Column of displacement”)"),
        ("say --decimal , or --decimal .", "choose “Decimal sign” comma or “Decimal sign” point"),
        ("say --header-row 0 and", "choose “Header row” 0 and"),
    ],
)  # fmt: skip
def test_in_the_words_of_the_page(said, page):
    assert page_words(said).replace("or choose", "or") == page


def test_the_command_line_means_what_was_chosen(tmp_path: Path):
    choices = Choices(Path("lab.csv"), gauge_length_mm=40.0, drop_bad=True)
    choices.set_column("strain", "3")
    choices.set_column("displacement", "2")
    choices.units["displacement"] = "mm"
    choices.hints |= {"header_row": 0, "encoding": None}
    choices.negate |= {"displacement", "strain"}
    parser = argparse.ArgumentParser()
    command.add_arguments(parser)
    argv = choices.command(tmp_path / "lab", {"time", "displacement"})
    wish = command.wish_of(parser.parse_args(argv[2:]))
    assert wish.columns == {"displacement": "2"}
    assert wish.units == {"displacement": "mm"}
    assert wish.negate == {"displacement"}
    assert (wish.hints.header_row, wish.hints.encoding, wish.gauge_length_mm, wish.drop_bad) == (0, None, 40.0, True)


def test_what_was_chosen_for_a_column_that_was_not_taken_is_not_said(tmp_path: Path):
    choices = Choices(Path("lab.csv"), gauge_length_mm=40.0, rate_hz=10.0)
    choices.units |= {"displacement": "mm", "resistance": "kohm", "relative": "%"}
    choices.clocks |= {"force": "4", "relative": "5"}
    parser = argparse.ArgumentParser()
    command.add_arguments(parser)
    argv = choices.command(tmp_path / "lab", {"time", "displacement", "relative"})
    wish = command.wish_of(parser.parse_args(argv[2:]))
    assert {role: unit for role, unit in wish.units.items() if role != "relative_change"} == {
        "displacement": "mm",
        "relative": "%",
    }
    assert (wish.time_of, wish.rate_hz) == ({"relative": "5"}, None)


def test_a_clock_of_a_relative_resistance_has_the_name_of_its_column():
    parser = argparse.ArgumentParser()
    command.add_arguments(parser)
    words = ["lab.csv", "-o", "lab", "--relative-resistance", "3", "--time-of", "relative-resistance=4"]
    assert command.wish_of(parser.parse_args(words)).time_of == {"relative": "4"}


def test_a_file_that_the_uploader_leaves_out_is_told_why() -> None:
    said = left_out_in_words(
        [["accept", "notes.pdf"], ["max-files", "b.csv"], ["max-file-size", "c.csv"]], ".csv,.txt"
    )
    assert said == (
        "notes.pdf: no file of a kind that can be read (.csv, .txt); b.csv: left out, for one file is imported at a "
        "time; c.csv: too large for a browser; say where it is under “File on this machine”"
    )
