"""Elastic laws: known answers, drawn to data, and one in the place of another."""

from __future__ import annotations

import numpy as np
import pytest

from testbench.knit.catalogue import baseline, load_catalogue
from testbench.knit.mechanics.elasticity import (
    ElasticityCubic,
    ElasticityGent,
    ElasticityOgden,
    ElasticityTwoSlopes,
    ElasticLaw,
)
from testbench.knit.model import inputs

CATALOGUE = load_catalogue()
STRAIN = np.linspace(0.0, 0.3, 121)
LAWS = [
    CATALOGUE["elasticity"]().replaced(stiffness_N=7.0, curvature=5.0, offset_N=0.2),
    ElasticityCubic(stiffness_N=9.0, square_N=-20.0, cube_N=150.0, offset_N=0.1),
    ElasticityOgden(modulus_N=0.8, power=12.0, linear_N=2.0, offset_N=-0.1),
    ElasticityTwoSlopes(stiffness_N=6.0, more_N=14.0, knee=0.15, width=0.02, offset_N=0.05),
    ElasticityGent(modulus_N=2.0, locking=float(ElasticityGent.bends[14]["locking"]), linear_N=1.0, offset_N=0.1),
]


def force_N(law, strain=STRAIN):
    return law.apply({"strain": strain}, 0.1)["force_N"]


def test_ogden_of_power_two_is_the_neo_hookean_law():
    stretch = 1 + STRAIN
    law = ElasticityOgden(modulus_N=3.0, power=2.0, linear_N=0.0)
    np.testing.assert_allclose(force_N(law), 3.0 * (stretch - stretch**-2), rtol=1e-12)


def test_gent_far_from_its_end_is_the_neo_hookean_law():
    stretch = 1 + STRAIN
    law = ElasticityGent(modulus_N=3.0, locking=10.0, linear_N=0.0)
    np.testing.assert_allclose(force_N(law), 3.0 * (stretch - stretch**-2), rtol=2e-3)


def test_gent_rises_without_end_towards_where_it_locks():
    """Chains at half of J_m double the force of free ones; near the end it is fifty times theirs, and stays so."""
    law = ElasticityGent(modulus_N=1.0, locking=0.3, linear_N=0.0)
    free = (1 + STRAIN) - (1 + STRAIN) ** -2
    invariant = (1 + STRAIN) ** 2 + 2 / (1 + STRAIN) - 3
    with np.errstate(invalid="ignore"):
        stiffening = force_N(law) / free
    half = int(np.argmin(np.abs(invariant - 0.5 * invariant[-1])))
    assert stiffening[half] == pytest.approx(2.0, rel=0.03)
    assert stiffening[-1] == pytest.approx(50.0, rel=1e-6)
    assert np.all(np.isfinite(force_N(law, np.linspace(-0.4, 2.0, 50))))


def test_a_cubic_has_its_slope_at_zero():
    step = 1e-6
    law = ElasticityCubic(stiffness_N=9.0, square_N=-20.0, cube_N=150.0)
    low, high = force_N(law, np.array([-step, step]))
    assert (high - low) / (2 * step) == pytest.approx(9.0, rel=1e-6)


def test_two_slopes_are_what_they_say_away_from_the_knee():
    slope = np.gradient(force_N(LAWS[3]), STRAIN)
    assert slope[2] == pytest.approx(6.0, rel=0.01)
    assert slope[-3] == pytest.approx(20.0, rel=0.01)


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.name)
def test_a_law_is_drawn_to_data_of_its_own_kind(law):
    drawn = type(law)().drawn_to(STRAIN, force_N(law), np.ones_like(STRAIN))
    np.testing.assert_allclose(force_N(drawn), force_N(law), atol=1e-8)


@pytest.mark.parametrize("law", [ElasticityOgden, ElasticityGent])
def test_a_law_that_the_force_would_take_beyond_a_bound_is_drawn_as_near_as_the_bound_lets_it(law):
    """Rubber of a modulus below 0, with a straight line that makes up for it, would follow this parabola best."""
    square_N = 6 * STRAIN + 15 * STRAIN**2
    drawn, line = law().drawn_to(STRAIN, square_N, np.ones_like(STRAIN)), np.polyfit(STRAIN, square_N, 1)
    assert np.std(force_N(drawn) - square_N) < 0.5 * np.std(np.polyval(line, STRAIN) - square_N)


def test_weights_say_which_strains_count():
    bent = force_N(LAWS[0]) + np.where(STRAIN > 0.25, 5.0, 0.0)
    drawn = type(LAWS[0])().drawn_to(STRAIN, bent, np.where(STRAIN > 0.25, 0.0, 1.0))
    np.testing.assert_allclose(force_N(drawn), force_N(LAWS[0]), atol=1e-8)


def test_a_law_takes_the_place_of_another_of_its_mechanism():
    model = baseline().plus(ElasticityTwoSlopes())
    assert list(model) == list(baseline())
    assert model["elasticity"].name == "elasticity_two_slopes"
    strain = 0.1 + 0.05 * np.sin(np.linspace(0, 20, 200))
    made = model.simulate(inputs(np.arange(200) * 0.1, strain), 0.1)
    friction_N = baseline().simulate(inputs(np.arange(200) * 0.1, strain), 0.1)["force_N"] - force_N(
        baseline()["elasticity"], strain
    )
    np.testing.assert_allclose(made["force_N"] - force_N(ElasticityTwoSlopes(), strain), friction_N, atol=1e-12)


def test_an_effect_with_a_strength_stands_beside_another_of_its_mechanism():
    model = baseline().plus(CATALOGUE["drift"]())
    assert [name for name in model if name.startswith("drift")] == ["drift", "drift_2"]


def test_every_elastic_law_of_the_catalogue_is_of_one_mechanism():
    laws = [law for law in CATALOGUE.effects.values() if issubclass(law, ElasticLaw)]
    assert len(laws) >= 4
    assert {law.mechanism for law in laws} == {"elasticity"}


def test_a_long_hold_does_not_draw_the_law_to_itself():
    strain = np.r_[STRAIN, np.full(20_000, STRAIN[-1])]
    relaxed = np.r_[force_N(LAWS[0]), np.full(20_000, 0.5 * force_N(LAWS[0])[-1])]
    (start,) = CATALOGUE["elasticity"]().starts({"strain": strain, "force_N": relaxed}, {})
    drawn = CATALOGUE["elasticity"]().near(**start)
    np.testing.assert_allclose(force_N(drawn)[:100], force_N(LAWS[0])[:100], atol=0.2)
