"""The rules hold for every registered effect; a new effect needs no new test."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from testbench.knit.catalogue import load_catalogue
from testbench.knit.effect import Effect, bounds_of
from testbench.knit.rules import RULES, Rule, check

EFFECTS = load_catalogue().effects


def within_bounds(extra: dict[str, Any], share: float) -> float:
    low, high = extra["low"], extra["high"]
    value = low + (high - low) * share if extra["scale"] == "linear" else low * (high / low) ** share
    return min(max(value, low), high)


def drawn(cls: type[Effect], rng: np.random.Generator) -> Effect:
    """Every parameter anywhere within its bounds."""
    values: dict[str, Any] = {}
    for key, field in cls.model_fields.items():
        size = len(field.default) if isinstance(field.default, tuple) else 1
        ones = tuple(within_bounds(bounds_of(field), share) for share in rng.uniform(size=size))
        values[key] = ones if isinstance(field.default, tuple) else ones[0]
    return cls.model_validate(values)


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule.__name__)
@pytest.mark.parametrize("name", EFFECTS)
def test_rule_holds_with_default_parameters(name: str, rule: Rule) -> None:
    assert rule(EFFECTS[name]()) == ""


@pytest.mark.parametrize("name", EFFECTS)
def test_rules_hold_with_any_parameters_in_bounds(name: str) -> None:
    # Not by Hypothesis: it draws numbers read in those of our modules that are loaded, so that no run is another.
    rng = np.random.default_rng(sum(name.encode()))
    for _ in range(12):
        effect = drawn(EFFECTS[name], rng)
        assert check(effect) == [], effect


@pytest.mark.parametrize("name", EFFECTS)
def test_it_is_registered_under_its_own_name_and_an_existing_idea(name: str) -> None:
    effect = EFFECTS[name]
    assert effect.name == name
    assert effect.mechanism in EFFECTS
