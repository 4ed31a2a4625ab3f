"""The noise floor of readings that a converter clips, rounds, or leaves alone."""

from __future__ import annotations

import numpy as np
import pytest

from testbench.measurements.noise_level import noise_floor, rounding, spread, within_range

TIME_S = np.arange(4000) / 40
MOTION = 1 + np.sin(2 * np.pi * TIME_S / 7)


@pytest.fixture(scope="module")
def reading() -> np.ndarray:
    return MOTION + 0.01 * np.random.default_rng(3).standard_normal(len(MOTION))


def test_white_noise_on_a_smooth_motion_is_found(reading) -> None:
    assert noise_floor(reading) == pytest.approx(0.01, rel=0.1)


@pytest.mark.parametrize("limit", [0.5, 1.0, 1.5])
def test_a_converter_at_its_rail_hides_no_noise_of_the_rest(reading, limit) -> None:
    clipped = np.minimum(reading, limit)
    assert noise_floor(clipped) == pytest.approx(0.01, rel=0.15)
    assert within_range(clipped).sum() < len(clipped)


def test_a_coarse_converter_is_known_to_a_step() -> None:
    stepped = np.round(MOTION / 0.1) * 0.1
    assert noise_floor(stepped) == pytest.approx(rounding(stepped)) == pytest.approx(0.1 / 12**0.5, rel=1e-6)


def test_readings_that_are_all_at_a_rail_all_count() -> None:
    assert within_range(np.repeat([0.0, 1.0], 100)).all()
    assert noise_floor(np.ones(200)) == 0


@pytest.mark.parametrize(("steps", "seconds"), [(3, 7.3), (4, 7.3), (5, 7.3), (6, 7.3), (8, 7.3), (12, 3.3)])
def test_readings_in_steps_of_many_deviations_are_known_by_their_noise_and_their_rounding(steps, seconds) -> None:
    """Half of their second differences are one step, which is twice what rounding makes of them."""
    noise = np.random.default_rng(4).standard_normal(len(MOTION))
    reading = 300 * np.sin(2 * np.pi * TIME_S / seconds) + noise
    found = noise_floor(np.round(reading / steps) * steps)
    assert 0.7 < found / np.hypot(1.0, steps / 12**0.5) < 1.35


def test_of_a_reading_that_knows_three_values_the_rounding_is_known() -> None:
    assert noise_floor(np.round(MOTION - 1)) == pytest.approx(12**-0.5)


def test_what_is_rare_spreads_a_reading_that_rests_most_of_the_time() -> None:
    assert spread(np.r_[np.zeros(300), np.linspace(0, 1, 100)]) > 0.1
