"""Which kind of conduction the base has: both are tried where the look of a recording does not tell."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from testbench.diagnosis.searching.search import Search
from testbench.fitting.baseline import kinds_of_conduction, starting_baseline
from testbench.fitting.evidence.sample_noise import FINEST
from testbench.knit.catalogue import load_catalogue
from testbench.measurements.measurement import Measurement
from testbench.measurements.noise_level import spread
from testbench.measurements.preparing import prepare
from tests.testbench.builders import NOISE_LN, record, truth

CATALOGUE = load_catalogue()
BOTH = ("force_N", "resistance_ohm")


def rising() -> Measurement:
    return prepare(record(truth(), 60, 10.0, 1))


def falling(channels=BOTH) -> Measurement:
    made = record(truth(), 60, 10.0, 1, channels)
    strain, noise = made.channels["displacement_mm"] / made.gauge_length_mm, np.random.default_rng(1)
    resistance = 1000 * np.exp(4 * strain + NOISE_LN * noise.standard_normal(len(strain)))
    return prepare(replace(made, channels={**made.channels, "resistance_ohm": resistance}))


def kinds(measurement):
    return kinds_of_conduction(starting_baseline(measurement, CATALOGUE), measurement, CATALOGUE)


def test_conductance_that_rises_with_stretch_is_that_of_contacts():
    (only,) = kinds(rising())
    assert "contact" in only


def test_conductance_that_falls_may_be_that_of_the_strain_or_of_contacts():
    of_strain, of_contacts = kinds(falling())
    assert "piezoresistance" in of_strain
    assert "piezoresistance" not in of_contacts
    assert [name for name in of_contacts if name.startswith("contact")] == ["contact_drive", "contact"]
    assert of_contacts["elasticity"] == of_strain["elasticity"]


def test_without_a_force_there_are_no_contacts_under_it():
    (only,) = kinds(falling(("resistance_ohm",)))
    assert "piezoresistance" in only


def without_noise() -> Search:
    return Search(prepare(record(truth(), 60, 10.0, 1, BOTH, noise=0.0)), CATALOGUE, lambda _text: None)


def test_a_simulation_without_noise_is_no_more_exact_than_a_converter():
    search = without_noise()
    for channel, noise in search.noise.items():
        assert noise >= 0.9 * FINEST * spread(search.measurement.measured[channel])
    bent, _ = search.bases()
    assert np.isfinite(bent[0].log_z)


@pytest.mark.slow
def test_in_a_simulation_without_noise_nothing_is_missing():
    assert without_noise().run()[1] == []


def test_a_base_of_either_kind_is_completed_and_the_better_comes_first():
    search = Search(falling(), CATALOGUE, lambda _text: None)
    bent, _ = search.bases()
    best = {name: max(h.log_z for h in bent if name in h.model) for name in ("piezoresistance", "contact")}
    assert best["piezoresistance"] == bent[0].log_z > best["contact"]
    (other,) = [h.model for h in bent if "contact" in h.model]
    assert search.other_laws(bent[0].model, other) == {"contact_drive": "contact_drive", "contact": "contact"}
