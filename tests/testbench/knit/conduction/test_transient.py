"""Transients after a ramp and after a turn, against closed-form answers."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from testbench.knit.conduction.transient import (
    ElectricalOvershoot,
    RateResistance,
    ShoulderPeak,
    ShoulderPeakAfterTurn,
    ShoulderPeakAnywhere,
    ShoulderPeakWayBack,
    on_the_way_back,
)
from testbench.knit.conduction.turning import ElectricalOvershootAnew, ElectricalOvershootReversal
from tests.testbench.knit.samples import T, log_change


@pytest.mark.parametrize(("tau_s", "rise_s"), [(4.0, 0.5), (0.5, 4.0), (2.0, 2.0), (2.0, 2.0 + 1e-9)])
def test_a_transient_starts_anew_at_each_turn(tau_s: float, rise_s: float) -> None:
    triangle = 0.2 * np.interp(T, [0, 10, 20, 30, 100], [0, 1, 0, 1, 2])
    change = log_change(ElectricalOvershootAnew(gain=0.1, tau_s=tau_s, rise_s=rise_s, back=0.01), triangle)
    for turned_s, at_s, heading in ((10.0, 13.0, -1), (20.0, 26.0, 1)):
        since_s = at_s - turned_s
        if abs(tau_s - rise_s) > 1e-6:
            spike = tau_s / (tau_s - rise_s) * (np.exp(-since_s / tau_s) - np.exp(-since_s / rise_s))
        else:
            spike = since_s / tau_s * np.exp(-since_s / tau_s)
        assert change[np.searchsorted(T, at_s)] == pytest.approx(0.1 * heading * spike, rel=1e-6)


@pytest.mark.parametrize("rate_hz", [1000, 40, 10, 1])
@pytest.mark.parametrize("rest_s", [0.0, 5.0])
def test_the_first_sample_is_no_turn(rate_hz: int, rest_s: float) -> None:
    """Where a recording begins, in motion or at rest, no transient starts; the first does where the motion turns."""
    time_s = np.arange(0, 60 + rest_s, 1 / rate_hz)
    strain = 0.02 * np.interp(time_s - rest_s, [0, 10, 20, 60], [0, 10, 0, 40])
    law = ElectricalOvershootAnew(gain=0.1, tau_s=4.0, rise_s=0.5, back=0.005)
    signals = {"strain": strain, "conductance_S": np.ones_like(strain)}
    change = np.log(law.apply(signals, 1 / rate_hz)["conductance_S"])
    assert not change[time_s <= 10 + rest_s].any()
    for turned_s, at_s, heading in ((10.0, 13.0, -1), (20.0, 26.0, 1)):
        since_s = at_s - turned_s
        spike = 4.0 / 3.5 * (np.exp(-since_s / 4.0) - np.exp(-since_s / 0.5))
        assert change[round((at_s + rest_s) * rate_hz)] == pytest.approx(0.1 * heading * spike, rel=1e-6)


def test_overshoot_after_a_ramp_decays_with_its_time_constant() -> None:
    change = log_change(ElectricalOvershoot(gain=2.0, tau_s=4.0))
    peak = 2.0 * 0.02 * 4.0 * -np.expm1(-10 / 4.0)  # gain * rate * tau * (1 - e^-T/tau)
    at = np.searchsorted(T, [10.0, 14.0])
    np.testing.assert_allclose(change[at], [peak, peak / np.e], rtol=1e-6)


def test_reversal_transient_does_not_know_the_speed() -> None:
    fast = log_change(ElectricalOvershootReversal(gain=0.1), 0.05 * np.abs((T + 10) % 20 - 10))
    slow = log_change(ElectricalOvershootReversal(gain=0.1), 0.01 * np.abs((T + 10) % 20 - 10))
    np.testing.assert_allclose(np.ptp(fast), np.ptp(slow), rtol=0.1)


def test_shoulder_is_on_the_way_back_only() -> None:
    change = log_change(ShoulderPeak(gain=-1.0, tau_s=5.0))
    assert np.all(np.abs(change[T < 40]) < 1e-12)
    assert change[np.searchsorted(T, 50.0)] == pytest.approx(-0.02 * 5.0 * -np.expm1(-10 / 5.0), rel=1e-3)


def test_a_late_way_back_begins_after_its_share_of_the_turn() -> None:
    back = np.linspace(1.0, 0.0, 2001)
    strain = np.concatenate([np.linspace(0.0, 1.0, 2001), back])
    at_once, late = (on_the_way_back(strain, 0.1, share) for share in (0.0, 0.5))
    turned = 1 - 2 * np.exp((back - 1) / 0.1)  # z of Dahl's law, from -1 (out) to 1 (back)
    np.testing.assert_allclose(at_once[2001:], 0.5 * (1 + turned), atol=1e-3)
    np.testing.assert_allclose(late[2001:], np.maximum(turned, 0.0), atol=1e-3)


@pytest.mark.parametrize("rate_hz", [1000, 40, 10, 1])
@pytest.mark.parametrize("late", [0.0, 0.5])
def test_a_knit_is_not_on_the_way_back_where_a_recording_begins(rate_hz: int, late: float) -> None:
    """At rest, on the way out, and on a way back that goes on from before: it has only just begun there."""
    time_s = np.arange(0, 30, 1 / rate_hz)
    out = 0.1 + 0.01 * np.maximum(time_s - 10, 0)
    assert not on_the_way_back(out, 0.05, late).any()
    gone = 1 - np.exp(-0.01 * time_s / 0.05)
    back = on_the_way_back(0.4 - 0.01 * time_s, 0.05, late)
    np.testing.assert_allclose(back, np.maximum(gone - late, 0) / (1 - late), atol=1e-12)


@pytest.mark.parametrize(
    ("law", "place"),
    [
        (ShoulderPeakAnywhere, lambda e, top: e),
        (ShoulderPeakAfterTurn, lambda e, top: e / top),
        (ShoulderPeakWayBack, lambda e, top: top - e),
    ],
)
def test_a_bump_of_the_way_back_lies_where_its_law_says(law, place) -> None:
    """At one strain, at one share of the stretch, or one way behind the turn: of a high stroke and of a low one."""
    weights = np.zeros(14)
    weights[6] = 1.0  # the sixth bump of eleven cells is highest at (6 - 1) / 11
    strokes = [0.0, 1.0, 0.05, 0.7, 0.05]
    e = np.concatenate([np.linspace(a, b, 500) for a, b in pairwise(strokes)])
    change = log_change(law(weights=tuple(weights), travel=1e-3, span=1.0), e)
    for start, top in ((500, 1.0), (1500, 0.7)):
        assert np.max(np.abs(change[start - 500 : start])) < 1e-2  # none on the way out
        highest = start + np.argmax(change[start : start + 500])
        assert place(e[highest], top) == pytest.approx(5 / 11, abs=3e-3)


def test_rate_shift_is_gone_when_the_motion_stops() -> None:
    change = log_change(RateResistance(gain=0.5))
    assert change[np.searchsorted(T, 9.0)] == pytest.approx(0.5 * 0.02 / 0.1, rel=1e-4)
    assert abs(change[np.searchsorted(T, 12.0)]) < 1e-6
