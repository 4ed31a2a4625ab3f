"""The moves of one step: laws take each other's place, and stand beside the best base."""

from __future__ import annotations

from testbench.diagnosis.judging.entries import Entry
from testbench.diagnosis.searching.fits import Fits
from testbench.diagnosis.searching.refits import NullModel, Refits, acts_on_force
from testbench.knit.catalogue import load_catalogue
from testbench.knit.model import KnitModel
from testbench.measurements.preparing import prepare
from tests.testbench.builders import record, truth

CATALOGUE = load_catalogue()


def fits_of(sensor, channels):
    return Fits(prepare(record(sensor, 60, 10.0, 1, channels)), CATALOGUE, lambda _text: None)


def entry(fits, base, law):
    h = fits.compare(base.plus(law))
    return Entry(law.mechanism, law.name, law.name, h, h.log_z)


def swapped(law, sensor, channels):
    """The laws in the place of one that was put into the model of a short recording."""
    fits = fits_of(sensor, channels)
    return {e.law: e for e in Refits(fits).swapped(entry(fits, fits.start, law))}


def on_better_bases(better, worse):
    """One law beside the base as it is, another beside one with another elasticity, and what becomes of the two."""
    fits = fits_of(truth(), ("force_N", "resistance_ohm"))
    base = fits.start
    gent = fits.started_like(base["elasticity"], CATALOGUE["elasticity_gent"], base)
    entries = [entry(fits, base, better), entry(fits, base.replacing("elasticity", gent), worse)]
    return entries, Refits(fits).on_better_bases(entries)


def test_a_law_starts_as_strong_as_the_one_in_whose_place_it_stands():
    slack = CATALOGUE["slack"](slack=0.05)
    found = swapped(slack, truth(), ("force_N",))
    assert set(found) == {"slack_gradual"}
    model = found["slack_gradual"].hypothesis.model
    assert "slack" not in model
    assert "slack_gradual" in model


def test_a_law_of_a_signal_that_no_law_makes_takes_no_place():
    late, no_force = CATALOGUE["channel_lag"](tau_s=0.1), KnitModel.of(CATALOGUE["piezoresistance"]())
    found = swapped(late, no_force, ("resistance_ohm",))
    assert set(found) == {"channel_lag_resistance", "channel_lag_two_filters"}


def test_a_law_of_the_conductance_takes_the_laws_of_the_force_from_the_best_and_keeps_its_own():
    overshoot, heat = CATALOGUE["electrical_overshoot"](gain=0.1), CATALOGUE["self_heating"](coefficient=0.01)
    (first, second), found = on_better_bases(overshoot, heat)
    best, other = sorted((first, second), key=lambda e: -e.log_z)
    (moved,) = [e for e in found if e not in (first, second)]
    assert moved.law == other.law
    laws = {name: effect.name for name, effect in moved.hypothesis.model.effects.items()}
    assert laws == {name: effect.name for name, effect in best.base.effects.items()} | {other.name: other.law}
    assert moved.log_z > other.log_z


def test_laws_of_different_channels_do_not_take_each_others_base():
    relaxation, heat = CATALOGUE["stress_relaxation"](fraction=0.1), CATALOGUE["self_heating"](coefficient=0.01)
    assert acts_on_force(relaxation)
    assert not acts_on_force(heat)
    entries, found = on_better_bases(relaxation, heat)
    assert found == entries


def test_the_best_law_is_tried_on_each_stiff_base_of_other_laws():
    fits = fits_of(truth(), ("force_N", "resistance_ohm"))
    base = fits.start
    gent = fits.started_like(base["elasticity"], CATALOGUE["elasticity_gent"], base)
    stiff = [fits.compare(one) for one in (base, base.replacing("elasticity", gent))]
    nulls = [NullModel(h, fits.compare(fits.bent(h.model)), ()) for h in stiff]
    heat = CATALOGUE["self_heating"](coefficient=0.01)
    (moved,) = Refits(fits).on_other_bases(entry(fits, base, heat), nulls)
    model = moved.hypothesis.model
    assert model["elasticity"].name == "elasticity_gent"
    assert {"self_heating", "elasticity_shape"} <= set(model)


def test_a_rival_takes_the_place_of_a_law_whose_trace_it_leaves_and_not_of_what_else_is_missing():
    two_times = {"fraction": 0.2, "fast_s": 3.0, "slow_s": 30.0, "share": 0.6}
    heat = CATALOGUE["self_heating"](coefficient=0.2)
    sensor = truth().plus(CATALOGUE["stress_relaxation_two_times"](**two_times)).plus(heat)
    fits = fits_of(sensor, ("force_N", "resistance_ohm"))
    creep = CATALOGUE["load_cell_creep_two_times"](**two_times | {"fraction": -0.2})
    put_in = entry(fits, fits.start, creep)
    found = {e.law: e for e in Refits(fits).rivals(put_in)}
    assert "self_heating" not in {e.mechanism for e in found.values()}
    assert found["stress_relaxation_two_times"].log_z > put_in.log_z
