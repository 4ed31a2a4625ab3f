"""What motion breaks and rest heals, after a ramp out and a ramp back, against closed-form answers."""

from __future__ import annotations

import numpy as np
import pytest

from testbench.knit.conduction.breaking import (
    HEALING_S,
    ElectricalOvershootMagnitude,
    ElectricalOvershootTwoWays,
    ElectricalOvershootTwoWaysProny,
)
from testbench.knit.conduction.transient import ElectricalOvershoot
from tests.testbench.knit.samples import DT_S, UP_HOLD_DOWN, T, log_change


def test_overshoot_of_the_magnitude_has_the_same_sign_both_ways() -> None:
    change = log_change(ElectricalOvershootMagnitude(gain=1.0, tau_s=2.0))
    up, down = change[np.searchsorted(T, [10.0, 50.0])]
    assert up == pytest.approx(down, rel=1e-3)
    assert up == pytest.approx(0.02 * 2.0, rel=0.02)


def test_the_way_back_shakes_by_its_own_share() -> None:
    change = log_change(ElectricalOvershootTwoWays(gain=1.0, tau_s=2.0, back=-0.5))
    up, down = change[np.searchsorted(T, [10.0, 50.0])]
    assert down == pytest.approx(-0.5 * up, rel=1e-3)
    assert up == pytest.approx(0.02 * 2.0, rel=0.02)


def spectrum(out: dict[float, float], back: dict[float, float]) -> ElectricalOvershootTwoWaysProny:
    """The general law with these weights by healing time, over a span of 1."""
    weights = tuple(way.get(tau_s, 0.0) for way in (out, back) for tau_s in HEALING_S)
    return ElectricalOvershootTwoWaysProny(weights=weights, span=1.0)


def test_the_general_law_has_those_of_one_time_in_it() -> None:
    one_way = log_change(ElectricalOvershootTwoWays(gain=0.7, tau_s=3.0, back=1.6))
    np.testing.assert_allclose(log_change(spectrum({3.0: 0.7}, {3.0: 0.7 * 1.6})), one_way, atol=1e-12)
    signed = log_change(ElectricalOvershoot(gain=0.7, tau_s=10.0))
    general = log_change(spectrum({10.0: 0.7}, {10.0: -0.7}))
    # The rate that shakes is felt over a tenth of a second, the high-pass feels the strain at once.
    assert np.max(np.abs(general - signed)) < 0.03 * np.max(np.abs(signed))


def test_weights_say_themselves_what_they_add() -> None:
    law, signals = spectrum({0.3: 0.4, 30.0: -0.2}, {1.0: 0.1}), {"strain": UP_HOLD_DOWN, "time_s": T}
    by_terms = np.asarray(law.weights) @ law.terms("weights", signals)
    np.testing.assert_allclose(by_terms, law.log_change(signals, DT_S), atol=1e-12)
