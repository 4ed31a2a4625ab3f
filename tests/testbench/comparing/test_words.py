"""Where a model fails, told in one unit a quantity."""

from __future__ import annotations

import math

import pytest

from testbench.comparing.cell import Cell
from testbench.comparing.words import no_place_in_words, place_in_words


def cell(low: float, high: float, direction: int = 0, mean: float = -0.1) -> Cell:
    return Cell(low, high, direction, mean, 0.01, 0.1)


@pytest.mark.parametrize(
    ("coordinate", "there", "words"),
    [
        ("strain", cell(0.04, 0.05, 1), "between 4.00 and 5.00 % strain while stretching"),
        (
            "largest_strain",
            cell(0.04, 0.05, -1),
            "when the knit has seen at most 4.00 to 5.00 % strain while releasing",
        ),
        ("strain_rate", cell(0.01, 0.02), "at strain rates of 1.00 to 2.00 %/s (stretching)"),
        ("strain_rate", cell(-0.02, -0.01), "at strain rates of -2.00 to -1.00 %/s (releasing)"),
        ("elapsed_s", cell(966, 1103), "from 970 to 1100 s after the start"),
        ("since_reversal_s", cell(0.5, 1.5, 1), "0.50 to 1.50 s after a reversal while stretching"),
        ("since_hold_s", cell(2, 4), "2.00 to 4.00 s into a hold"),
        ("cycle", cell(2, 4), "in cycles 2 to 4"),
        ("temperature_C", cell(20, 22.5), "between 20.0 and 22.5 °C"),
    ],
)
def test_places_are_told_in_one_unit_a_quantity(coordinate: str, there: Cell, words: str) -> None:
    told = place_in_words("force", coordinate, there)
    assert told == f"modelled force is 0.10 N too high {words}"


@pytest.mark.parametrize(
    ("measured_over_modelled", "words"), [(1.25, "20.0 % too low"), (0.8, "25.0 % too high"), (4.0, "75.0 % too low")]
)
def test_a_modelled_conductance_is_off_by_a_share_of_the_measured(measured_over_modelled: float, words: str) -> None:
    told = place_in_words("conductance", "cycle", cell(0, 1, mean=math.log(measured_over_modelled)))
    assert told.startswith(f"modelled conductance is {words}")


def test_an_error_without_a_place_is_not_called_noise() -> None:
    quick = {"force": 1.0, "conductance": 0.9}
    assert no_place_in_words({"force": 1.05, "conductance": 1.1}, quick) == "no place stands out from the noise"
    assert no_place_in_words({"force": 1.0, "conductance": 12.2}, quick) == (
        "the error of the conductance is spread out or in a few peaks: no single place can be named"
    )
    assert no_place_in_words({"force": 1.0, "conductance": 12.2}, {"force": 1.0, "conductance": 12.0}) == (
        "the error of the conductance comes and goes too quickly for any effect: a hum, or coloured noise"
    )
