"""Where a law stands in a model does not depend on when it was put in."""

from __future__ import annotations

import pytest

from testbench.fitting.baseline import SHAPES
from testbench.knit.catalogue import load_catalogue, model_from_dict
from testbench.knit.model import KnitModel

EFFECTS = load_catalogue().effects
BASE = KnitModel.of(*(EFFECTS[name]() for name in ("elasticity", "hysteresis", "contact", "drift", "force_age")))


@pytest.mark.parametrize("name", [name for name, law in EFFECTS.items() if not law.in_base])
def test_an_effect_acts_on_all_that_the_base_does(name: str) -> None:
    effect, shapes = EFFECTS[name](), [EFFECTS[shape]() for shape in SHAPES]
    first, last = BASE.plus(effect), BASE
    for shape in shapes:
        first, last = first.plus(shape), last.plus(shape)
    last = last.plus(effect)
    assert list(first) == list(last)
    behind = list(last)[list(last).index(name) + 1 :]
    assert not any(last[other].in_base and last[other].stage == effect.stage for other in behind)


def test_a_saved_model_acts_in_the_order_in_which_it_was_saved() -> None:
    relaxing = EFFECTS["stress_relaxation"]()
    model = KnitModel({"elasticity": BASE["elasticity"], "relaxes": relaxing, "hysteresis": BASE["hysteresis"]})
    again = model_from_dict(model.to_dict(), load_catalogue())
    assert list(again) == ["elasticity", "relaxes", "hysteresis"]
    assert again == model


def test_a_saved_effect_without_a_name_has_its_own() -> None:
    data = BASE.to_dict()
    data["effects"][1]["name"] = ""
    assert model_from_dict(data, load_catalogue()) == BASE


def test_a_whole_vector_and_one_of_its_numbers_may_be_changed_at_once() -> None:
    law = EFFECTS["stress_relaxation_prony"]
    whole = {"stress_relaxation_prony.fractions": (0.1,) * 7, "stress_relaxation_prony.fractions[2]": 0.3}
    changed = KnitModel.of(law()).with_parameters(whole)["stress_relaxation_prony"]
    assert changed == law(fractions=(0.1, 0.1, 0.3, 0.1, 0.1, 0.1, 0.1))
