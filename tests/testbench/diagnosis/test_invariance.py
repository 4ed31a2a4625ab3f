"""What must not matter to a diagnosis does not matter."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from testbench.diagnosis import diagnose
from testbench.diagnosis.result import Diagnosis
from testbench.knit.catalogue import Catalogue
from testbench.knit.effect import Effect, Stage, parameter
from testbench.recordings.recording import Recording
from tests.testbench.builders import CATALOGUE, record, truth


class Bystander(Effect):
    """A user's own that needs a signal which nobody recorded."""

    name = "bystander"
    stage = Stage.READOUT
    reads, writes = ("conductance_S", "temperature_C"), ("conductance_S",)
    strength = "gain"
    look = "nothing, here"

    gain: float = parameter(0.1, unit="1", low=-5, high=5, doc="how much")

    def apply(self, signals, dt_s):
        return {"conductance_S": signals["conductance_S"] * np.exp(self.gain * signals["temperature_C"])}


def recordings() -> tuple[Recording, Recording]:
    model = truth().plus(CATALOGUE["stress_relaxation"]().replaced(fraction=0.1, tau_s=10.0))
    first, second = (record(model, 120, 10.0, seed, channels=("force_N",)) for seed in (1, 2))
    return first, second


@cache
def plain() -> Diagnosis:
    """A relaxing knit of which only the force was recorded."""
    return diagnose(*recordings(), catalogue=CATALOGUE, most=1)


def same(one: Diagnosis, other: Diagnosis) -> None:
    """The same said with the same certainty, to what rounding and the order of sums allow."""
    assert one.verdict == other.verdict
    assert [found.effect for found in one.found] == [found.effect for found in other.found]
    assert set(one.probabilities) == set(other.probabilities)
    for name, chance in one.probabilities.items():
        assert other.probabilities[name] == pytest.approx(chance, abs=0.01), name
    assert other.error_after == pytest.approx(one.error_after, rel=0.01)


def test_the_sample_says_something():
    assert plain().found[0].effect == "stress_relaxation"


def backwards(catalogue: Catalogue) -> Catalogue:
    return Catalogue(dict(reversed(catalogue.effects.items())))


def with_bystander(catalogue: Catalogue) -> Catalogue:
    return Catalogue({**catalogue.effects, "bystander": Bystander})


def later(parts: tuple[Recording, Recording]) -> list[Recording]:
    return [replace(part, time_s=part.time_s + 4000.0) for part in parts]


def test_neither_order_nor_an_idle_effect_nor_the_origin_of_time_matters():
    """All three at once, for a diagnosis takes long; each by itself is among the slow tests."""
    catalogue = backwards(with_bystander(CATALOGUE))
    same(plain(), diagnose(*later(recordings()), catalogue=catalogue, most=1))


@pytest.mark.slow
def test_the_order_of_the_catalogue_does_not_matter():
    same(plain(), diagnose(*recordings(), catalogue=backwards(CATALOGUE), most=1))


@pytest.mark.slow
def test_an_effect_that_cannot_act_on_what_was_recorded_does_not_matter():
    same(plain(), diagnose(*recordings(), catalogue=with_bystander(CATALOGUE), most=1))


@pytest.mark.slow
def test_the_origin_of_time_does_not_matter():
    same(plain(), diagnose(*later(recordings()), catalogue=CATALOGUE, most=1))
