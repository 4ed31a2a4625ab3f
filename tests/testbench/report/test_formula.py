"""Formulas as pictures: every law of the proposer's library can be drawn; what cannot is left to words."""

from __future__ import annotations

import re

import pytest

from testbench.proposing.laws.law_coordinates import COORDINATES, KINETICS
from testbench.proposing.laws.places import PLACES
from testbench.report.formula import formula_svg, lines_of


def test_formula_and_definitions_stand_in_lines_of_their_own():
    assert lines_of(r"F \mathrel{+}= a\,z,\quad z = n,\quad \dot n = 1 - n") == [
        r"F \mathrel{+}= a\,z",
        "z = n",
        r"\dot n = 1 - n",
    ]


@pytest.mark.parametrize("place", PLACES.values(), ids=str)
def test_every_place_can_be_drawn(place):
    assert re.match(r"<svg .*</svg>\s*$", formula_svg(rf"{place.latex} \mathrel{{+}}= a\,z"), re.DOTALL)


def test_every_coordinate_can_be_drawn():
    for one in [*COORDINATES.values(), *KINETICS.values()]:
        assert formula_svg(f"z = {one.latex}"), one.name


def test_words_keep_the_spaces_between_them():
    apart, together = (formula_svg(rf"y = \text{{{words}}}") for words in ("mean of all ", "meanofall"))
    assert _width(apart) > 1.1 * _width(together)


def _width(svg: str) -> float:
    return float(re.search(r'width="([0-9.]+)pt"', svg)[1])


@pytest.mark.parametrize("line", [r"\unknown{", "a$b", "x" * 500])
def test_what_cannot_be_drawn_is_empty(line: str):
    assert formula_svg(line) == ""
