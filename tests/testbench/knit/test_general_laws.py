"""Laws of any spectrum, any life or any curve: each holds the simple law of its mechanism as a special case."""

from __future__ import annotations

import numpy as np
import pytest

from testbench.knit.catalogue import load_catalogue
from testbench.knit.shapes.curves import LAW_TERMS

CATALOGUE = load_catalogue()
DT_S = 0.05
T = np.arange(0, 120, DT_S)
STRAIN = 0.1 - 0.1 * np.cos(0.9 * T) * np.cos(0.11 * T)
FORCE_N = 1.0 + 8.0 * STRAIN
SIGNALS = {
    "time_s": T,
    "strain": STRAIN,
    "force_N": FORCE_N,
    "contact_force_N": FORCE_N,
    "conductance_S": 1e-4 * (1 + STRAIN),
}


def made(name: str, **parameters: object) -> np.ndarray:
    effect = CATALOGUE[name].model_validate(parameters)
    return effect.apply(SIGNALS, DT_S)[effect.writes[0]]


def one_of(count: int, place: int, value: float) -> tuple[float, ...]:
    return tuple(value if k == place else 0.0 for k in range(count))


@pytest.mark.parametrize(
    ("general", "simple"),
    [
        (
            ("stress_relaxation_prony", {"fractions": one_of(7, 2, 0.2)}),
            ("stress_relaxation", {"fraction": 0.2, "tau_s": 10.0}),
        ),
        (
            ("contact_relaxation_prony", {"fractions": one_of(6, 2, 0.2)}),
            ("contact_relaxation", {"fraction": 0.2, "tau_s": 30.0}),
        ),
        (
            ("electrical_overshoot_prony", {"weights": one_of(6, 3, 0.3), "span": 0.2}),
            ("electrical_overshoot", {"gain": 1.5, "tau_s": 3.0}),
        ),
        (
            ("self_heating_prony", {"weights": one_of(6, 3, -0.1)}),
            ("self_heating", {"coefficient": -0.1, "tau_s": 100.0}),
        ),
        (
            ("cyclic_fatigue_weibull", {"loss": 0.2, "scale": 4.0, "shape": 1.0}),
            ("cyclic_fatigue", {"loss": 0.2, "scale": 4.0}),
        ),
        # Far below its scale the loss grows with a power of the path, here the first.
        (
            ("coating_wear_weibull", {"loss": 10.0, "scale": 1e5, "shape": 1.0}),
            ("coating_wear", {"loss": 10.0 / 1e5 * 100}),
        ),
        (
            ("coating_cracks_weibull", {"loss": 10.0, "scale": 10.0, "shape": 1.0}),
            ("coating_cracks", {"loss": 1.0}),
        ),
    ],
    ids=lambda law: law[0],
)
def test_a_general_law_holds_the_simple_one(general, simple):
    there, here = made(general[0], **general[1]), made(simple[0], **simple[1])
    plain = SIGNALS[CATALOGUE[simple[0]].writes[0]]
    np.testing.assert_allclose(there - plain, here - plain, rtol=0, atol=0.02 * np.max(np.abs(here - plain)))


def test_what_a_curve_over_the_rate_adds_is_told_by_the_rate_alone():
    speed = np.gradient(STRAIN, DT_S)
    weights = tuple(0.05 * np.random.default_rng(1).standard_normal(LAW_TERMS))
    factor = (
        made("viscous_rate_stiffening_curve", weights=weights, reach_per_s=float(np.max(np.abs(speed)))) / FORCE_N
    )
    order = np.argsort(speed)
    assert np.max(np.abs(np.diff(factor[order]))) < 0.05 * np.ptp(factor)


def test_a_curve_of_softening_leaves_a_stretch_beyond_all_others_alone():
    weights = tuple(0.1 * np.random.default_rng(2).standard_normal(LAW_TERMS))
    factor = made("mullins_softening_curve", weights=weights, span=0.2) / FORCE_N
    top = np.maximum.accumulate(STRAIN)
    virgin = top == STRAIN
    np.testing.assert_allclose(factor[virgin], 1.0, atol=1e-12)
    assert np.std(np.log(factor[~virgin])) > 1e-3


def test_a_curve_over_the_rate_leaves_a_still_knit_alone():
    weights = tuple(0.1 * np.random.default_rng(3).standard_normal(LAW_TERMS))
    law = CATALOGUE["viscous_rate_stiffening_curve"].model_validate({"weights": weights})
    still = {**SIGNALS, "strain": np.full_like(T, 0.1)}
    np.testing.assert_allclose(law.apply(still, DT_S)["force_N"] / FORCE_N, 1.0, atol=1e-12)


@pytest.mark.parametrize("name", ["electrical_overshoot_motion", "electrical_overshoot_reversal"])
@pytest.mark.parametrize("dt_s", [0.01, 0.1])
def test_a_knit_was_at_rest_before_a_recording_that_begins_in_motion(name, dt_s):
    """What it does then is the same as after a rest, whatever the sampling rate."""
    law = CATALOGUE[name].model_validate({"gain": 0.05, "tau_s": 5.0})

    def changes(rest_s: float) -> np.ndarray:
        time_s = np.arange(0, rest_s + 8, dt_s)
        strain = 0.05 * np.maximum(time_s - rest_s, 0)
        log_g = np.log(law.apply({"strain": strain, "conductance_S": np.ones_like(strain)}, dt_s)["conductance_S"])
        return log_g[np.searchsorted(time_s, rest_s + np.array([2.0, 4.0, 6.0]) - 1e-9)]

    assert changes(0.0) == pytest.approx(changes(10.0), rel=0.05)


@pytest.mark.parametrize(
    ("name", "quick", "slow", "share"),
    [
        ("stress_relaxation_two_times", "fast_s", "slow_s", "share"),
        ("load_cell_creep_two_times", "fast_s", "slow_s", "share"),
        ("self_heating_two_masses", "fast_s", "slow_s", "share"),
        ("stress_relaxation_spectrum", "shortest_s", "longest_s", ""),
        ("contact_relaxation_spectrum", "shortest_s", "longest_s", ""),
        ("contact_relaxation_spots", "shortest_s", "longest_s", ""),
    ],
)
def test_two_orders_of_times_are_not_one_law(name, quick, slow, share):
    """Where the slow time is below the quick one, there is one time: a fit cannot end at the mirror of its answer."""

    def law(quick_s: float, slow_s: float, of_quick: float) -> np.ndarray:
        return made(name, **{quick: quick_s, slow: slow_s}, **({share: of_quick} if share else {}))

    ordered, swapped = law(30.0, 90.0, 0.3), law(90.0, 30.0, 0.7)
    plain = SIGNALS[CATALOGUE[name].writes[0]]
    assert np.max(np.abs(ordered - swapped)) > 0.02 * np.max(np.abs(ordered - plain))
    np.testing.assert_array_equal(swapped, law(90.0, 90.0, 0.1 if not share else 0.7))
    np.testing.assert_allclose(swapped, law(90.0, 90.0, 0.2), rtol=1e-12)


@pytest.mark.parametrize("rate_hz", [1000, 40, 10, 2])
def test_contacts_that_part_the_sooner_the_more_they_are_stretched_do_so_at_any_sampling_rate(rate_hz):
    """On a ramp of the strain, and of ln G, by the integral of 1 / tau: 1 / tau = exp(c t) / tau_0."""
    time_s = np.arange(0, 20, 1 / rate_hz)
    law = CATALOGUE["contact_relaxation_activated"].model_validate(
        {"fraction": 0.4, "tau_s": 20.0, "activation": 3.0, "span": 0.2}
    )
    signals = {"strain": 0.01 * time_s, "conductance_S": np.exp(0.05 * time_s)}
    lost = -(np.log(law.apply(signals, 1 / rate_hz)["conductance_S"]) - 0.05 * time_s) / 0.4
    growth = 3.0 / 20.0
    fine_s = np.linspace(0, time_s[-1], 40001)
    kept = np.exp(np.expm1(growth * fine_s) / (growth * 20.0))  # 1 over what is left of a step made then
    # y' = (x - y) / tau from y = 0, for x = 0.05 t: y = x minus what of the ramp has not yet been followed
    left = np.concatenate([[0.0], np.cumsum(0.5 * (kept[1:] + kept[:-1]) * np.diff(fine_s))]) / kept
    followed = np.interp(time_s, fine_s, 0.05 * (fine_s - left))
    np.testing.assert_allclose(lost, followed, atol=3e-3 * followed[-1])
