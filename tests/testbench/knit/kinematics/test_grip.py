"""Lost motion of the drive and slack of the knit against closed-form answers."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from testbench.knit.kinematics.grip import (
    ActuatorBacklash,
    ActuatorBacklashCompensated,
    ActuatorBacklashWindup,
    LeadscrewRipple,
    LeadscrewRippleWave,
    Slack,
    SlackGradual,
)
from tests.testbench.knit.samples import UP, UP_DOWN_UP


def test_slack_is_taken_up_first() -> None:
    strain = Slack(slack=0.1).apply({"strain": np.array([-0.05, 0.0, 0.05, 0.1, 0.3])}, 1.0)["strain"]
    np.testing.assert_allclose(strain, [-0.05, 0, 0, 0, 0.2])


def test_gradual_slack_is_the_mean_over_yarns_of_logistic_lengths() -> None:
    lengths = np.random.default_rng(3).logistic(0.1, 0.2 * 0.1, 200_000)
    stretched = np.array([0.02, 0.1, 0.15, 0.3])
    bears = [np.mean(np.maximum(e - lengths, 0.0) - np.maximum(-lengths, 0.0)) for e in stretched]
    strain = SlackGradual(slack=0.1, spread=0.2).apply({"strain": stretched}, 1.0)["strain"]
    np.testing.assert_allclose(strain, bears, atol=2e-4)


def test_gradual_slack_of_no_spread_is_slack() -> None:
    taken, gradual = Slack(slack=0.1), SlackGradual(slack=0.1, spread=0.02)
    strain = np.array([-0.05, 0.0, 0.05, 0.15, 0.3])
    expected = taken.apply({"strain": strain}, 1.0)["strain"]
    np.testing.assert_allclose(gradual.apply({"strain": strain}, 1.0)["strain"], expected, atol=1e-6)


def test_windup_closes_exponentially_over_its_travel() -> None:
    effect = ActuatorBacklashWindup(gap=0.01, travel=0.02)
    lost = UP_DOWN_UP - effect.apply({"strain": UP_DOWN_UP}, 1.0)["strain"]
    np.testing.assert_allclose(lost[:301], 0.005 * -np.expm1(-UP / 0.02))
    back = 0.3 - UP_DOWN_UP[300:601]
    turned = lost[300]
    np.testing.assert_allclose(lost[300:601], -0.005 + (turned + 0.005) * np.exp(-back / 0.02))


def test_a_ripple_of_any_form_holds_a_saw_tooth() -> None:
    """Its Fourier series: sin(k a) / k."""
    k = np.arange(2, 7)
    harmonics = tuple(np.column_stack([1 / k, np.zeros(len(k))]).ravel())
    strain = LeadscrewRippleWave(amplitude=0.01, pitch=0.1, harmonics=harmonics).apply({"strain": UP}, 1.0)["strain"]
    angle = 2 * np.pi * UP / 0.1
    series = sum(np.sin(n * angle) / n for n in range(1, 7))
    np.testing.assert_allclose(strain - UP, 0.01 * (series - series[0]), atol=1e-15)


def test_yarns_that_get_straight_all_along_are_a_bend_and_those_with_an_end_are_not() -> None:
    motion = {"strain": np.linspace(0, 0.3, 50)}
    assert SlackGradual(spread=1.4).is_a_bend(motion)
    assert not SlackGradual(spread=0.4).is_a_bend(motion)
    assert not Slack().is_a_bend(motion)


def test_a_ripple_of_two_turns_within_the_motion_is_a_bend() -> None:
    motion = {"strain": np.linspace(0.0, 0.3, 100)}
    assert LeadscrewRipple(pitch=0.15).is_a_bend(motion)
    assert not LeadscrewRipple(pitch=0.06).is_a_bend(motion)


def test_ripple_repeats_with_the_pitch() -> None:
    strain = LeadscrewRipple(amplitude=0.01, pitch=0.1).apply({"strain": UP}, 1.0)["strain"]
    error = strain - UP
    np.testing.assert_allclose(error[[0, 100, 200, 25]], [0, 0, 0, 0.01], atol=1e-12)


def test_a_spread_gap_closes_little_by_little_and_loses_as_much_in_the_end() -> None:
    at_once, gradual = (
        UP_DOWN_UP - ActuatorBacklash(gap=0.02, spread=spread).apply({"strain": UP_DOWN_UP}, 1.0)["strain"]
        for spread in (0.0, 0.5)
    )
    np.testing.assert_allclose(gradual[[0, 300, 340]], at_once[[0, 300, 340]], atol=1e-12)
    # gaps of 10 to 30 thousandths, half of it each way: at 10 of travel the two smallest are closed
    assert gradual[10] == pytest.approx(np.mean([5, 7.5, 10, 10, 10]) / 1000)
    assert at_once[10] == pytest.approx(0.01)


def test_a_wrongly_compensated_backlash_jumps_by_the_same_motion_at_every_turn() -> None:
    """After long strokes, and after one that is shorter than the travel."""
    targets = [0.0, 0.2, 0.1, 0.101, 0.05]
    e = np.concatenate([np.linspace(a, b, 400, endpoint=False) for a, b in pairwise(targets)])
    effect = ActuatorBacklashCompensated(gap=0.01, travel=0.004)
    lost = e - effect.apply({"strain": e}, 0.1)["strain"]
    assert lost[0] == 0
    assert lost[399] == pytest.approx(0.005, rel=1e-6)  # wound up outwards
    assert lost[799] == pytest.approx(-0.005, rel=1e-6)  # and on the way back
    short = lost[1199]  # the end of a stroke of a quarter of the travel
    assert short == pytest.approx(0.005 * (1 - 2 * np.exp(-0.001 / 0.004)), rel=0.01)
    assert np.max(lost[1200:1300]) > 3 * short  # after which the whole of it is made up for all the same
    made_up = ActuatorBacklashCompensated(gap=-0.01, travel=0.004).apply({"strain": e}, 0.1)["strain"]
    np.testing.assert_allclose(made_up - e, lost, atol=1e-15)
    at_once = ActuatorBacklashCompensated(gap=0.01, travel=1e-5).apply({"strain": e}, 0.1)["strain"]
    # The sample behind a turn has jumped, though so short a way back might still be a wobble.
    np.testing.assert_allclose((e - at_once)[[400, 401, 800, 840]], [0.005, -0.005, -0.005, 0.005], rtol=1e-3)
    ramp = np.linspace(0.0, 0.2, 400)
    np.testing.assert_allclose((ramp - effect.apply({"strain": ramp}, 0.1)["strain"])[-2:], 0.005, rtol=1e-6)
    np.testing.assert_array_less(np.abs(np.diff(lost[:1200])), 2e-3)  # what is wound up gradually does not jump


@pytest.mark.parametrize(("turns", "phase_rad"), [(3.0, 0.5), (7.5, -2.0), (12.0, 3.0)])
def test_the_pitch_of_a_screw_is_read_from_the_misfit(turns: float, phase_rad: float) -> None:
    time_s = np.arange(0, 300, 0.08)
    strain = 0.12 - 0.12 * np.cos(0.31 * time_s) * np.cos(0.017 * time_s)
    pitch = float(np.ptp(strain)) / turns
    hidden = LeadscrewRipple(amplitude=1e-3, pitch=pitch, phase_rad=phase_rad)
    signals = {"time_s": time_s, "strain": strain, "force_N": 8 * strain + 40 * strain**3}
    off = hidden.apply(signals, 0.08)["strain"] - strain
    misfit = (8 + 120 * strain**2) * off + 5e-3 * np.random.default_rng(0).standard_normal(len(strain))
    first = LeadscrewRipple().starts(signals, {"force": misfit})[0]
    assert first["pitch"] == pytest.approx(pitch, rel=0.02)
    assert np.cos(first["phase_rad"] - phase_rad) > 0.9
