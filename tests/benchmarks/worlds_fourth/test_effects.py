"""Every effect of the fourth simulator acts where it says, as strongly as asked, and hardly at size zero."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from worlds_fourth import MECHANISMS, UNKNOWN_KINDS, Case, make_case
from worlds_fourth.case import make_sensor
from worlds_fourth.effects.choice import KNOWN, OUTSIDE, choose_effect
from worlds_fourth.effects.effect import Form
from worlds_fourth.strength import FLOORS, strengths

from testbench.knit.catalogue import load_catalogue
from testbench.recordings.channels import FORCE, RESISTANCE

KINDS = [*MECHANISMS, *UNKNOWN_KINDS]
SPECIMEN, (RECORD, _), _ = make_sensor([], 5, 2.0, 40.0, ["force", "conductance"])
FILTERS = "channel_lag"  # a first-order filter is half a sample late even at no size


def changes(case: Case, plain: Case) -> dict[str, np.ndarray]:
    """What the effect did to force in N and ln G of the calibration; the noise of both cases is the same."""
    one, other = case.calibration, plain.calibration
    return {"force": one[FORCE] - other[FORCE], "conductance": np.log(other[RESISTANCE] / one[RESISTANCE])}


def test_the_catalogue_has_every_mechanism_and_none_of_the_other_kinds() -> None:
    effects = load_catalogue().effects
    assert set(MECHANISMS) <= set(effects)
    assert not set(UNKNOWN_KINDS) & set(effects)


def test_seeds_draw_all_laws_of_an_effect() -> None:
    specimens = [replace(SPECIMEN, seed=seed) for seed in range(60)]
    drawn = [choose_effect(name, specimen).form for name in KINDS for specimen in specimens]
    assert {(form.mechanism, form.name) for form in drawn} == {
        (form.mechanism, form.name) for form in (*KNOWN, *OUTSIDE)
    }


@pytest.mark.parametrize("name", KINDS)
def test_an_effect_is_as_strong_as_asked_in_the_channel_that_shows_more(name: str) -> None:
    """In the first of a few sensors in which it can be: some laws stay weak in some, and the truth says so."""
    cases = (make_case(name, 1.0, seed, minutes=2.0) for seed in range(40 + KINDS.index(name), 200, 40))
    case = next(one for one in cases if not one.truth["effects"][0]["at_its_largest"])
    told = case.truth["effects"][0]
    assert told["strength_reached"] == pytest.approx(1.0, rel=0.1)
    assert max(told["strength_by_channel"].values()) == told["strength_reached"]
    assert case.truth["verdict"] == ("missing" if name in MECHANISMS else "unknown")


@pytest.mark.parametrize("form", [*KNOWN, *OUTSIDE], ids=lambda form: f"{form.mechanism}:{form.name}")
def test_an_effect_of_no_size_is_hardly_any(form: Form) -> None:
    effect = choose_effect(f"{form.mechanism}:{form.name}", SPECIMEN).effect
    none, some = (
        max(strengths(SPECIMEN, RECORD, [(effect, share * effect.largest)], FLOORS).values()) for share in (1e-9, 0.5)
    )
    assert none < (2.0 if form.mechanism == FILTERS else 0.4)
    assert some > none + 0.3
    assert np.isfinite(some)


def test_a_reading_shows_an_effect_on_it_alone() -> None:
    plain = make_case("none", 5.0, 3, minutes=2.0)
    force = changes(make_case("load_cell_creep", 5.0, 3, minutes=2.0), plain)
    assert not np.any(force["conductance"])
    assert np.any(force["force"])
    wear = changes(make_case("coating_wear:archard", 5.0, 3, minutes=2.0), plain)
    assert not np.any(wear["force"])
    assert wear["conductance"].mean() < 0


def test_an_effect_of_15_floors_is_larger_than_one_of_5() -> None:
    plain = make_case("none", 5.0, 3, minutes=2.0)
    weak, strong = (make_case("rate_resistance:signed", k, 3, minutes=2.0) for k in (5.0, 15.0))
    ratio = changes(strong, plain)["conductance"].std() / changes(weak, plain)["conductance"].std()
    assert ratio == pytest.approx(3.0, rel=0.1)


def test_a_clipped_reading_is_flat() -> None:
    case = make_case("adc_saturation:force_top", 5.0, 2, minutes=2.0)
    force = case.calibration[FORCE]
    assert np.sum(force == force.max()) > 20


def test_two_effects_at_once_are_both_there() -> None:
    case = make_case("load_cell_creep,rate_resistance", 5.0, 4, minutes=2.0)
    done = changes(case, make_case("none", 5.0, 4, minutes=2.0))
    assert [one["effect"] for one in case.truth["effects"]] == ["load_cell_creep", "rate_resistance"]
    assert done["force"].std() > case.truth["noise_floor"]["force"]
    assert done["conductance"].std() > case.truth["noise_floor"]["conductance"]
