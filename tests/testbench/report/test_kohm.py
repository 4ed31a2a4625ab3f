"""Residuals of ln G as differences of resistance: exact, and of the opposite sign."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from testbench.report.kohm import residuals_kohm

LN_S = st.floats(-16.0, -2.0)
LEFT = st.floats(-1.0, 1.0)


@given(LN_S, LEFT, LEFT)
def test_they_are_the_differences_of_the_resistances_themselves(measured: float, left: float, added: float) -> None:
    modelled = measured - left
    kohm = [1e-3 * np.exp(-value) for value in (measured, modelled, modelled + added)]
    found = residuals_kohm(np.array([measured]), np.array([left]), np.array([added]))
    assert found[0][0] == pytest.approx(kohm[0] - kohm[1], rel=1e-9, abs=1e-12)
    assert found[1][0] == pytest.approx(kohm[2] - kohm[1], rel=1e-9, abs=1e-12)


@given(LN_S, LEFT)
def test_an_effect_that_adds_what_is_left_lies_on_the_dashed_line(measured: float, left: float) -> None:
    one = np.array([measured]), np.array([left]), np.array([left])
    residual, added = residuals_kohm(*one)
    assert added == pytest.approx(residual)
