"""The laws hold for every registered effect; a new effect needs no new test."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from testbench.knit.catalogue import load_catalogue
from testbench.knit.effect import Effect, bounds_of
from testbench.knit.laws import LAWS, Law, check

EFFECTS = load_catalogue().effects


def within_bounds(extra: dict[str, Any]) -> st.SearchStrategy[float]:
    low, high = extra["low"], extra["high"]
    if extra["scale"] == "linear":
        return st.floats(low, high)
    return st.floats(0, 1).map(lambda share: min(max(low * (high / low) ** share, low), high))


@st.composite
def drawn(draw: st.DrawFn, cls: type[Effect]) -> Effect:
    values: dict[str, Any] = {}
    for key, field in cls.model_fields.items():
        one = within_bounds(bounds_of(field))
        size = len(field.default) if isinstance(field.default, tuple) else 0
        values[key] = draw(st.tuples(*[one] * size) if size else one)
    return cls.model_validate(values)


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.__name__)
@pytest.mark.parametrize("name", EFFECTS)
def test_law_holds_with_default_parameters(name: str, law: Law) -> None:
    assert law(EFFECTS[name]()) == ""


@pytest.mark.parametrize("name", EFFECTS)
def test_laws_hold_with_any_parameters_in_bounds(name: str) -> None:
    @settings(derandomize=True, max_examples=12, deadline=None, database=None)
    @given(effect=drawn(EFFECTS[name]))
    def all_laws(effect: Effect) -> None:
        assert check(effect) == []

    all_laws()


@pytest.mark.parametrize("name", EFFECTS)
def test_it_is_registered_under_its_own_name_and_an_existing_idea(name: str) -> None:
    effect = EFFECTS[name]
    assert effect.name == name
    assert effect.mechanism in EFFECTS
