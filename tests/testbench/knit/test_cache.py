"""A cache may save work; it must never be seen in what a simulation gives."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
import pytest

from testbench.fitting.baseline import SHAPES
from testbench.knit.additive import ConductanceLaw
from testbench.knit.cache import SimulationCache
from testbench.knit.catalogue import BUILT_IN, load_catalogue
from testbench.knit.effect import Effect, bounds_of
from testbench.knit.model import KnitModel, inputs
from tests.testbench.knit.samples import UP_DOWN_UP

CATALOGUE = load_catalogue()
BASE = ("elasticity", "hysteresis", "contact_drive", "contact", "drift")
SIGNALS = inputs(np.arange(len(UP_DOWN_UP)) * 0.05, UP_DOWN_UP, 20 + 5 * UP_DOWN_UP)
DT_S = 0.05


def model_with(name: str) -> KnitModel:
    base = KnitModel.of(*(CATALOGUE[one]() for one in (*BASE, *SHAPES) if one != name))
    return base.plus(CATALOGUE[name]())


def neighbours(model: KnitModel) -> list[KnitModel]:
    """With one parameter moved at a time, from the end of the chain backwards, as a fit does."""
    found = []
    for name, effect in reversed(list(model.effects.items())):
        for key, field in type(effect).model_fields.items():
            extra, value = bounds_of(field), getattr(effect, key)
            first = value[0] if isinstance(value, tuple) else value
            moved = first + 0.01 * min(extra["high"] - first, 1.0)
            address = f"{name}.{key}[0]" if isinstance(value, tuple) else f"{name}.{key}"
            found.append(model.with_parameters({address: moved}))
    return found


@pytest.mark.parametrize("name", sorted(set(BUILT_IN) - set(BASE)))
def test_runs_with_a_cache_are_those_without(name: str) -> None:
    model, cache = model_with(name), SimulationCache()
    for one in (model, *neighbours(model), model, model_with("slack"), model):
        cached, plain = one.simulate(SIGNALS, DT_S, cache), one.simulate(SIGNALS, DT_S)
        assert list(cached) == list(plain)
        for signal, values in plain.items():
            np.testing.assert_array_equal(cached[signal], values)


class Counted(ConductanceLaw):
    """Counts how often it is asked."""

    asked: ClassVar[list[str]] = []
    on: ClassVar[str] = "strain"

    def log_change(self, signals, dt_s):
        self.asked.append(self.on)
        return 0.1 * signals[self.on]


@pytest.mark.parametrize(("on", "asked"), [("strain", 1), ("contact_force_N", 2), ("conductance_S", 3)])
def test_a_law_is_asked_again_only_when_what_it_looks_at_has_changed(on: str, asked: int, monkeypatch) -> None:
    for name, value in {"__module__": "testbench.knit.tried", "asked": [], "on": on}.items():
        monkeypatch.setattr(Counted, name, value)
    law, cache = Counted(), SimulationCache()
    effects: dict[str, Effect] = {one: CATALOGUE[one]() for one in ("elasticity", "contact")}
    model = KnitModel({**effects, "counted": law})
    for address, factor in (("contact.preload_N", 1.0), ("contact.preload_N", 1.1), ("elasticity.stiffness_N", 1.1)):
        name, key = address.split(".")
        model.with_parameters({address: factor * getattr(model[name], key)}).simulate(SIGNALS, DT_S, cache)
    assert Counted.asked == [on] * asked
