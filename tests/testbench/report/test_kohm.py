"""Residuals of ln G as differences of resistance: exact, and of the opposite sign."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from testbench.comparing.contribution import Contribution
from testbench.report.figures.comparison_figures import contribution_kohm, residuals_kohm

LN_S = st.floats(-16.0, -2.0)
LEFT = st.floats(-1.0, 1.0)
ROUNDING_KOHM = 1e-10  # of differences of up to 24 megohms


@given(LN_S, LEFT, LEFT)
def test_they_are_the_differences_of_the_resistances_themselves(measured: float, left: float, added: float) -> None:
    modelled = measured - left
    kohm = [1e-3 * np.exp(-value) for value in (measured, modelled, modelled + added)]
    found = residuals_kohm(np.array([measured]), np.array([left]), np.array([added]))
    assert found[0][0] == pytest.approx(kohm[0] - kohm[1], rel=1e-9, abs=ROUNDING_KOHM)
    assert found[1][0] == pytest.approx(kohm[2] - kohm[1], rel=1e-9, abs=ROUNDING_KOHM)


@given(LN_S, LEFT)
def test_an_effect_that_adds_what_is_left_lies_on_the_dashed_line(measured: float, left: float) -> None:
    one = np.array([measured]), np.array([left]), np.array([left])
    residual, added = residuals_kohm(*one)
    assert added == pytest.approx(residual, abs=ROUNDING_KOHM)


def test_a_contribution_in_kohm_keeps_the_force_and_has_no_conductance_any_more():
    one, log_g = np.array([1.0]), np.array([-np.log(2000.0)])
    found = Contribution(one, {"force": one, "conductance": 0.1 * one}, {"force": 2 * one, "conductance": 0.1 * one})
    told = contribution_kohm(found, log_g)
    assert sorted(told.residual) == sorted(told.added) == ["force", "resistance"]
    assert told.added["force"] is found.added["force"]
    assert told.residual["resistance"] == pytest.approx(2.0 - 2.0 * np.exp(0.1))
    assert told.added["resistance"] == pytest.approx(told.residual["resistance"])
