"""Pages that promise to be complete are."""

from __future__ import annotations

import importlib
import re
import tomllib
from pathlib import Path
from typing import get_args

import pytest

from gcode.trajectories.designed import AnyPiece

DOCS = Path(__file__).parents[2] / "docs"


def test_decisions_have_numbers_without_gaps_and_a_line_in_the_index():
    pages = sorted((DOCS / "decisions").glob("0*.md"))
    assert [int(page.name[:4]) for page in pages] == list(range(1, len(pages) + 1))
    index = (DOCS / "decisions" / "index.md").read_text(encoding="utf-8")
    for page in pages:
        number, title = re.match(r"# (\d{4}): (.+)", page.read_text(encoding="utf-8")).groups()
        assert number == page.name[:4]
        assert f"| {number} | [{title}]({page.name}) |" in index


def test_the_map_names_every_room_that_the_contracts_name():
    told = (DOCS / "architecture.md").read_text(encoding="utf-8")
    settings = tomllib.loads((DOCS.parent / "pyproject.toml").read_text(encoding="utf-8"))
    floors = [one for one in settings["tool"]["importlinter"]["contracts"] if "containers" in one]
    rooms = {room for one in floors for layer in one["layers"] for room in layer.split(" | ")}
    assert len(rooms) > 30
    assert {room for room in rooms if not re.search(rf"^ +[a-z, ]*\b{room}\b", told, re.MULTILINE)} == set()


def test_every_setting_of_a_piece_of_a_motion_is_on_its_page():
    rows = re.findall(r"^\| `(\w+)` \|.*\| (`.*) \|$", (DOCS / "gcode.md").read_text(encoding="utf-8"), re.MULTILINE)
    told = {kind: set(re.findall(r"`(\w+)`", settings)) for kind, settings in rows}
    pieces = get_args(get_args(AnyPiece)[0])
    assert told == {one.model_fields["kind"].default: set(one.model_fields) - {"kind"} for one in pieces}


@pytest.mark.parametrize(
    ("simulators", "said"), [("second|third", "first in {} cases"), ("fourth", "and in {} of a")]
)
def test_the_first_page_counts_the_cases_of_the_benchmark(simulators, said):
    """All rows of a simulator are summed; shares are of whole cases. Eight seeds of the first two are one row."""
    before = "|eight before" if "second" in simulators else ""
    rows = re.findall(
        rf"^\| (?:`(?:{simulators})`{before}).*?\| (?:(\d+) % of (\d+)|(\d+) of (\d+)) \|",
        (DOCS / "benchmark-diagnosis.md")
        .read_text(encoding="utf-8")
        .partition("## Fresh seeds")[2]
        .partition("##")[0],
        re.MULTILINE,
    )
    right = sum(round(int(share) * int(of) / 100) if share else int(count) for share, of, count, _ in rows)
    cases = sum(int(of or of_few) for _, of, _, of_few in rows)
    readme = (DOCS.parent / "README.md").read_text(encoding="utf-8")
    assert said.format(f"{right} of {cases}") in " ".join(readme.split())


@pytest.mark.parametrize("package", ["gcode", "testbench", "compensation"])
def test_every_public_name_is_in_the_reference(package):
    told = (DOCS / "reference" / f"{package}.md").read_text(encoding="utf-8")
    names = set(importlib.import_module(package).__all__) - {"UserError"}  # told once, with testbench
    assert {name for name in names if not re.search(rf"{package}\.{name}\b", told)} == set()
