"""The rules hold for every registered effect; a new effect needs no new test."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from testbench.knit.catalogue import load_catalogue
from testbench.knit.effect import Effect, bounds_of
from testbench.knit.rules import RULES, Rule, absent, check, example_signals, has_vector_strength

EFFECTS = load_catalogue().effects
PLACES = np.linspace(1.00371, 1.30371, 7)  # over the default of a parameter


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


@pytest.mark.parametrize("name", [name for name, effect in EFFECTS.items() if effect.strength])
@pytest.mark.parametrize("dt_s", [0.001, 0.1, 1.0])
def test_without_its_strength_it_is_nothing_to_the_last_digit(name: str, dt_s: float) -> None:
    """In a recording that begins in motion, in a hold, and in one after the knit was clamped anew."""
    signals = example_signals(dt_s)
    signals["strain"] = np.where(signals["time_s"] % 20 < 15, signals["strain"], 0.2)
    signals["clamping"] = (signals["time_s"] > 30).astype(float)
    for signal, values in absent(EFFECTS[name]()).apply(signals, dt_s).items():
        np.testing.assert_array_equal(values, signals[signal])


@pytest.mark.parametrize("name", EFFECTS)
def test_it_says_at_which_parameters_it_jumps(name: str) -> None:
    """Of such a parameter tiny steps move no sample, wherever they are made, and a larger one moves some."""
    law, signals = EFFECTS[name], example_signals(0.05)
    effect = law()
    if has_vector_strength(effect):
        effect = effect.replaced(**{law.strength: (0.01,) * len(getattr(effect, law.strength))})

    def written(key: str, factor: float) -> np.ndarray:
        value = getattr(effect, key)
        to = tuple(v * factor for v in value) if isinstance(value, tuple) else value * factor
        (signal,) = law.writes
        return effect.near(**{key: to}).apply(signals, 0.05)[signal]

    def jumps_at(key: str) -> bool:
        still = (np.array_equal(written(key, at), written(key, at * (1 + 1e-7))) for at in PLACES)
        return not np.array_equal(written(key, PLACES[0]), written(key, PLACES[-1])) and all(still)

    assert {key for key in law.model_fields if jumps_at(key)} <= {*law.jumps}
