"""Relaxation and viscosity against closed-form answers."""

from __future__ import annotations

from decimal import Decimal, localcontext

import numpy as np
import pytest

from testbench.knit import spectra
from testbench.knit.catalogue import load_catalogue
from testbench.knit.effect import Stage
from testbench.knit.filters import hold_coefficients, lowpass, memory, rate
from testbench.knit.mechanics.elasticity import Elasticity
from testbench.knit.mechanics.rate_stiffening import (
    ViscousRateStiffening,
    ViscousRateStiffeningEyring,
    ViscousRateStiffeningMaxwell,
)
from testbench.knit.mechanics.relaxation import (
    StressRelaxation,
    StressRelaxationActivated,
    StressRelaxationArm,
    StressRelaxationArmPower,
    StressRelaxationFindley,
    StressRelaxationLog,
    StressRelaxationNonlinear,
    StressRelaxationPower,
    StressRelaxationSeries,
    StressRelaxationSpectrum,
    StressRelaxationTwoTimes,
)
from testbench.knit.model import KnitModel, inputs

DT_S = 0.05
T = np.arange(0, 200, DT_S)
RAMP_S = 5.0
STEP = np.minimum(T / DT_S, 1.0)  # reaches 1 within one sample
RAMP_AND_HOLD = np.minimum(T / RAMP_S, 1.0)


@pytest.mark.parametrize("tau_s", [0.5, 7.0, 90.0])
def test_prony_term_after_a_ramp_follows_the_textbook(tau_s: float) -> None:
    """During the ramp t/T - g (t - tau (1 - e^-t/tau)) / T; in the hold an exponential decay to 1 - g."""
    g = 0.4
    force = StressRelaxation(fraction=g, tau_s=tau_s).apply({"force_N": RAMP_AND_HOLD}, DT_S)["force_N"]
    ramping = (T - g * (T - tau_s * -np.expm1(-T / tau_s))) / RAMP_S
    since = np.maximum(T - RAMP_S, 0.0)
    holding = 1 - g + g * tau_s / RAMP_S * -np.expm1(-RAMP_S / tau_s) * np.exp(-since / tau_s)
    np.testing.assert_allclose(force, np.where(T <= RAMP_S, ramping, holding), atol=1e-12)


def test_power_law_relaxation_after_a_step_is_the_power_law() -> None:
    n, tau_s = 0.2, 3.0
    force = StressRelaxationPower(exponent=n, tau_s=tau_s).apply({"force_N": STEP}, DT_S)["force_N"]
    np.testing.assert_allclose(force[5:], (1 + (T[5:] - DT_S / 2) / tau_s) ** -n, atol=2e-4)


def test_logarithmic_relaxation_after_a_step_loses_the_same_per_decade() -> None:
    force = StressRelaxationLog(per_decade=0.06, tau_s=1.0).apply({"force_N": STEP}, DT_S)["force_N"]
    at = np.searchsorted(T, [1.0, 19.0, 199.0])
    np.testing.assert_allclose(force[at], 1 - 0.06 * np.log10(1 + T[at] - DT_S / 2), atol=2e-4)


@pytest.mark.parametrize(
    ("arm", "like"),
    [
        (StressRelaxationArm(tau_s=7.0), StressRelaxation(tau_s=7.0)),
        (StressRelaxationArmPower(tau_s=2.0, exponent=0.4), StressRelaxationFindley(tau_s=2.0, exponent=0.4)),
    ],
    ids=["one time", "a power of time"],
)
def test_an_arm_relaxes_as_a_share_of_a_force_that_follows_its_curve_and_leaves_friction_alone(
    arm: StressRelaxationArm | StressRelaxationArmPower, like: StressRelaxation | StressRelaxationFindley
) -> None:
    """A spring of 2 N at the span whose curve is the square of the strain, of which 0.3 is lost."""
    strain, friction_N = 0.3 * np.sin(T / 9.0) ** 2, 0.2 * np.sign(np.cos(T / 9.0))
    spring_N = 2.0 * (strain / 0.3) ** 2
    alone_N = like.replaced(fraction=0.3).apply({"force_N": spring_N}, DT_S)["force_N"]
    arm = arm.replaced(arm_force_N=0.6, power=2.0, span=0.3)
    force_N = arm.apply({"strain": strain, "force_N": spring_N + friction_N}, DT_S)["force_N"]
    np.testing.assert_allclose(force_N, alone_N + friction_N, atol=1e-12)


def test_nonlinear_relaxation_of_half_the_force_loses_less_than_half() -> None:
    full, half = (
        StressRelaxationNonlinear(fraction=0.3, tau_s=5.0, power=2.0, span_N=1.0).apply({"force_N": f * STEP}, DT_S)
        for f in (1.0, 0.5)
    )
    assert full["force_N"][-1] == pytest.approx(0.7, abs=1e-6)
    assert half["force_N"][-1] == pytest.approx(0.5 - 0.3 * 0.25, abs=1e-6)


def test_nonlinear_relaxation_with_power_one_is_the_linear_one() -> None:
    linear = StressRelaxation(fraction=0.3, tau_s=5.0).apply({"force_N": STEP}, DT_S)["force_N"]
    same = StressRelaxationNonlinear(fraction=0.3, tau_s=5.0, power=1.0).apply({"force_N": STEP}, DT_S)["force_N"]
    np.testing.assert_allclose(same, linear, atol=1e-12)


@pytest.mark.parametrize("load", [0.0, 0.25, 1.0])
def test_activated_relaxation_in_a_hold_is_an_exponential_whose_time_the_load_shortens(load: float) -> None:
    """The step itself, one sample long, takes half a sample more or less of the decay."""
    before = np.where(T == 0, 0.0, load)
    law = StressRelaxationActivated(fraction=0.3, tau_s=30.0, activation=2.0, span_N=1.0)
    force = law.apply({"force_N": before}, DT_S)["force_N"]
    holding = load * (1 - 0.3 * -np.expm1(-T / (30.0 * np.exp(-2.0 * load))))
    np.testing.assert_allclose(force[1:], holding[1:], atol=0.3 * load * DT_S / 4.0)
    linear, same = StressRelaxation(fraction=0.3, tau_s=30.0), law.near(activation=0.0)
    plain, without = (one.apply({"force_N": RAMP_AND_HOLD}, DT_S)["force_N"] for one in (linear, same))
    np.testing.assert_allclose(without, plain, atol=1e-5)


def test_what_gives_way_in_series_takes_its_share_of_a_step():
    strain = StressRelaxationSeries(fraction=0.4, tau_s=5.0).apply({"strain": 0.2 * STEP}, DT_S)["strain"]
    left = 1 + 0.4 * np.expm1(-(T[1:] - DT_S / 2) / 5.0)
    np.testing.assert_allclose(strain[1:], 0.2 * left, atol=1e-5)


def test_box_spectrum_loses_its_whole_fraction_in_the_end() -> None:
    t = np.arange(0, 3000, 0.5)
    effect = StressRelaxationSpectrum(fraction=0.3, shortest_s=1, longest_s=50)
    force = effect.apply({"force_N": np.minimum(t, 1.0)}, 0.5)["force_N"]
    assert force[-1] == pytest.approx(0.7, abs=1e-9)
    assert np.all(np.diff(force[10:]) <= 1e-15)


def test_spectra_are_their_kernels() -> None:
    """ln(1 + t/tau) and 1 - (1 + t/tau)^-n, rebuilt from their exponentials."""
    t = np.geomspace(0.01, 3e3, 50)[:, None]
    for (times, weights), kernel in (
        (spectra.logarithm(2.0), np.log1p(t[:, 0] / 2)),
        (spectra.power(2.0, 0.3), 1 - (1 + t[:, 0] / 2) ** -0.3),
    ):
        np.testing.assert_allclose(-np.expm1(-t / times) @ weights, kernel, atol=5e-4)


def test_lowpass_of_a_ramp_lags_by_its_time_constant() -> None:
    y = lowpass(3 * T, 4.0, DT_S)
    np.testing.assert_allclose(y, 3 * (T - 4.0 * -np.expm1(-T / 4.0)), atol=1e-11)


def test_lowpass_without_a_time_constant_is_the_signal() -> None:
    np.testing.assert_allclose(lowpass(RAMP_AND_HOLD, 0.0, DT_S), RAMP_AND_HOLD, atol=1e-12)


def test_lowpass_can_start_cold() -> None:
    np.testing.assert_allclose(lowpass(np.ones_like(T), 10.0, DT_S, start=0.0), -np.expm1(-T / 10), atol=1e-12)


def test_slow_filters_keep_their_precision() -> None:
    """b0 of a filter a billion times slower than the sampling is dt / (2 tau), not rounding noise."""
    _, b0, b1 = hold_coefficients(np.array([1e9]), 1.0)
    np.testing.assert_allclose([b0[0], b1[0]], 0.5e-9, rtol=1e-8)


@pytest.mark.parametrize("ratio", [1e-6, 9.99e-4, 1.01e-3, 0.1, 1.0, 30.0])
def test_the_coefficients_are_exact_at_every_step(ratio: float) -> None:
    """By 50 digits; a series that was cut short was off by 1.7e-7 at a step of a thousandth of the time constant."""
    with localcontext(prec=50):
        exact = Decimal(ratio)
        kept = (-exact).exp()
        mean = (1 - kept) / exact
        b0, b1 = 1 - mean, mean - kept
    found = [float(values[0]) for values in hold_coefficients(np.array([1.0]), ratio)]
    np.testing.assert_allclose(found, [float(x) for x in (kept, b0, b1)], rtol=1e-12)


def test_memory_of_one_term_is_the_lowpass() -> None:
    x = np.sin(T)
    np.testing.assert_allclose(
        memory(x, np.array([6.0]), np.array([2.0]), DT_S), 2 * lowpass(x, 6.0, DT_S), atol=1e-12
    )


def test_rate_of_a_ramp_is_its_slope() -> None:
    np.testing.assert_allclose(rate(0.02 * T, DT_S)[40:], 0.02, rtol=1e-6)


@pytest.mark.parametrize(("speed", "exponent", "expected"), [(0.1, 1.0, 0.5), (0.2, 1.0, 1.0), (0.4, 0.5, 1.0)])
def test_dashpot_force_grows_with_a_power_of_the_rate(speed: float, exponent: float, expected: float) -> None:
    effect = ViscousRateStiffening(force_at_rate_N=0.5, exponent=exponent)
    force = effect.apply({"strain": speed * T, "force_N": np.zeros_like(T)}, DT_S)["force_N"]
    assert force[-1] == pytest.approx(expected)


@pytest.mark.parametrize("speed", [1e-4, 2e-4])
def test_far_below_its_plateau_a_power_of_the_rate_is_a_linear_dashpot(speed: float) -> None:
    effect = ViscousRateStiffening(force_at_rate_N=0.5, exponent=0.4, rate0_per_s=0.02)
    force = effect.apply({"strain": speed * T, "force_N": np.zeros_like(T)}, DT_S)["force_N"]
    assert force[-1] == pytest.approx(0.5 * (speed / 0.1) * (0.02 / 0.1) ** -0.6, rel=1e-3)


@pytest.mark.parametrize("rate_hz", [1000, 40, 10, 1])
@pytest.mark.parametrize("rate0_per_s", [1e-5, 0.02, 0.1])
def test_a_power_of_the_rate_is_that_of_its_formula_up_to_the_highest_plateau(rate_hz, rate0_per_s) -> None:
    """The force at 10 %/s is `force_at_rate_N` where the plateau lies far below; at the highest one it is less."""
    time_s = np.arange(0, 10, 1 / rate_hz)
    signals = {"strain": 0.1 * time_s, "force_N": np.ones_like(time_s)}
    expected = 0.5 * (1 + (rate0_per_s / 0.1) ** 2) ** -0.3
    for pressed in (0.0, 0.3, 1.0):  # at the tension it is the same
        law = ViscousRateStiffening(
            force_at_rate_N=0.5, exponent=0.4, rate0_per_s=rate0_per_s, pressed=pressed, tension_N=1.0
        )
        np.testing.assert_allclose(law.apply(signals, 1 / rate_hz)["force_N"], 1 + expected, rtol=1e-9)


@pytest.mark.parametrize("law", [ViscousRateStiffening, ViscousRateStiffeningEyring])
def test_what_the_tension_presses_on_grows_in_proportion_to_it(law) -> None:
    signals = {"strain": 0.02 * T, "force_N": np.full_like(T, 3.0)}
    free, half, pressed = (
        law(pressed=share, tension_N=2.0).apply(signals, DT_S)["force_N"] - 3.0 for share in (0.0, 0.5, 1.0)
    )
    np.testing.assert_allclose(pressed, 1.5 * free)
    np.testing.assert_allclose(half, 1.25 * free)


def test_a_maxwell_arm_approaches_the_force_of_its_dashpot_and_loses_it_within_its_time() -> None:
    tau_s, speed_per_s = 0.4, 0.02
    effect = ViscousRateStiffeningMaxwell(force_at_rate_N=0.5, tau_s=tau_s)
    signals = {"strain": speed_per_s * RAMP_S * RAMP_AND_HOLD, "force_N": np.zeros_like(T)}
    dashpot_N = 0.5 * speed_per_s / 0.1
    since = np.maximum(T - RAMP_S, 0.0)
    built_up = -np.expm1(-np.minimum(T, RAMP_S) / tau_s)
    found_N = effect.apply(signals, DT_S)["force_N"]
    np.testing.assert_allclose(found_N, dashpot_N * built_up * np.exp(-since / tau_s), atol=1e-12)


def test_eyring_force_adds_the_same_for_every_tenfold_rate() -> None:
    effect = ViscousRateStiffeningEyring(force_per_efold_N=0.1, rate0_per_s=1e-4)
    forces = [
        effect.apply({"strain": speed * T, "force_N": np.zeros_like(T)}, DT_S)["force_N"][-1]
        for speed in (0.01, 0.1, 1.0)
    ]
    np.testing.assert_allclose(np.diff(forces), 0.1 * np.log(10), rtol=1e-3)


def test_two_times_are_the_sum_of_their_terms() -> None:
    both = StressRelaxationTwoTimes(fraction=0.5, fast_s=2.0, slow_s=40.0, share=0.3)
    terms = [StressRelaxation(fraction=0.15, tau_s=2.0), StressRelaxation(fraction=0.35, tau_s=40.0)]
    lost = [RAMP_AND_HOLD - term.apply({"force_N": RAMP_AND_HOLD}, DT_S)["force_N"] for term in terms]
    force = both.apply({"force_N": RAMP_AND_HOLD}, DT_S)["force_N"]
    np.testing.assert_allclose(RAMP_AND_HOLD - force, sum(lost), atol=1e-12)


WITH_WORK_TO_GIVE = {"viscous_rate_stiffening_log", "viscous_rate_stiffening_magnitude"}  # see what they say of it


@pytest.mark.parametrize("slow_back", [False, True])
def test_a_closed_cycle_takes_work_whatever_law_the_force_follows(slow_back: bool) -> None:
    dt_s, period_s, cycles = 0.02, 10.5, 12
    time_s = np.arange(0, cycles * period_s + dt_s / 2, dt_s)
    strain = np.interp(time_s % period_s, [0, 0.5 if slow_back else 10, period_s], [0, 0.3, 0])
    last = slice(round((cycles - 1) * period_s / dt_s), None)
    laws = load_catalogue().effects.values()
    giving = set()
    for law in (law for law in laws if law.stage is Stage.MECHANICS and law is not Elasticity):
        force_N = KnitModel.of(Elasticity(), law()).simulate(inputs(time_s, strain), dt_s)["force_N"]
        if np.trapezoid(force_N[last], strain[last]) < -1e-3 * np.ptp(force_N):
            giving.add(law.name)
    assert giving == (set() if slow_back else WITH_WORK_TO_GIVE)
