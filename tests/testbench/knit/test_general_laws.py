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
    virgin = (top == STRAIN) & (top > 0.02)
    assert np.std(np.log(factor[virgin]) / top[virgin]) < 1e-9
    assert np.std(np.log(factor[~virgin])) > 1e-3
