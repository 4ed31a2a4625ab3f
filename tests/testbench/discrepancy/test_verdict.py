"""What is said of a gain, of the error that is left, and of how far that is above the noise."""

from __future__ import annotations

from dataclasses import replace

import pytest

from testbench.discrepancy.evidence import Weighing
from testbench.discrepancy.remains import Remains
from testbench.discrepancy.verdict import among_neighbours, verdict_of
from tests.testbench.discrepancy.samples import weighing


@pytest.mark.parametrize(
    ("form", "gain", "left", "before", "after", "said"),
    [
        pytest.param("stress_relaxation", 2.0, 0.02, 6.0, 1.1, "missing", id="explains nearly all"),
        pytest.param("stress_relaxation", 0.01, 0.99, 1.1, 1.1, "nothing_missing", id="gains nothing, at the noise"),
        pytest.param("stress_relaxation", 0.01, 0.99, 5.0, 4.9, "unknown", id="gains nothing, far from the noise"),
        pytest.param("stress_relaxation", 0.12, 0.25, 1.4, 1.1, "nothing_missing", id="gains little"),
        pytest.param("stress_relaxation", 0.2, 0.25, 1.4, 1.1, "missing", id="gains enough"),
        pytest.param("stress_relaxation", 1.0, 0.4, 6.0, 3.9, "unknown", id="leaves 40 % and structure"),
        pytest.param("stress_relaxation", 0.6, 0.4, 2.5, 1.8, "missing", id="leaves 40 %, but no structure"),
        pytest.param("stress_relaxation", 0.6, 0.55, 19.0, 14.0, "missing", id="half of an error far over the noise"),
        pytest.param("stress_relaxation", 0.6, 0.7, 19.0, 16.0, "unknown", id="less than half of it"),
        pytest.param("stress_relaxation", 0.5, 1.0, 6.0, 6.0, "unknown", id="gains in calibration only"),
        pytest.param("stress_relaxation", 0.3, 0.1, 1.15, 1.0, "nothing_missing", id="the base is at the noise"),
        pytest.param("jamming_stiffening", 0.1, 1.3, 1.0, 1.02, "missing", id="stands in for a shape, as well as it"),
        pytest.param("jamming_stiffening", 0.1, 1.2, 1.0, 1.1, "nothing_missing", id="stands in for a shape, worse"),
        pytest.param(
            "periodic_interference", 0.2, 0.6, 6.0, 5.0, "missing", id="what the time grid thins may leave much"
        ),
    ],
)
def test_a_verdict(form, gain, left, before, after, said):
    assert verdict_of(weighing(**{form: gain}), *2 * [Remains(before, after, left)]) == said


@pytest.mark.parametrize(
    ("typical", "said"),
    [
        pytest.param(Remains(6.0, 1.3, 0.05), "missing", id="but for a few samples it explains nearly all"),
        pytest.param(Remains(6.0, 1.8, 0.2), "missing", id="but for a few samples there is no structure"),
        pytest.param(Remains(6.0, 3.5, 0.35), "unknown", id="it is not a few samples"),
    ],
)
def test_what_a_few_samples_say_is_not_held_against_an_idea(typical, said):
    assert verdict_of(weighing(electrical_overshoot=0.6), Remains(6.5, 2.6, 0.4), typical) == said


@pytest.mark.parametrize(
    ("second", "after", "share", "doubtful"),
    [
        pytest.param(0.7, 1.6, 0.08, True, id="a neighbour comes near, and the noise is not reached"),
        pytest.param(0.3, 1.6, 0.08, False, id="the first stands out"),
        pytest.param(0.95, 1.1, 0.08, False, id="a tie at the noise"),
        pytest.param(0.7, 1.6, 0.02, False, id="a large effect in another form"),
    ],
)
def test_between_neighbours_that_do_not_reach_the_noise_it_may_be_neither(second, after, share, doubtful):
    neighbours = weighing(contact_relaxation=1.0, shoulder_peak=second)
    left = Remains(6.0, after, share)
    assert among_neighbours(neighbours, left, left) is doubtful


def test_what_stands_in_for_a_shape_is_not_doubted_for_its_neighbours():
    left = Remains(6.0, 1.6, 0.08)
    assert not among_neighbours(weighing(adc_saturation=1.0, contact_saturation=0.9), left, left)


def test_an_empty_catalogue_names_nothing():
    nothing = Weighing((), "", 0.0, 0.0, ())
    assert verdict_of(nothing, *2 * [Remains(1.1, 1.1, 1.0)]) == "nothing_missing"
    assert verdict_of(nothing, *2 * [Remains(5.0, 5.0, 1.0)]) == "unknown"


def test_a_small_gain_that_many_share_belongs_to_none():
    left = Remains(1.6, 1.2, 0.3)
    assert verdict_of(weighing(stress_relaxation=0.2, clamp_slip=0.15), left, left) == "missing"
    crowd = weighing(stress_relaxation=0.2, clamp_slip=0.15, permanent_set=0.12)
    assert verdict_of(crowd, left, left) == "nothing_missing"


def test_what_is_seen_is_missing_however_little_it_gains():
    ranked, left = weighing(adc_saturation=0.01), Remains(1.1, 1.2, 1.1)
    assert verdict_of(ranked, left, left) == "nothing_missing"
    shown = replace(ranked, ranking=(replace(ranked.ranking[0], seen=True),))
    assert verdict_of(shown, left, left) == "missing"
