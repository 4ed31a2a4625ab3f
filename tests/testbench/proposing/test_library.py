"""The library of laws: dimensions, code, formulas, and that what is written is what was tried."""

from __future__ import annotations

import pickle
import re
from dataclasses import replace

import numpy as np
import pytest

from testbench.knit.filters import lowpass
from testbench.knit.memories import (
    broad_memory,
    ever_later,
    gathered,
    heading,
    last_top,
    no_quicker,
    seconds_near,
    turning,
    two_way_lag,
)
from testbench.knit.rules import READABLE, applied, check, example_signals
from testbench.proposing.grids import LATE_S, MOST_SKEW, Grid
from testbench.proposing.laws.formulas import latex_of, plain
from testbench.proposing.laws.law import Law, Term
from testbench.proposing.laws.law_coordinates import COORDINATES, KINETICS
from testbench.proposing.laws.operators import OPERATORS
from testbench.proposing.laws.places import PLACES
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


@pytest.mark.parametrize("skew", [-0.03, 0.03])
def test_a_clock_may_be_fast_and_keeps_the_rules(skew: float):
    law = law_of("conductance reading", "conductance", "clock")
    effect = effect_class(replace(law, values={"skew": skew}), "my_law", GRID)()
    assert effect.model_dump()["skew"] == skew
    assert check(effect) == []


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


def test_a_conductance_may_be_changed_by_a_path_beside_it_or_a_resistance_in_series():
    """Each adds up in its own unit, and with what the search takes for its trace in ln G."""
    ln_g, beside, in_series = law_of("conductance", "strain", "lag", gain=1e-4).ways()
    g, g_0 = SIGNALS["conductance_S"], SIGNALS["conductance_S"][0]
    z = ln_g.term.evaluated(SIGNALS, ln_g.values, DT_S)
    after = {
        one.place.name: applied(effect_class(one, "my_law", GRID)(), SIGNALS, DT_S)["conductance_S"]
        for one in (beside, in_series)
    }
    assert after["path beside"] == pytest.approx(g + 1e-4 * z * g_0, rel=1e-9)
    assert 1 / after["resistance in series"] == pytest.approx(1 / g - 1e-4 * z / g_0, rel=1e-9)
    torn = applied(effect_class(replace(beside, strength=-1e3), "my_law", GRID)(), SIGNALS, DT_S)["conductance_S"]
    assert np.all(torn > 0)  # however large z becomes


def test_what_a_force_is_multiplied_by_may_be_a_share_of_it_the_same_to_first_order():
    amount, share = law_of("force", "strain", "lag", "times force", gain=1e-4).ways()
    assert share.key == "force by a share: strain, lag"
    changes = [
        applied(effect_class(law, "my_law", GRID)(), SIGNALS, DT_S)["force_N"] - SIGNALS["force_N"]
        for law in (amount, share)
    ]
    assert changes[1] == pytest.approx(changes[0], abs=1e-3 * np.ptp(changes[0]))
    assert str(share.unit) == str(amount.unit) == "1"
    softened = applied(effect_class(replace(share, strength=-1e3), "my_law", GRID)(), SIGNALS, DT_S)["force_N"]
    assert np.all(softened * SIGNALS["force_N"] >= 0)  # however large z becomes
    (only,) = law_of("force", "strain", "times force", "times strain").ways()
    assert only.place.name == "force"


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


@pytest.mark.parametrize(
    ("law", "jumps"),
    [
        (law_of("conductance", "conductance", "switch"), ("on", "gap")),
        (law_of("force", "what gathers beyond a strain and is evened out by each turn"), ("swing",)),
        (law_of("force", "what gathers beyond a strain and goes near rest"), ("rest",)),
        (law_of("force", "strain", "lag", "threshold"), ()),
    ],
    ids=lambda one: one.key if isinstance(one, Law) else "",
)
def test_the_file_names_the_numbers_at_which_a_law_jumps(law: Law, jumps: tuple[str, ...]):
    assert effect_class(law, "my_law", GRID).jumps == jumps


@pytest.mark.parametrize("name", KINETICS)
def test_a_written_state_knows_the_span_as_a_number(name: str):
    assert not any(re.search(r"\bs\b(?!_)", plain(line)) for line in law_of("force", name).term.definitions)


def test_no_law_of_the_library_has_a_name_for_two_numbers():
    for coordinate in EVERY.values():
        assert len({slot.key for slot in coordinate.slots}) == len(coordinate.slots) <= 3


def test_rest_begins_in_the_middle_of_its_window_at_the_moment_when_the_strain_gets_there():
    x = np.r_[np.linspace(0.0, 0.5, 11), np.full(10, 0.5), np.linspace(0.5, 0.56, 8)]  # 0.05 a sample, then a hold
    kept_s = seconds_near(x, 0.19, 0.1)
    there = 7.6  # samples to 0.38, two windows on
    assert kept_s[[8, 20]] == pytest.approx([0.1 * (8 - there), 0.1 * (20 - there)])
    assert kept_s[-1] == pytest.approx(0.1 * (len(x) - 1 - there))  # 0.56 is still within 0.19 of 0.38


def test_a_top_is_forgotten_once_the_strain_is_past_it():
    x = np.concatenate([np.linspace(0, 0.2, 21), np.linspace(0.2, 0.1, 11), np.linspace(0.1, 0.3, 21)])
    top = last_top(x, 0.006)
    assert top[31] == pytest.approx(0.2)
    assert top[40] == pytest.approx(0.2)  # at 0.18 on the way up
    assert top[-1] == pytest.approx(0.3)


def test_each_turn_says_how_large_the_swing_was_that_is_over():
    x = np.concatenate([np.linspace(0, 0.2, 21), np.linspace(0.2, 0.1, 11), np.linspace(0.1, 0.3, 21)])
    sizes = turning(x, 0.006, 0.1) * 0.1
    assert sizes[sizes > 0] == pytest.approx([0.2, 0.1])  # the last swing is not over
    assert list(np.flatnonzero(sizes)) == [22, 33]


def test_what_gathers_has_no_limit_and_goes_at_its_rate():
    gain = np.r_[np.ones(101), np.zeros(100)]
    loss = np.r_[np.zeros(101), np.full(100, 0.5)]
    n = gathered(gain, loss, 0.1)
    assert n[100] == pytest.approx(10.0)
    assert n[-1] == pytest.approx(n[101] * np.exp(-0.5 * 9.9), rel=1e-6)


def test_what_is_no_quicker_than_a_rate_lags_until_it_has_caught_up():
    t = 0.1 * np.arange(200)
    x = np.clip(2.0 * (t - 5.0), 0.0, 4.0)  # a slope of 2 in a second, for two seconds
    assert no_quicker(x, 3.0, 0.1) == pytest.approx(x)
    assert no_quicker(x, 0.5, 0.1) == pytest.approx(np.clip(0.5 * (t - 5.0), 0.0, 4.0), abs=1e-9)
    law = law_of("conductance", "force", "slow")
    assert str(law.term.unit_of(law.term.slots[0])) == "N/s"


def test_the_acceleration_is_that_of_a_parabola():
    law = law_of("force", "acceleration")
    t = DT_S * np.arange(400)
    z = law.term.evaluated({**SIGNALS, "strain": 0.5 * 0.02 * t**2}, {}, DT_S)
    assert z[100:-10] == pytest.approx(np.full(len(t) - 110, 0.02), rel=0.01)


def test_what_stays_gathers_without_loss():
    law = law_of("conductance", "what gathers beyond a strain and stays")
    z = law.term.evaluated({**SIGNALS, "strain": np.full(101, 0.3)}, {"edge": 0.15}, 0.1)
    assert z[-1] == pytest.approx(10.0 * 0.5)
    assert plain(law.term.definitions[0]) == "n' = ((e - e_1)^+ / 0.3)"


def test_a_slow_clock_shows_the_past_and_ever_more_of_it():
    t = np.arange(1000.0)
    assert t - ever_later(t, 0.01) == pytest.approx(0.01 * t)


def test_a_fast_clock_is_ahead_until_there_is_no_more_to_show():
    t = np.arange(1000.0)
    assert ever_later(t, -0.01) - t == pytest.approx(np.minimum(0.01 * t, 999.0 - t))


def test_a_slow_or_fast_clock_is_not_missed_between_two_shares():
    points = GRID.points(OPERATORS["clock"].slots, SIGNALS["force_N"], "clock")
    shares = np.array([point["skew"] for point in points])
    slow = shares[shares > 0]
    assert -shares[shares < 0][::-1] == pytest.approx(slow)
    assert np.diff(slow, prepend=0.0) * GRID.duration_s == pytest.approx(np.full(len(slow), LATE_S))
    assert slow[-1] <= MOST_SKEW + 1e-9


def test_a_rounded_loop_turns_over_by_the_equation_that_is_written_for_it():
    x = 0.1 * np.sin(np.arange(0, 20, 1e-3))
    h = heading(x, 50.0 * 0.03)  # as the operator's code has it, for a reach of 0.03
    way, here = np.sign(np.diff(x)), 0.5 * (h[1:] + h[:-1])
    slope = (1 - (np.abs(here) + here * way) / 2) / 0.03
    steady = np.abs(np.diff(x)) > 1e-6
    np.testing.assert_allclose((np.diff(h) / np.diff(x))[steady], slope[steady], rtol=1e-2)
    assert r"|h| + h\,\mathrm{sgn}" in OPERATORS["loop"].definitions[0]
