"""Base laws of the third simulator are physically plausible, whatever numbers are drawn for them."""

from __future__ import annotations

import numpy as np
import pytest
from worlds_third.laws import FAMILIES
from worlds_third.randoms import draw

DRAWS = range(12)
STROKE = np.linspace(0.0, 1.1, 800)
CYCLES = np.concatenate([np.interp(np.linspace(0, 6, 1801), range(7), [0, 1, 0, 0.7, 0.2, 1, 0])])


def values(family: str, name: str, seed: int) -> dict[str, float]:
    return draw(np.random.default_rng([seed, 7]), FAMILIES[family][name].ranges)


@pytest.mark.parametrize("name", FAMILIES["elasticity"])
@pytest.mark.parametrize("full", [0.015, 0.3, 1.5])
def test_the_elastic_force_rises_from_0_to_1_without_corners(name: str, full: float) -> None:
    for seed in DRAWS:
        curve = FAMILIES["elasticity"][name].function(STROKE, full, **values("elasticity", name, seed))
        slope = np.diff(curve) / np.diff(STROKE)
        assert curve[0] == pytest.approx(0.0, abs=1e-12)
        assert np.interp(1.0, STROKE, curve) == pytest.approx(1.0, abs=1e-3)
        assert slope.min() > 0
        assert slope.max() < 60
        assert np.abs(np.diff(slope)).max() < 0.05 * slope.max(), "a corner"


@pytest.mark.parametrize("name", FAMILIES["hysteresis"])
def test_friction_is_bounded_and_takes_work(name: str) -> None:
    steps_s = np.full(len(CYCLES), 0.02)
    for seed in DRAWS:
        state = FAMILIES["hysteresis"][name].function(CYCLES, steps_s, **values("hysteresis", name, seed))
        work = np.sum(0.5 * (state[1:] + state[:-1]) * np.diff(CYCLES))
        assert np.abs(state).max() < 1.1
        assert work > 0.5, "a loop the wrong way round gives work for nothing"


@pytest.mark.parametrize("name", [name for name in FAMILIES["hysteresis"] if name != "lugre"])
def test_friction_knows_no_time(name: str) -> None:
    numbers = values("hysteresis", name, 0)
    slow, fast = (
        FAMILIES["hysteresis"][name].function(CYCLES, np.full(len(CYCLES), dt), **numbers) for dt in (0.01, 1)
    )
    np.testing.assert_array_equal(slow, fast)


def test_masing_closes_its_loops() -> None:
    """Back at the turn before, the force is what it was, and the minor loop is forgotten."""
    law = FAMILIES["hysteresis"]["masing"].function
    with_minor, without = (
        np.interp(np.linspace(0, 1, 4001), np.linspace(0, 1, len(turns)), turns)
        for turns in ([0, 1, 0.5, 0.8, 0.5, 0.0], [0, 1, 0.0])
    )
    ones = np.ones(4001)
    assert law(with_minor, ones, reach=0.05)[-1] == pytest.approx(law(without, ones, reach=0.05)[-1], abs=1e-6)


@pytest.mark.parametrize("name", FAMILIES["conductance"])
def test_conductance_goes_one_way_and_not_too_far(name: str) -> None:
    for seed in DRAWS:
        numbers = values("conductance", name, seed)
        log_g = FAMILIES["conductance"][name].function(STROKE, np.zeros_like(STROKE), **numbers)
        way = -1 if name == "opening_gaps" else 1
        assert np.all(way * np.diff(log_g) > 0)
        assert 0.1 < np.ptp(log_g) < 6


@pytest.mark.parametrize("name", FAMILIES["loops"])
def test_loops_of_the_resistance_are_of_a_height_of_about_one(name: str) -> None:
    for seed in DRAWS:
        loop = FAMILIES["loops"][name].function(CYCLES, **values("loops", name, seed))
        assert np.abs(loop).max() < 1.2
        assert (np.ptp(loop) > 0.05) == (name != "none")


@pytest.mark.parametrize("name", FAMILIES["drift"])
def test_drift_starts_at_0_and_goes_one_way_to_about_1(name: str) -> None:
    time_s = np.arange(0, 1400, 0.5)
    motion = 0.5 + 0.5 * np.sin(time_s / 3)
    for seed in DRAWS:
        drift = FAMILIES["drift"][name].function(motion, np.diff(time_s, prepend=0.0), **values("drift", name, seed))
        assert drift[0] == pytest.approx(0.0, abs=1e-12)
        assert np.all(np.diff(drift) >= 0)
        assert (0.3 < drift[-1] < 1.01) == (name != "none")
