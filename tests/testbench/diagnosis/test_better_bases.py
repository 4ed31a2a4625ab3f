"""A law is not judged by a base that is worse than another's."""

from __future__ import annotations

from testbench.diagnosis.fits import Fits
from testbench.diagnosis.refits import Refits, acts_on_force
from testbench.diagnosis.rounds import Entry
from testbench.knit.catalogue import load_catalogue
from testbench.measurements.measurement import prepare
from tests.testbench.builders import record, truth

CATALOGUE = load_catalogue()
GENT = CATALOGUE["elasticity_gent"]


def entry(fits, model, law):
    h = fits.compare(model.plus(law))
    return Entry(law.mechanism, law.name, law.name, h, h.log_z)


def on_better_bases(better, worse):
    """One law beside the base as it is, another beside one with another elasticity, and what becomes of the two."""
    measurement = prepare(record(truth(), 60, 10.0, 1, ("force_N", "resistance_ohm")))
    fits = Fits(measurement, CATALOGUE, lambda _text: None)
    base = fits.reference
    other = base.replacing("elasticity", fits.started_like(base["elasticity"], GENT, base))
    entries = [entry(fits, base, better), entry(fits, other, worse)]
    return fits, entries, Refits(fits).on_better_bases(entries)


def test_a_law_of_the_conductance_takes_the_laws_of_the_force_from_the_best_and_keeps_its_own():
    overshoot, heat = CATALOGUE["electrical_overshoot"](gain=0.1), CATALOGUE["self_heating"](coefficient=0.01)
    _, (first, second), found = on_better_bases(overshoot, heat)
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
    _, entries, found = on_better_bases(relaxation, heat)
    assert found == entries
