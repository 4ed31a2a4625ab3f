"""The dictionary of loops: two curves for the two ways."""

from __future__ import annotations

import numpy as np
import pytest

from testbench.knit.effect import FloatArray
from testbench.knit.shapes.base_laws import ContactLoopsShape
from testbench.knit.shapes.curves import LAW_TERMS, curve
from testbench.knit.shapes.loops import SMOOTH, STOPS, WAYS, positions_terms, two_ways
from tests.testbench.knit.samples import UP_DOWN_UP

SPAN = 0.3
SHARP = (0.2, -0.1, 0.4) + (0.0,) * (len(WAYS) * LAW_TERMS - 3)  # goes over within a thirtieth of the span


def test_the_ways_differ_by_twice_the_curve_once_a_turn_is_forgotten():
    made = two_ways(UP_DOWN_UP, SPAN, SHARP)
    half = curve(np.array([0.15]), 0.0, SPAN, SHARP[:LAW_TERMS])[0]
    out, back, out_again = (made[place] for place in (150, 450, 750))
    assert UP_DOWN_UP[[150, 450, 750]] == pytest.approx([0.15] * 3)
    assert (out, back, out_again) == pytest.approx((half, -half, half), rel=1e-5)


def test_a_turn_is_forgotten_over_its_travel():
    """z = -1 + 2 exp(-x / travel) on the way back from a long way out."""
    travel = SMOOTH[WAYS[0]] * SPAN
    made, at = two_ways(UP_DOWN_UP, SPAN, SHARP), 300 + 10
    z = made[at] / curve(UP_DOWN_UP[at : at + 1], 0.0, SPAN, SHARP[:LAW_TERMS])[0]
    assert z == pytest.approx(-1 + 2 * np.exp(-0.01 / travel), abs=1e-3)


def test_two_ways_without_weights_change_nothing():
    signals = {"strain": UP_DOWN_UP, "conductance_S": np.ones_like(UP_DOWN_UP)}
    assert np.all(ContactLoopsShape().apply(signals, 0.1)["conductance_S"] == 1.0)


def test_relays_of_one_width_weighted_by_where_they_lie_are_the_square_of_a_position():
    """A Preisach operator: relays that go on at s + r and off at s - r, each counting with 2 s."""
    path, number = path_of_turns(), 6
    radius, middles = STOPS[number], np.arange(-0.5, 1.5, 1e-4) + 5e-5
    up = np.zeros(len(middles), bool) | (middles < 0)  # as a play that stands at zero
    total = np.empty_like(path)
    for i, u in enumerate(path):
        up = (up | (u >= middles + radius)) & (u > middles - radius)
        total[i] = np.sum(np.where(up, 2 * middles, 0.0)) * 1e-4
    squared = path**2 - radius * positions_terms(path * SPAN, SPAN)[number]
    assert squared - squared[0] == pytest.approx(total - total[0], abs=2e-3)


def test_an_excursion_is_forgotten_once_a_larger_one_wipes_it_out():
    path = path_of_turns()
    other = path.copy()
    other[800:1200] = 0.6 - np.interp(np.arange(400), (0, 200, 400), (0.0, 0.25, 0.0))  # one turn more, and back
    later = positions_terms(np.r_[path, path] * SPAN, SPAN), positions_terms(np.r_[other, path] * SPAN, SPAN)
    assert later[0][:, -1] == pytest.approx(later[1][:, -1], abs=1e-12)
    assert not np.allclose(later[0][:, 1000], later[1][:, 1000], atol=1e-3)


def path_of_turns() -> FloatArray:
    """Over the span of the strain, from rest: turns within turns."""
    return np.interp(np.arange(2400), np.arange(7) * 400, (0.0, 0.9, 0.3, 0.7, 0.1, 1.0, 0.0))
