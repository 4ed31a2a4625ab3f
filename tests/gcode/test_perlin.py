"""The signal does not repeat, seeds are independent, and it stays smooth for a day; naive use fails each of these."""

from __future__ import annotations

import numpy as np
import pytest
from noise import pnoise1

import gcode
from gcode.motion.perlin import perlin_walk
from gcode.support.errors import UserError

CELLS_PER_S = 0.32
SCALE_MM = 5.33


def naive(time_s: np.ndarray, base: int = 0) -> np.ndarray:
    """How the package invites to be used: time into one-dimensional noise, a base as the seed."""
    return np.array([pnoise1(t * CELLS_PER_S, base=base) for t in time_s.tolist()])


def correlation(a: np.ndarray, b: np.ndarray, least_lag: int = 0) -> float:
    """Largest normalised correlation at any lag from `least_lag` on, by FFT."""
    a, b = (a - a.mean()) / a.std(), (b - b.mean()) / b.std()
    size = 2 * len(a)
    product = np.fft.irfft(np.fft.rfft(a, size) * np.conj(np.fft.rfft(b, size)))
    lags = product[least_lag : len(a) * 3 // 4] / (len(a) - np.arange(least_lag, len(a) * 3 // 4))
    return float(np.abs(lags).max())


@pytest.fixture(scope="module")
def six_hours() -> np.ndarray:
    return np.arange(0.0, 6 * 3600.0, 0.5)


def test_no_lag_beyond_a_minute_repeats_within_six_hours(six_hours):
    signal = perlin_walk(six_hours * CELLS_PER_S, 51, 2, 0.15)
    assert correlation(signal, signal, 120) < 0.25


def test_the_naive_signal_does_repeat(six_hours):
    signal = naive(six_hours)
    assert correlation(signal, signal, 120) > 0.9


def test_twenty_seeds_are_independent():
    time_s = np.arange(0.0, 3 * 3600.0, 0.5)
    signals = [perlin_walk(time_s * CELLS_PER_S, seed, 2, 0.15) for seed in range(20)]
    largest = max(correlation(signals[i], signals[j]) for i in range(20) for j in range(20) if i != j)
    assert largest < 0.3


def test_the_naive_seed_is_only_a_shift():
    time_s = np.arange(0.0, 3600.0, 0.5)
    assert max(correlation(naive(time_s, 0), naive(time_s, base)) for base in (5, 11)) > 0.5


def spurious_acceleration(signal_of) -> float:
    """Difference of second differences after a day from those of a fine, smoothed copy (mm/s2 at 20 Hz)."""
    time_s = 86400.0 + np.arange(0.0, 60.0, 0.05)
    acceleration = np.diff(SCALE_MM * signal_of(time_s), 2) * 400.0
    smooth = np.convolve(acceleration, np.ones(9) / 9, mode="same")
    return float(np.abs(acceleration - smooth)[20:-20].std())


def test_after_a_day_it_is_as_smooth_as_at_the_start():
    assert spurious_acceleration(lambda t: perlin_walk(t * CELLS_PER_S, 51, 1, 1.0)) < 0.1


def test_the_naive_signal_is_stepped_after_a_day():
    assert spurious_acceleration(naive) > 1.0


def test_a_seed_gives_the_same_signal_again():
    time_s = np.arange(100.0)
    np.testing.assert_array_equal(perlin_walk(0.3 * time_s, 3, 1, 1.0), perlin_walk(0.3 * time_s, 3, 1, 1.0))


@pytest.mark.parametrize(
    ("cells", "octaves", "persistence", "name"),
    [
        (0.0, 1, 0.5, "cells_per_s"),
        (np.nan, 1, 0.5, "cells_per_s"),
        (np.inf, 1, 0.5, "cells_per_s"),
        (0.3, 0, 0.5, "octaves"),
        (0.3, 40, 0.5, "octaves"),
        (0.3, 2.5, 0.5, "octaves"),
        (0.3, 2, 0.0, "persistence"),
        (0.3, 2, np.nan, "persistence"),
    ],
)
def test_what_would_crash_the_package_is_refused_by_name(cells, octaves, persistence, name):
    with pytest.raises(UserError, match=name):
        gcode.Noise(cells_per_s=cells, octaves=octaves, persistence=persistence)
