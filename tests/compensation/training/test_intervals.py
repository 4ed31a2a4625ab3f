"""The interval of a prediction: true on the average over recordings that differ, however few are known."""

from __future__ import annotations

import numpy as np
import pytest

from compensation.series import score
from compensation.series.preprocessing import series_of
from compensation.training.auto import margins_of, r2_elsewhere
from compensation.training.intervals import of_another, of_one_recording
from compensation.training.options import Options
from compensation.training.recalibration import SPREADS, one_sigma_changes
from tests.compensation.conftest import train


def held_out(rng: np.random.Generator, count: int, level: float, width: float) -> tuple[list, np.ndarray]:
    """Errors on recordings whose levels and widths differ by so much, and on another one.

    Each is predicted with the mean level of the others as its level, as by a method that learned from them.
    """
    levels = level * rng.standard_normal(count + 1)
    noise = [np.exp(width * rng.standard_normal()) * rng.standard_normal(400) for _ in levels]
    known = [levels[i] - np.delete(levels[:count], i).mean() + noise[i] for i in range(count)]
    return known, levels[count] - levels[:count].mean() + noise[count]


@pytest.mark.parametrize("count", [3, 4, 8])
@pytest.mark.parametrize(("level", "width"), [(0.1, 0.05), (0.2, 0.1), (0.3, 0.2)])
def test_it_holds_nine_of_ten_errors_on_another_recording(count: int, level: float, width: float) -> None:
    """85 to 95 %. Levels in standard deviations of the noise, widths as logarithms; the presets' are within these."""
    rng = np.random.default_rng(count)
    inside = []
    for _ in range(150):
        known, another = held_out(rng, count, level, width)
        low, high = of_another(known)
        inside.append(np.mean((low <= another) & (another <= high)))
    assert 0.85 < np.mean(inside) < 0.95


def test_of_many_that_are_alike_it_is_their_own() -> None:
    rng = np.random.default_rng(0)
    low, high = of_another([rng.standard_normal(5000) for _ in range(40)])
    assert (-low, high) == pytest.approx((1.645, 1.645), abs=0.05)


def test_of_one_recording_it_is_the_widest_part() -> None:
    rng = np.random.default_rng(0)
    folds = np.repeat([0, 1], 20_000)
    errors = rng.standard_normal(40_000) * np.where(folds == 0, 1.0, 3.0)
    low, high = margins_of(errors, folds, [40_000], np.zeros((4, 40_000)))
    assert (-low, high) == pytest.approx((3 * 1.645, 3 * 1.645), rel=0.05)


def test_of_one_recording_it_knows_how_far_others_wander() -> None:
    """Errors of spread 1, and a zero and a gain that put predictions off by 1.5 and by 2 times what they are."""
    rng = np.random.default_rng(0)
    errors, value = rng.standard_normal((2, 20_000))
    low, high = of_one_recording([errors], [np.stack([np.full(20_000, 1.5), 2.0 * value])])
    another = (
        rng.standard_normal(20_000) + 1.5 * rng.standard_normal(20_000) + 2.0 * value * rng.standard_normal(20_000)
    )
    assert np.mean((low <= another) & (another <= high)) == pytest.approx(0.90, abs=0.01)


def test_what_to_expect_elsewhere_is_what_draws_of_gain_and_zero_leave() -> None:
    """A prediction with an error of its own, off by a zero and by a gain that are drawn again and again."""
    rng = np.random.default_rng(0)
    truth = 2.0 * rng.standard_normal(2000)
    errors, off = 0.5 * rng.standard_normal(2000), np.stack([np.full(2000, 0.6), 0.3 * truth])
    drawn = [
        score.r2_ordinary(truth, truth - errors - zero * off[0] - gain * off[1])
        for zero, gain in rng.standard_normal((4000, 2))
    ]
    assert r2_elsewhere(errors, off, float(truth.std())) == pytest.approx(np.mean(drawn), abs=0.01)


def test_what_wanders_is_the_prior_of_recalibration(recordings) -> None:
    """A zero of the target that is a spread off moves every prediction by that spread."""
    part = series_of(recordings[0], "force", 20.0)
    compensator = train(recordings[:1], "force", Options(restarts=3, engine="fast"))
    changes = one_sigma_changes(compensator, [part, part])
    assert changes.shape == (4, 2 * len(part))
    np.testing.assert_allclose(changes[3], SPREADS[3] * compensator.scaling_out.scale)
    assert all(np.ptp(row) > 0 for row in changes[:3])


def test_folds_of_several_recordings_are_told_apart() -> None:
    rng = np.random.default_rng(0)
    three = [rng.standard_normal(1000) + level for level in (-1.0, 0.0, 1.0)]
    found = margins_of(np.concatenate(three), np.zeros(3000, dtype=int), [1000] * 3, None)
    assert found == of_another(three)
