"""An effect that is asked for by name on a recording that cannot show it."""

from __future__ import annotations

import pytest

from gcode.support.errors import UserError
from testbench.comparing.ladder import as_a_step
from testbench.diagnosis.adding import add_effect, check_shows, most_likely_start
from testbench.knit.reach import reaching
from testbench.measurements.preparing import prepare
from testbench.results.model_file import ModelFile
from tests.testbench.builders import CATALOGUE, record, truth

FORCE_LAWS = [name for name in truth() if CATALOGUE[name].writes == ("force_N",)]


@pytest.mark.parametrize(
    ("effect", "channel", "missing"),
    [
        ("load_cell_creep", "resistance_ohm", "force_N"),
        ("adc_saturation_force", "resistance_ohm", "force_N"),
        ("adc_saturation", "force_N", "conductance_S"),
        ("contact_relaxation", "force_N", "contact_force_N"),
    ],
)
def test_an_effect_on_what_was_not_measured_is_refused_in_words(effect, channel, missing):
    measurement = prepare(record(truth(), 60.0, channels=(channel,)))
    model = truth()
    for name in [*model] if channel == "force_N" else []:
        model = model if name in FORCE_LAWS else model.without(name)
    with pytest.raises(UserError, match=f"add {effect}: it changes {missing}, and nothing that sample-0 has"):
        add_effect(ModelFile(model, 25.0), effect, measurement, measurement, CATALOGUE)


def test_an_effect_on_a_force_that_presses_the_contacts_shows_in_the_conductance():
    measurement = prepare(record(truth(), 60.0, channels=("resistance_ohm",)))
    for effect in ("stress_relaxation", "permanent_set", "contact_saturation", "adc_saturation"):
        check_shows(CATALOGUE[effect](), truth(), measurement)


def test_what_reaches_a_signal_is_what_changes_it():
    model = truth().plus(CATALOGUE["load_cell_creep"]()).plus(CATALOGUE["permanent_set"]())
    assert reaching(model, ["force_N"]) == {*FORCE_LAWS, "load_cell_creep", "permanent_set"}
    assert reaching(model, ["conductance_S"]) == {*truth(), "permanent_set"}


@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e3])
def test_a_rail_that_no_reading_comes_near_starts_from_nothing_whatever_the_size_of_the_resistance(unit):
    model = truth().with_parameters(
        {
            "contact.contact_resistance_ohm": 900.0 * unit,
            "contact.series_ohm": 1e4 * unit,
            "contact.parallel_S": 1e-7 / unit,
        }
    )
    start = most_likely_start(model, CATALOGUE["adc_saturation_high"](), prepare(record(model, 60.0, rate_hz=10.0)))
    assert start.floor_S == 0.0


def test_a_step_on_a_model_that_has_no_ladder_yet_is_its_first():
    """As where an effect is put into a preset."""
    measurement = prepare(record(truth(), 60.0))
    added = as_a_step(truth(), {}, ModelFile(truth(), 25.0), "+ drift", measurement, measurement)
    assert [one["step"] for one in added.history] == ["+ drift"]
