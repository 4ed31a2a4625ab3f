"""The dictionary of loops: two curves for the two ways."""

from __future__ import annotations

import numpy as np
import pytest

from testbench.knit.shapes.base_laws import ContactLoopsShape
from testbench.knit.shapes.curves import LAW_TERMS, curve
from testbench.knit.shapes.loops import SMOOTH, WAYS, two_ways
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
