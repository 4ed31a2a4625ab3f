"""Contacts and conductance against closed-form answers."""

from __future__ import annotations

import numpy as np
import pytest

from testbench.knit.catalogue import baseline, load_catalogue
from testbench.knit.conduction.contact import Contact
from testbench.knit.conduction.contact_relaxation import (
    ContactRelaxation,
    ContactRelaxationActivated,
    ContactRelaxationSpots,
)
from testbench.knit.conduction.electrical import CoatingCracks, Drift, DriftExponential, DriftPower
from testbench.knit.conduction.piezoresistance import (
    Piezoresistance,
    PiezoresistancePercolation,
    PiezoresistanceTunnelling,
)
from testbench.knit.conduction.pressure import ContactHysteresis, ContactSaturation, ContactSaturationHard

FORCE = np.linspace(0, 50, 401)
STRAIN = np.linspace(0, 0.4, 401)


def test_what_makes_the_conductance_from_the_strain_takes_the_place_of_contacts_and_back() -> None:
    of_strain = baseline().plus(Piezoresistance())
    assert list(of_strain) == ["elasticity", "hysteresis", "piezoresistance", "drift"]
    assert list(of_strain.plus(Contact())) == list(baseline())
    # What only changes the conductance stays where it is, after what makes it.
    bent = baseline().plus(load_catalogue().effects["contact_shape"]())
    assert list(bent.plus(Piezoresistance())) == [
        "elasticity",
        "hysteresis",
        "piezoresistance",
        "contact_shape",
        "drift",
    ]
    assert list(baseline().plus(CoatingCracks())) == [*baseline(), "coating_cracks"]


def test_holms_square_root() -> None:
    """Four times the force halves the contact resistance."""
    contact = Contact(contact_resistance_ohm=1e5, series_ohm=1e-4, parallel_S=1e-12, preload_N=1e-3)
    one, four = (contact.apply({"contact_force_N": np.array([force])}, 1.0)["conductance_S"][0] for force in (9, 36))
    assert four / one == pytest.approx(2.0, rel=1e-4)
    assert 1 / one == pytest.approx(1e5 / 3, rel=1e-3)


def test_parallel_and_series_paths_bound_the_conductance() -> None:
    contact = Contact(contact_resistance_ohm=1e5, series_ohm=1e4, parallel_S=1e-6, preload_N=1e-3)
    ends = np.array([-1e6, 1e12])
    g = contact.apply({"contact_force_N": ends}, 1.0)["conductance_S"]
    np.testing.assert_allclose(g, [1e-6, 1e-6 + 1e-4], rtol=1e-3)


def test_soft_saturation_ends_at_the_limit_and_halves_where_they_meet() -> None:
    soft = ContactSaturation(inverse_limit_per_N=0.5, hardness=1.0)
    pressing = soft.apply({"contact_force_N": np.array([2.0, 1e6])}, 1.0)["contact_force_N"]
    np.testing.assert_allclose(pressing, [1.0, 2.0], rtol=1e-5)


def test_the_hardest_soft_saturation_is_nearly_the_corner() -> None:
    signals = {"contact_force_N": FORCE}
    soft = ContactSaturation(inverse_limit_per_N=0.1, hardness=20).apply(signals, 1.0)["contact_force_N"]
    hard = ContactSaturationHard(inverse_limit_per_N=0.1).apply(signals, 1.0)["contact_force_N"]
    assert np.max(np.abs(soft - hard)) < 0.4  # 10 N * (1 - 2^(-1/20))
    assert hard[-1] == 10.0


def test_saturation_starts_a_fit_at_a_force_that_was_reached() -> None:
    limits_N = [
        1 / point["inverse_limit_per_N"] for point in ContactSaturationHard().starts({"contact_force_N": FORCE}, {})
    ]
    assert limits_N == pytest.approx(np.quantile(FORCE, [0.6, 0.75, 0.85, 0.93, 0.97]))


def test_relaxed_contact_settles_at_the_remaining_fraction() -> None:
    t = np.arange(0, 300, 0.1)
    effect = ContactRelaxation(fraction=0.4, tau_s=10)
    pressing = effect.apply({"contact_force_N": 5 * np.minimum(t, 1.0)}, 0.1)["contact_force_N"]
    assert pressing[-1] == pytest.approx(3.0)


def test_parted_spots_take_the_share_of_the_spectrum_back_with_them() -> None:
    t = np.arange(0, 400, 0.05)
    gained = np.exp(np.minimum(t / 0.05, 1.0))  # ln G rises by 1 within a sample
    effect = ContactRelaxationSpots(fraction=0.3, shortest_s=10.0, longest_s=100.0)
    left = np.log(effect.apply({"conductance_S": gained}, 0.05)["conductance_S"])
    times = np.geomspace(10, 100, 4001)
    faded = [1 - np.trapezoid(np.exp(-after / times), np.log(times)) / np.log(10) for after in (20.0, 350.0)]
    at = np.searchsorted(t, [20.0, 350.0])
    np.testing.assert_allclose(left[at], 1 - 0.3 * np.array(faded), atol=1e-3)


def test_activated_relaxation_takes_the_time_of_its_stretch() -> None:
    t = np.arange(0, 100, 0.05)
    gained = np.exp(np.minimum(t / 0.05, 1.0))  # ln G rises by 1 within a sample
    effect = ContactRelaxationActivated(fraction=0.3, tau_s=40.0, activation=2.0, span=0.4)
    for strain, tau_s in ((0.0, 40.0), (0.2, 40.0 / np.e), (0.4, 40.0 / np.e**2)):
        signals = {"strain": np.full(len(t), strain), "conductance_S": gained}
        left = np.log(effect.apply(signals, 0.05)["conductance_S"])
        at = np.searchsorted(t, 15.0)
        assert left[at] == pytest.approx(1 - 0.3 * -np.expm1(-15.0 / tau_s), abs=2e-3)


def test_contact_friction_shifts_the_two_branches_apart_by_twice_its_value() -> None:
    up_down = np.concatenate([FORCE, FORCE[::-1]])
    pressing = ContactHysteresis(friction_N=0.3, threshold_N=0.1).apply({"contact_force_N": up_down}, 1.0)
    shift = pressing["contact_force_N"] - up_down
    assert shift[200] - shift[601] == pytest.approx(0.6)


def test_gauge_factor_is_the_slope_of_relative_resistance() -> None:
    resistance = 1 / Piezoresistance(rest_ohm=2e5, gauge=4.0).apply({"strain": STRAIN}, 1.0)["conductance_S"]
    assert resistance[0] == pytest.approx(2e5)
    assert (resistance[1] - resistance[0]) / 2e5 / STRAIN[1] == pytest.approx(4.0, rel=3e-3)


def test_piezoresistance_can_rise_or_fall() -> None:
    for gauge, sign in ((5.0, -1), (-5.0, 1)):
        conductance = Piezoresistance(gauge=gauge).apply({"strain": STRAIN}, 1.0)["conductance_S"]
        assert np.all(sign * np.diff(conductance) > 0)


def test_tunnelling_is_exponential_on_top_of_the_length() -> None:
    g = PiezoresistanceTunnelling(rest_ohm=1e5, barrier=10.0).apply({"strain": np.array([0.0, 0.1])}, 1.0)
    assert g["conductance_S"][0] / g["conductance_S"][1] == pytest.approx(1.1 * np.e)


def test_percolation_ends_at_its_limit() -> None:
    effect = PiezoresistancePercolation(rest_ohm=1e5, limit=0.4, exponent=2.0, leak_S=1e-12)
    conductance = effect.apply({"strain": np.array([0.2, 0.4, 0.5])}, 1.0)["conductance_S"]
    np.testing.assert_allclose(conductance, [0.25e-5 + 1e-12, 1e-12, 1e-12], rtol=1e-9)


@pytest.mark.parametrize("law", [Piezoresistance(), PiezoresistanceTunnelling(), PiezoresistancePercolation()])
def test_rest_resistance_is_guessed_from_the_data(law: Piezoresistance) -> None:
    measured = {"strain": STRAIN, "conductance_S": 1e-3 * np.exp(-STRAIN)}
    assert law.started(measured, {}).model_dump()["rest_ohm"] == pytest.approx(1010, rel=0.01)


def test_drifts_reach_their_values() -> None:
    signals = {"time_s": np.array([0.0, 3600.0]), "conductance_S": np.ones(2)}
    assert Drift(per_decade=0.1, tau_s=3600 / 99).apply(signals, 1.0)["conductance_S"][1] == pytest.approx(10**0.2)
    exponential = DriftExponential(amount=0.5, tau_s=10).apply(signals, 1.0)["conductance_S"]
    np.testing.assert_allclose(np.log(exponential), [0, 0.5], atol=1e-12)
    power = DriftPower(per_hour=-0.2, exponent=0.5).apply(signals, 1.0)["conductance_S"]
    np.testing.assert_allclose(np.log(power), [0, -0.2], atol=1e-12)


def test_cracks_stay_open() -> None:
    strain = np.array([0.0, 0.2, 0.0, 0.1, 0.3])
    cracked = CoatingCracks(loss=1.0).apply({"strain": strain, "conductance_S": np.ones(5)}, 1.0)
    np.testing.assert_allclose(np.log(cracked["conductance_S"]), [0, -0.2, -0.2, -0.2, -0.3])
