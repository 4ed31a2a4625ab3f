"""The library of laws: dimensions, code, formulas, and that what is written is what was tried."""

from __future__ import annotations

import pickle
import re

import numpy as np
import pytest

from testbench.knit.filters import lowpass
from testbench.knit.memories import broad_memory, two_way_lag
from testbench.knit.rules import applied, check, example_signals
from testbench.proposing.grids import Grid
from testbench.proposing.laws.formulas import latex_of, plain
from testbench.proposing.laws.law import Law, Term
from testbench.proposing.laws.law_coordinates import COORDINATES, KINETICS
from testbench.proposing.laws.operators import OPERATORS
from testbench.proposing.laws.places import PLACES, READABLE
from testbench.proposing.laws.units import KELVIN, NEWTON, ONE, SECOND
from testbench.proposing.writing import effect_class

DT_S = 0.05
SIGNALS = example_signals(DT_S)
GRID = Grid(0.3, DT_S, 60.0, [np.sin(np.arange(1201) * DT_S)])
EVERY = {**COORDINATES, **KINETICS}


def law_of(place: str, coordinate: str, *operators: str, gain: float = 0.1) -> Law:
    """A law at the middle of its grid."""
    term = Term(EVERY[coordinate], (), 0.3)
    values = dict(next(iter(GRID.points(term.slots, None)))) if term.slots else {}
    for name in operators:
        x = term.evaluated(SIGNALS, values, DT_S)
        one = OPERATORS[name]
        points = list(GRID.points(one.slots, x, name))
        values |= points[len(points) // 2]
        term = Term(term.coordinate, (*term.operators, one), 0.3, (*term.sizes, 0.1))
    return Law(PLACES[place], term, values, gain)


def test_units_multiply_and_divide():
    assert str(NEWTON / SECOND) == "N/s"
    assert str(ONE / (NEWTON * SECOND)) == "1/(N s)"
    assert str(NEWTON * NEWTON) == "N^2"
    assert str(KELVIN / KELVIN) == "1"


@pytest.mark.parametrize(
    ("law", "unit"),
    [
        (law_of("conductance", "force", "lag"), "1/N"),
        (law_of("force", "strain rate"), "N s"),
        (law_of("force", "strain", "lag", "times force"), "1"),
        (law_of("conductance", "force rate", "square"), "s^2/N^2"),
        (law_of("conductance", "speed", "logarithm"), "1"),
    ],
)
def test_the_strength_has_the_unit_that_makes_the_sum_possible(law: Law, unit: str):
    assert str(law.unit) == unit


@pytest.mark.parametrize("coordinate", EVERY)
def test_every_coordinate_makes_an_effect_that_keeps_the_rules(coordinate: str):
    place = next(p for p in PLACES.values() if set(EVERY[coordinate].reads) - {"temperature_C"} <= READABLE[p.stage])
    law = law_of(place.name, coordinate)
    assert check(effect_class(law, "my_law", GRID)()) == []


@pytest.mark.parametrize("operator", [name for name in OPERATORS if name not in ("log", "power")])
def test_every_operator_makes_an_effect_that_keeps_the_rules(operator: str):
    coordinate = "conductance" if operator == "dead band" else "force" if operator == "ring" else "strain"
    law = law_of("conductance reading", coordinate, operator)
    effect = effect_class(law, "my_law", GRID)()
    sharp = {"dead band", "switch", "stick"}  # what jumps is late by up to a sample, and that is all that is allowed
    assert [p for p in check(effect) if operator not in sharp or "rate" not in p] == []


def test_effects_of_a_law_go_from_process_to_process():
    effect = effect_class(law_of("force", "work", "settling"), "my_law", GRID)()
    sent = pickle.loads(pickle.dumps(effect))
    assert type(sent) is type(effect)
    assert sent == effect


@pytest.mark.parametrize(
    "law",
    [
        law_of("strain", "largest strain", "threshold", gain=-0.1),
        law_of("force", "work", "settling", "times force", gain=-0.1),
        law_of("contact force", "strain", "sudden", gain=0.2),
        law_of("conductance", "state that forms with time and is wiped out by motion", "log"),
        law_of("conductance", "temperature", "lag"),
        law_of("force reading", "force", "late"),
    ],
    ids=lambda law: law.key,
)
def test_the_file_does_what_the_search_has_tried(law: Law):
    effect = effect_class(law, "my_law", GRID)()
    written = applied(effect, SIGNALS, DT_S)[law.place.writes]
    z = law.term.evaluated(SIGNALS, law.values, DT_S)
    before = SIGNALS[law.place.writes]
    expected = before * np.exp(law.strength * z) if law.place.writes == "conductance_S" else before + law.strength * z
    assert np.allclose(written, expected, rtol=1e-4, atol=1e-5 * np.ptp(before))


def test_a_formula_is_written_for_readers_with_and_without_a_typesetter():
    law = law_of("conductance", "state that forms with time and is wiped out by motion")
    assert r"\dot n = \frac{1}{\tau_1}\,(1 - n) - \frac{|\dot e|}{l_2}\,n" in latex_of(law)
    assert plain(law.term.definitions[0]) == "n' = (1 / tau_1) (1 - n) - (|e'| / l_2) n"


@pytest.mark.parametrize("name", [*EVERY, *OPERATORS])
def test_a_plain_formula_holds_nothing_of_the_typesetter(name: str):
    law = law_of("conductance", name) if name in EVERY else law_of("conductance", "speed", name)
    for line in (law.term.latex, *law.term.definitions):
        assert not set("{}\\") & set(plain(line))
        assert not re.search("frac|text|left|right|mathrm|quad|dots", plain(line))


def test_a_memory_over_decades_forgets_as_the_logarithm_of_time():
    step = np.ones(20_000)
    step[0] = 0.0
    y = broad_memory(step, 10.0, 3.0, 0.05)
    at_s = np.array([1.0, 10.0, 100.0])
    assert np.diff(np.interp(at_s, 0.05 * np.arange(len(step)), y)) == pytest.approx([1 / 3, 1 / 3], abs=0.05)


def test_a_memory_with_two_times_is_a_lag_where_they_are_one():
    x = SIGNALS["strain"]
    assert two_way_lag(x, 2.0, 2.0, DT_S) == pytest.approx(lowpass(x, 2.0, DT_S), abs=2e-3 * np.ptp(x))
    up = two_way_lag(np.r_[0.0, np.ones(100)], 1.0, 100.0, DT_S)
    down = two_way_lag(np.r_[1.0, np.zeros(100)], 1.0, 100.0, DT_S)
    assert up[-1] > 0.99
    assert down[-1] > 0.94


def test_the_file_says_what_its_symbols_are_and_where_it_is_valid():
    doc = str(effect_class(law_of("conductance", "force", "lag"), "my_law", GRID).__doc__)
    assert "Here F the force in N, G the conductance in S, G_0 at the start." in doc
    assert "strains up to 0.3 and within 60 s" in doc


def test_no_law_of_the_library_has_a_name_for_two_numbers():
    for coordinate in EVERY.values():
        assert len({slot.key for slot in coordinate.slots}) == len(coordinate.slots) <= 3
