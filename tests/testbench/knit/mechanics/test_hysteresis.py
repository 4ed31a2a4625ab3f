"""Rate-independent memory: play, stop and Bouc-Wen loops."""

from __future__ import annotations

import numpy as np
import pytest

from testbench.knit.catalogue import baseline
from testbench.knit.kernels import bouc_wen, bouc_wen_of_exponent_1, play
from testbench.knit.kinematics.grip import ActuatorBacklash
from testbench.knit.mechanics.hysteresis import Hysteresis, HysteresisBoucWen, HysteresisOnTension, mean_slip

# 0 -> 1 -> -1 -> 1
LOOP = np.concatenate([np.linspace(0, 1, 501), np.linspace(1, -1, 1001)[1:], np.linspace(-1, 1, 1001)[1:]])


def test_play_operator_follows_at_a_distance_and_waits_after_a_reversal() -> None:
    y = play(LOOP, np.array([0.25]))[0]
    assert y[500] == pytest.approx(0.75)
    standing = (LOOP[500:1500] > 0.5) & (np.arange(1000) < 250)
    assert np.all(y[500:1500][standing] == y[500])
    assert y[1500] == pytest.approx(-0.75)


def test_play_loop_area_is_twice_the_gap_times_the_travel() -> None:
    """A play of half width r, driven between -1 and 1, encloses 2 r * 2 (1 - r)."""
    r = 0.25
    y = play(LOOP, np.array([r]))[0]
    x, y = LOOP[500:], y[500:]
    x, y = np.concatenate([x, [1.0]]), np.concatenate([y, [y[0]]])
    area = abs(np.sum(0.5 * (y[1:] + y[:-1]) * np.diff(x)))
    assert area == pytest.approx(2 * r * 2 * (1 - r), rel=1e-6)


def test_backlash_of_a_gap_is_a_play_of_half_of_it() -> None:
    strain = ActuatorBacklash(gap=0.1).apply({"strain": LOOP}, 0.05)["strain"]
    assert LOOP[500] - strain[500] == pytest.approx(0.05)


LAWS = [
    Hysteresis(friction_N=0.4, threshold=0.01),
    HysteresisOnTension(friction_N=0.4, pressed=0.0, threshold=0.01),
    HysteresisBoucWen(friction_N=0.4, pressed=0.0),
]
ON_TENSION = [
    HysteresisOnTension(friction_N=0.4, pressed=0.75, tension_N=2.0, threshold=0.01),
    HysteresisBoucWen(friction_N=0.4, pressed=0.75, tension_N=2.0),
]


@pytest.mark.parametrize("effect", LAWS, ids=lambda law: law.name)
def test_fully_slipping_friction_is_plus_and_minus_its_value(effect) -> None:
    force = effect.apply({"strain": LOOP, "force_N": np.zeros_like(LOOP)}, 0.05)["force_N"]
    assert force[1500] == pytest.approx(-0.4, rel=1e-6)
    assert force[-1] == pytest.approx(0.4, rel=1e-6)


@pytest.mark.parametrize("effect", ON_TENSION, ids=lambda law: law.name)
@pytest.mark.parametrize(("tension_N", "friction_N"), [(2.0, 0.4), (4.0, 0.7), (0.0, 0.1), (-3.0, 0.1)])
def test_friction_grows_with_the_tension_and_keeps_a_rest_without_it(effect, tension_N, friction_N) -> None:
    """0.4 (1 - 0.75 + 0.75 F / 2): a quarter of it without load, and a compressed knit presses on nothing."""
    force = effect.apply({"strain": LOOP, "force_N": np.full_like(LOOP, tension_N)}, 0.05)["force_N"]
    assert force[1500] == pytest.approx(tension_N - friction_N, rel=1e-6)
    assert force[-1] == pytest.approx(tension_N + friction_N, rel=1e-6)


def test_break_away_strains_differ_by_the_spread() -> None:
    """Elements of one threshold all slip after twice that travel; of a wide spread, some still stick."""
    alike, spread = (HysteresisOnTension(threshold=0.1, spread=spread).deflection(LOOP) for spread in (0.05, 1.5))
    back = 500 + round(0.23 / 0.002)  # 0.23 after the reversal: beyond twice 0.1 exp(0.05 * 1.4)
    assert alike[back] == pytest.approx(-1.0)
    assert spread[back] > -0.9


def test_a_law_of_friction_takes_the_place_of_another() -> None:
    """There is one friction in a knit; two would trade with each other."""
    model = baseline().plus(HysteresisBoucWen())
    assert list(model) == list(baseline())
    assert model["hysteresis"] == HysteresisBoucWen()


def test_friction_does_not_know_the_speed() -> None:
    slow = mean_slip(LOOP, 0.05)
    fast = mean_slip(LOOP[::10], 0.05)
    np.testing.assert_allclose(fast, slow[::10], atol=1e-12)


def test_friction_returns_to_where_it_was_after_a_small_inner_loop() -> None:
    """Return-point memory (Madelung): an inner loop leaves no trace."""
    inner = np.concatenate([LOOP[:501], np.linspace(1, 0.8, 101)[1:], np.linspace(0.8, 1, 101)[1:]])
    slip = mean_slip(inner, 0.05)
    assert slip[-1] == pytest.approx(slip[500], abs=1e-12)


def test_bouc_wen_without_skew_is_dahl_friction() -> None:
    """z = sgn - (sgn - z0) exp(-|x - x0| / threshold) along each monotonic branch."""
    z = bouc_wen_of_exponent_1(LOOP, 0.1, 0.0)
    np.testing.assert_allclose(z[:501], -np.expm1(-LOOP[:501] / 0.1), atol=1e-9)
    back = LOOP[500:1501]
    np.testing.assert_allclose(z[500:1501], -1 + (1 + z[500]) * np.exp((back - 1) / 0.1), atol=1e-9)


@pytest.mark.parametrize("skew", [0.0, 0.6])
def test_in_parts_bouc_wen_of_exponent_one_is_nearly_exact(skew) -> None:
    """Two ways of integration: exactly, and in parts of a step."""
    np.testing.assert_allclose(bouc_wen(LOOP, 0.1, skew, 1.0), bouc_wen_of_exponent_1(LOOP, 0.1, skew), atol=1e-3)


@pytest.mark.parametrize("skew", [-0.5, 0.0, 0.3, 0.5, 0.9])
def test_bouc_wen_of_exponent_one_does_not_depend_on_the_steps(skew) -> None:
    """Not even where one of them takes z through zero."""
    x = np.concatenate([np.linspace(0, 0.4, 21), np.linspace(0.4, -0.2, 31)[1:], np.linspace(-0.2, 0.3, 26)[1:]])
    fine = np.interp(np.arange(0, len(x) - 1 + 1e-9, 1e-3), np.arange(len(x)), x)
    there = bouc_wen_of_exponent_1(fine, 0.02, skew)[::1000]
    np.testing.assert_allclose(bouc_wen_of_exponent_1(x, 0.02, skew), there, atol=1e-9)


@pytest.mark.parametrize("skew", [0.0, 0.5, 0.9])
def test_the_way_back_from_full_slip_begins_as_steep_as_the_skew_says(skew) -> None:
    z = bouc_wen_of_exponent_1(np.array([0.0, 2.0, 2.0 - 1e-6]), 0.02, skew)
    assert (z[1] - z[2]) / 1e-6 * 0.02 == pytest.approx(2 * (1 - skew), rel=1e-3)


def test_a_bouc_wen_exponent_of_two_grows_like_a_hyperbolic_tangent() -> None:
    """dz/dx = (1 - z^2) / threshold from rest."""
    z = bouc_wen(LOOP, 0.1, 0.3, 2.0)
    np.testing.assert_allclose(z[:501], np.tanh(LOOP[:501] / 0.1), atol=1e-4)


def test_the_larger_the_exponent_the_sharper_the_corner_between_sticking_and_slipping() -> None:
    half_way, sharp = (bouc_wen(LOOP, 0.1, 0.0, exponent)[50] for exponent in (1.0, 5.0))
    assert half_way == pytest.approx(1 - np.exp(-1), abs=0.01)
    assert sharp > 0.85
