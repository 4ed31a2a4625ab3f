"""Base laws and their memories: known answers."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from worlds_second import LAW_FAMILIES
from worlds_second.draws import draw_all
from worlds_second.kernels import bouc_wen, breakaway, dahl, kinetics, lag, play, ringing, turns
from worlds_second.laws import FAMILIES
from worlds_second.laws.contact import around

UP = np.linspace(0.0, 1.05, 400)
CYCLE = np.concatenate([np.linspace(0, 1, 300), np.linspace(1, 0.2, 300), np.linspace(0.2, 1, 300)])


def drawn(family, name, seed):
    member = FAMILIES[family][name]
    return member.function, draw_all(member.ranges, np.random.default_rng(seed))


@settings(max_examples=60, deadline=None)
@given(st.sampled_from(LAW_FAMILIES["elasticity"]), st.integers(0, 10**6))
def test_elastic_force_rises_from_zero(name, seed):
    function, parameters = drawn("elasticity", name, seed)
    force = function(UP, **parameters)
    assert force[0] == pytest.approx(0.0, abs=1e-9)
    assert np.all(np.diff(force) > 0)


@settings(max_examples=60, deadline=None)
@given(st.sampled_from(LAW_FAMILIES["force_loops"][:-1]), st.integers(0, 10**6))
def test_force_loops_lose_work_and_close(name, seed):
    function, parameters = drawn("force_loops", name, seed)
    loop = function(CYCLE, CYCLE, **parameters)
    back, again = loop[300:600][::-1], loop[600:]
    gap = again - back
    assert np.max(gap) > 0.005
    assert np.min(gap) > -0.1 * np.max(gap)
    assert loop[-1] == pytest.approx(loop[299], abs=0.02)


@pytest.mark.parametrize("name", LAW_FAMILIES["resistance_loops"])
@pytest.mark.parametrize("seed", range(5))
def test_resistance_loops_differ_by_direction(name, seed):
    function, parameters = drawn("resistance_loops", name, seed)
    loop = function(CYCLE, CYCLE, **parameters)
    gap = np.max(np.abs(loop[600:] - loop[300:600][::-1]))
    assert gap == 0 if name == "none" else gap > 1e-3


@pytest.mark.parametrize("name", LAW_FAMILIES["contact"])
@pytest.mark.parametrize("seed", range(5))
def test_networks_are_finite_and_monotonic(name, seed):
    function, parameters = drawn("contact", name, seed)
    whole = around(name, function(UP, 0 * UP, **parameters), 0 * UP, parameters)
    steps = np.diff(whole)
    assert np.all(np.isfinite(whole))
    assert np.all(steps >= 0) or np.all(steps <= 0)
    assert steps.any()


def test_floats_carry_and_yarn_limits():
    open_, closed = np.array([-50.0]), np.array([50.0])
    assert np.exp(around("holm_floats", open_, open_, {"floats": 0.3}))[0] == pytest.approx(0.3)
    limit = around("holm_series", closed, 0 * closed, {"yarn": 0.5, "lengthening": 0.2})
    assert np.exp(limit)[0] == pytest.approx(2.0)


@pytest.mark.parametrize("name", LAW_FAMILIES["drift"])
def test_drift_starts_at_nothing(name):
    function, parameters = drawn("drift", name, 0)
    creep = function(np.linspace(0, 2000, 50), **parameters)
    assert abs(creep[0]) < 0.01
    assert np.all(np.diff(creep) >= 0) or np.all(np.diff(creep) <= 0)
    assert np.any(creep) == (name != "none")


def test_play_of_a_triangle():
    y = play(CYCLE, 0.1)
    assert y[299] == pytest.approx(0.9)
    assert y[599] == pytest.approx(0.3)


@pytest.mark.parametrize("kernel", [lambda x: bouc_wen(x, 1.5, 0.1, 0.6), lambda x: dahl(x, 0.1, 1.3)])
def test_friction_states_are_bounded_and_take_any_step(kernel):
    fine, coarse = kernel(CYCLE), kernel(CYCLE[::10])
    assert np.all(np.abs(fine) <= 1)
    np.testing.assert_allclose(fine[::10], coarse, atol=0.05)


def test_lag_of_a_ramp_over_uneven_steps():
    t = np.cumsum(np.random.default_rng(0).uniform(0.001, 0.02, 5000))
    t -= t[0]
    exact = t - 2.0 * -np.expm1(-t / 2.0)
    np.testing.assert_allclose(lag(t, np.diff(t, prepend=-0.01), 2.0), exact, atol=1e-9)


def test_kinetics_and_ringing_as_an_ode_solver_has_them():
    t = np.linspace(0, 10, 4001)
    dt = np.full(len(t), t[1])
    exact = solve_ivp(lambda _, n: 0.7 * (1 - n) - 0.2 * n, (0, 10), [0.0], t_eval=t, rtol=1e-8).y[0]
    np.testing.assert_allclose(kinetics(np.full(len(t), 0.7), np.full(len(t), 0.2), dt), exact, atol=1e-6)
    w, z = 2 * np.pi * 1.5, 0.1
    swing = solve_ivp(lambda s, y: [y[1], w**2 * (np.sin(s) - y[0]) - 2 * z * w * y[1]], (0, 10), [0, 0], t_eval=t)
    np.testing.assert_allclose(ringing(np.sin(t), dt, 1.5, 0.1), swing.y[0], atol=5e-3)


def test_turns_and_breakaway():
    swings, upper, side = turns(CYCLE, 0.03)
    assert swings[-1] == pytest.approx(1.8)
    assert upper[650] == pytest.approx(1.0)
    assert side[450] == -1
    assert side[800] == 1
    teeth = breakaway(CYCLE, 0.1)
    assert np.abs(teeth).max() <= 0.1
    assert np.sum(np.abs(np.diff(teeth)) > 0.05) == pytest.approx(2.6 / 0.1 - 3, abs=3)
