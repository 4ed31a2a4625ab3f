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


@pytest.mark.parametrize("noise_in_steps", [0.5, 0.7, 1.0, 1.5, 2.5])
def test_noise_of_a_few_steps_is_known_closer_than_to_a_step(noise_in_steps) -> None:
    """The median of the differences is 1, 2, 3 ... steps: the floor was 20 % too low at 0.7, 16 % too high at 1."""
    noise = noise_in_steps * np.random.default_rng(4).standard_normal(len(MOTION))
    found = noise_floor(np.round(30 * MOTION + noise))
    assert found == pytest.approx(np.hypot(noise_in_steps, 12**-0.5), rel=0.08)


@pytest.mark.parametrize("largest", [300.0, 1000.0, 3000.0])
def test_a_step_is_no_larger_where_the_motion_passes_over_most_of_them(largest) -> None:
    """The median distance of the values that occur is how far a quick motion goes from one sample to the next."""
    time_s = np.arange(0.0, 300.0, 1 / 40)
    noise = 0.1 * np.random.default_rng(5).standard_normal(len(time_s))
    stepped = np.round(largest * np.sin(2 * np.pi * time_s / 7.3) + noise)
    assert rounding(stepped) == pytest.approx(1 / 12**0.5)
    assert noise_floor(stepped) == pytest.approx(np.hypot(0.1, 1 / 12**0.5), rel=0.3)


def test_of_a_reading_that_knows_three_values_the_rounding_is_known() -> None:
    assert noise_floor(np.round(MOTION - 1)) == pytest.approx(12**-0.5)


def test_what_is_rare_spreads_a_reading_that_rests_most_of_the_time() -> None:
    assert spread(np.r_[np.zeros(300), np.linspace(0, 1, 100)]) > 0.1
