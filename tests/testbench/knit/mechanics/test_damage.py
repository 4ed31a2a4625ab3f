"""Softening and jamming against closed-form answers."""

from __future__ import annotations

import numpy as np
import pytest

from testbench.knit.additive import ForceFactor
from testbench.knit.kernels import travelled
from testbench.knit.mechanics.damage import (
    CyclicFatigue,
    CyclicFatigueSwings,
    MullinsSoftening,
    MullinsSofteningDamage,
    MullinsSofteningHealing,
    MullinsSofteningPower,
)
from testbench.knit.mechanics.jamming import JammingStiffening
from tests.testbench.knit.samples import UP, UP_DOWN_UP


def factor(effect: ForceFactor, strain: np.ndarray, dt_s: float = 0.05) -> np.ndarray:
    return effect.apply({"strain": strain, "force_N": np.ones_like(strain)}, dt_s)["force_N"]


def test_virgin_curve_is_not_softened_and_the_second_stretch_is() -> None:
    soft = factor(MullinsSoftening(softening=0.3), UP_DOWN_UP)
    np.testing.assert_array_equal(soft[:301], 1.0)
    assert np.all(soft[301:900] < 1.0)
    assert soft[-1] == pytest.approx(1.0)


def test_powers_soften_below_the_largest_stretch_only() -> None:
    soft = factor(MullinsSofteningPower(softening=0.4, growth=1, power=2, span=0.3), UP_DOWN_UP)
    np.testing.assert_allclose(soft[:301], 1.0, atol=1e-5)
    np.testing.assert_allclose(soft[300:601], 1 - 0.4 * (1 - (UP[::-1] / 0.3) ** 2))
    assert soft[-1] == pytest.approx(1.0)


def test_what_is_remembered_of_a_stretch_fades_with_its_time() -> None:
    held = np.r_[UP, UP[-2:149:-1], np.full(400, 0.15)]  # up to 0.3, back to 0.15, and held there
    soft = factor(MullinsSofteningHealing(softening=0.4, heal_s=5.0, power=1.0, span=0.3), held)
    np.testing.assert_allclose(soft[:301], 1.0, atol=1e-5)
    remembered = [(lost * 0.3 / 0.4) for lost in 1 - soft[[500, 600]]]  # top - e
    assert remembered[1] / remembered[0] == pytest.approx(np.exp(-100 * 0.05 / 5.0), rel=1e-6)


def test_a_softening_that_never_heals_is_that_of_powers() -> None:
    for_ever = factor(MullinsSofteningHealing(softening=0.3, heal_s=1e5, power=1.5, span=0.3), UP_DOWN_UP)
    np.testing.assert_allclose(
        for_ever, factor(MullinsSofteningPower(softening=0.3, growth=1, power=1.5, span=0.3), UP_DOWN_UP), atol=1e-3
    )


def test_damage_is_that_of_the_largest_stretch() -> None:
    damaged = factor(MullinsSofteningDamage(softening=0.5, scale=0.3), UP_DOWN_UP)
    np.testing.assert_allclose(damaged[300:], 1 - 0.5 * (1 - np.exp(-1)))


def test_fatigue_counts_the_path_and_not_the_noise() -> None:
    path = travelled(UP_DOWN_UP, 0.002)
    assert path[-1] == pytest.approx(0.9, abs=0.01)
    noise = np.random.default_rng(0).uniform(-0.0015, 0.0015, 10_000)
    assert travelled(0.1 + noise, 0.002)[-1] < 0.002
    tired = factor(CyclicFatigue(loss=0.4, scale=0.45), UP_DOWN_UP)
    assert tired[-1] == pytest.approx(1 - 0.4 * (1 - np.exp(-2)), rel=0.01)


def test_each_swing_tires_with_a_power_of_its_size() -> None:
    small = np.tile(np.r_[UP[:101], UP[99::-1]], 9)  # nine times 0.1 and back: the path of three times 0.3 and back
    large = np.tile(np.r_[UP, UP[-2::-1]], 3)
    law = CyclicFatigueSwings(loss=0.5, scale=1.0, power=1.0, span=0.3)
    lost = [-np.log(1 - (1 - factor(law, strain)[-1]) / 0.5) for strain in (small, large)]
    assert lost[1] == pytest.approx(6 * 0.3**2 / (2 * 0.3), rel=0.02)
    assert lost[0] == pytest.approx(18 * 0.1**2 / (2 * 0.3), rel=0.05)


def test_jamming_adds_its_stiffness_beyond_the_onset() -> None:
    force = JammingStiffening(stiffness_N=50, onset=0.1, width=0.02).apply({"strain": UP, "force_N": 0 * UP}, 0.05)
    force_N = force["force_N"]
    assert force_N[99] == 0.0
    assert (force_N[250] - force_N[200]) / 0.05 == pytest.approx(50.0)


def test_onsets_start_a_fit_inside_the_strain_that_was_reached() -> None:
    onsets = [point["onset"] for point in JammingStiffening().starts({"strain": UP_DOWN_UP}, {})]
    assert min(onsets) == pytest.approx(0.105)
    assert max(onsets) < np.max(UP_DOWN_UP)


@pytest.mark.parametrize("growth", [0.0, 0.1, 1.0])
def test_powers_leave_a_knit_alone_that_was_never_stretched(growth: float) -> None:
    pulled = np.r_[np.full(20, -0.005), np.zeros(20), UP]
    soft = factor(MullinsSofteningPower(softening=0.3, growth=growth), pulled)
    np.testing.assert_allclose(soft, 1.0, atol=1e-12)


@pytest.mark.parametrize("power", [2.0, 8.0])
@pytest.mark.parametrize("rate_hz", [40.0, 10.0, 5.0])
def test_swings_tire_a_knit_alike_at_every_sampling_rate(power: float, rate_hz: float) -> None:
    """A swing of the whole span costs 1 / (power + 1) of its path on each way."""
    time_s = np.arange(0, 100, 1 / rate_hz)
    triangle = 0.3 * (1 - np.abs(1 - time_s % 2))
    fatigue = CyclicFatigueSwings(power=power, span=0.3, scale=100.0)
    path = -100.0 * np.log1p(-fatigue.tired({"strain": triangle})[-1])
    assert path == pytest.approx(100 * 0.3 * (1 - 0.004 / 0.3) / (power + 1), rel=0.03)


@pytest.mark.parametrize("dt_s", [0.001, 0.1, 1.0])
def test_a_softened_knit_heals_alike_at_every_sampling_rate(dt_s: float) -> None:
    time_s = np.arange(0, 40 + dt_s / 2, dt_s)
    strain = np.interp(time_s, [0, 10, 40], [0.0, 0.3, 0.0])  # on the way back it falls by 0.01 / s
    law = MullinsSofteningHealing(softening=0.5, heal_s=2.0, power=1.0, span=0.3)
    lost = 1 - factor(law, strain, dt_s)[np.searchsorted(time_s, 30.0 - 1e-9)]
    top = 0.1 + 0.01 * 2.0  # a lag of one time constant
    assert lost == pytest.approx(0.5 * top / 0.3 * (1 - 0.1 / top), rel=1e-3)
