"""The search: grids as fine as what they look for, what the base may give way to, and gains on resampled blocks."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field, replace
from types import SimpleNamespace

import numpy as np
import pytest

from testbench.proposing.beam import TOGETHER, Beam, Found, _condensed, changing, diverse
from testbench.proposing.grids import DAMPINGS
from testbench.proposing.hunt import FINALISTS, OF_ONE_FAMILY, OF_ONE_PLACE, _best_of_each
from testbench.proposing.laws.grammar import coordinates_at, fits
from testbench.proposing.laws.law import MOST_PARAMETERS, Term, namespace
from testbench.proposing.laws.law_coordinates import KINETICS
from testbench.proposing.laws.operators import OPERATORS
from testbench.proposing.laws.places import PLACES
from testbench.proposing.proposal import holds
from testbench.proposing.screening import Part, at_bounds
from testbench.proposing.stability import SURE, stability
from testbench.proposing.trial import Trial
from tests.testbench.proposing.test_library import DT_S, GRID, SIGNALS, law_of

SAMPLES, NOISE = 1200, 0.01


def test_a_resonance_is_not_missed_between_two_frequencies():
    points = list(GRID.points(OPERATORS["ring"].slots, None, "ring"))
    for damping in DAMPINGS:
        hz = [point["ring_hz"] for point in points if point["damping"] == damping]
        assert max(b / a for a, b in itertools.pairwise(hz)) <= 1 + damping + 1e-9


@pytest.mark.parametrize(("name", "key"), [("stick", "grip"), ("dead band", "band")])
def test_teeth_are_not_missed_between_two_counts(name: str, key: str):
    x = SIGNALS["strain"]
    counts = [np.ptp(x) / point[key] for point in GRID.points(OPERATORS[name].slots, x, name)]
    assert np.diff(counts) == pytest.approx(np.full(len(counts) - 1, counts[1] - counts[0]))
    assert counts[1] - counts[0] < 1  # at the far end of the range the teeth are off by less than one


def test_a_state_may_form_in_less_than_a_sample():
    (slot,) = [one for one in KINETICS["state that forms ever quicker beyond a strain and goes with time"].slots
               if one.key == "form_s"]  # fmt: skip
    low, high, log = GRID.bounds(slot, 1.0)
    assert log
    assert low < 0.05 * DT_S  # the time holds a whole span beyond the edge, where no recording goes
    assert high > GRID.duration_s


def test_a_switch_is_tried_at_every_pair_of_levels():
    x = SIGNALS["strain"]
    points = list(GRID.points(OPERATORS["switch"].slots, x, "switch"))
    for on, off in [(0.9, 0.85), (0.8, 0.2), (0.3, 0.1)]:
        aimed = np.quantile(x, [on, off])
        apart = [max(np.abs(aimed - (point["on"], point["on"] - point["gap"]))) for point in points]
        assert min(apart) < 0.04 * np.ptp(x)


def test_a_cap_is_tried_where_it_cuts_off_few_large_values():
    x = np.square(SIGNALS["strain"] - SIGNALS["strain"].mean())
    x[::40] *= 4.0  # every fortieth stands out
    levels = [point["edge_x"] for point in GRID.points(OPERATORS["below"].slots, x, "below")]
    assert 0 < np.mean(x > max(levels)) < 0.025


def test_between_the_peaks_and_the_rest_there_is_a_level_however_few_the_peaks_are():
    x = np.linspace(0, 1, 4000) ** 60  # a square of a rate: nearly all of it near zero
    levels = [point["edge_x"] for point in GRID.points(OPERATORS["below"].slots, x, "below")]
    assert np.max(np.diff([*levels, np.max(x)])) < 0.51 * np.ptp(x)


def test_a_needle_is_found_that_a_simplex_does_not_feel():
    needle = np.array([0.31, -0.17])

    def costs(points: np.ndarray) -> np.ndarray:
        return -1.0 / (0.05 + np.max(np.abs(points - needle), axis=-1)) // 1

    found = _condensed(costs, np.zeros(2), np.array([0.3, 0.3]))
    assert np.max(np.abs(found - needle)) < 0.02


def test_what_the_base_can_bend_to_is_tried_as_it_changes_with_time():
    slip = Term(law_of("force", "strain").term.coordinate, (OPERATORS["slip"],), 0.3, (1.0,))
    assert changing(slip).name == "strain, slip, growing"


def beam_of_the_force() -> Beam:
    """A search for laws of the force alone."""
    beam = Beam.__new__(Beam)
    beam.grid, beam.chain = GRID, SimpleNamespace(places=(PLACES["force"],))
    signals = {name: SIGNALS[name] for name in ("strain", "force_N", "time_s")}
    beam.readable, beam.names = {"force": set(signals)}, {"force": namespace(signals, DT_S)}
    beam.known = ()
    return beam


def test_a_state_is_tried_times_what_it_may_act_on():
    law = law_of("force", "state that forms with time and is wiped out by motion")
    grown = beam_of_the_force().grown(law.place, law.term, law.values, ("factor",))
    names = [term.name.split(", ")[1:] for _, term, _ in grown]
    assert ["times force"] in names
    assert ["times conductance"] not in names  # which does not lie before the force
    assert ["times friction"] in names  # a friction that comes and goes, however quickly it turns over


def test_a_memory_is_tried_times_what_it_may_act_on_and_nothing_with_more_than_four_numbers():
    terms = {term.name: term for _, term, _ in beam_of_the_force().seeds()}
    assert "power, lag, times force" in terms  # a knit that its own work warms and softens
    assert "strain, lag, times strain" in terms
    assert max(1 + len(term.slots) for term in terms.values()) == MOST_PARAMETERS


def test_what_flows_beyond_a_threshold_alone_is_tried_also_where_it_never_comes_back():
    points = [
        values for _, term, values in beam_of_the_force().seeds() if term.name == "strain, threshold, two-way lag"
    ]
    assert max(values["back_s"] for values in points) > 5 * GRID.duration_s > max(v["tau_s"] for v in points)
    assert len({values["edge_x"] for values in points}) > 5


def test_a_state_may_change_the_strain_that_the_knit_sees_and_no_reading():
    readable = {"strain", "force_N"}
    known = {place: {c.name for c in coordinates_at(PLACES[place], readable)} for place in PLACES}
    assert set(KINETICS) <= known["strain"] & known["force"] & known["conductance"]  # clamps and glue creep
    assert not set(KINETICS) & (known["force reading"] | known["conductance reading"] | known["contact force"])


def test_what_one_channel_follows_is_tried_in_another_with_its_numbers():
    beam, law = beam_of_the_force(), law_of("conductance", "what gathers beyond a strain and goes near rest")
    beam.known = [replace(law, values={"edge": 0.123, "rest": 0.045, "end_s": 6.7})]
    assert (PLACES["force"], law.term, beam.known[0].values) in list(beam.seeds())


def test_a_factor_may_come_twice_and_nothing_else():
    law = law_of("force", "strain", "lag", "square", "times strain")
    grown = {term.name for _, term, _ in beam_of_the_force().children(law)}
    assert "strain, lag, square, times strain, times strain" in grown
    assert not any(name.count("square") > 1 or name.count("lag") > 1 for name in grown)


def test_a_law_loses_one_piece_and_its_numbers():
    law = law_of("conductance", "force", "lag", "threshold")
    less = law.without(1)
    assert less.key == "conductance: force, lag"
    assert set(less.values) == {"tau_s"}
    assert less.term.evaluated(SIGNALS, less.values, DT_S) == pytest.approx(
        law_of("conductance", "force", "lag").term.evaluated(SIGNALS, law.values, DT_S)
    )


def test_bends_of_one_law_do_not_crowd_out_another_memory():
    bends = [law_of("force", "force", name) for name in ("square", "saturation", "bell", "threshold")]
    ringing = law_of("force", "force", "ring")
    found = [Found(law, 9.0 - k) for k, law in enumerate([*bends, ringing])]
    kept = diverse(found, FINALISTS, OF_ONE_FAMILY, OF_ONE_PLACE)
    assert ringing.key in [one.law.key for one in kept]
    assert len([one for one in kept if not one.law.term.memory]) == 2


def test_a_piece_that_does_harm_and_has_no_number_takes_no_place():
    better, idle = (law_of("force", "strain", "lag", "times strain", *more) for more in ((), ("size",)))
    bent, other = law_of("force", "strain", "lag", "threshold", "times strain"), law_of("force", "strain", "slip")
    found = [Found(law, 9.0 - k) for k, law in enumerate([better, idle, bent, other])]
    assert [one.law for one in diverse(found, 14, 2)] == [better, bent, other]  # what has a number may yet be better


def test_a_channel_at_its_noise_does_not_hide_what_a_law_does_to_the_other():
    rng = np.random.default_rng(0)
    count, misfit, noise = 400, rng.standard_normal(400), rng.standard_normal(400)
    residual = np.concatenate([misfit, noise])
    part = Part(np.zeros((1, 800)), residual, np.array([misfit @ misfit, noise @ noise]), np.array([0.01, 100.0]))
    for share in (0.9, 0.99):  # of the misfit, which is all that is left of its channel
        change = np.concatenate([share * misfit, np.zeros(400)])
        explained = (1 - (1 - share) ** 2) * misfit @ misfit
        assert part.gains(change[None], np.array([explained]), count) == pytest.approx([-count * np.log(1 - share)])


def test_of_one_structure_the_numbers_that_fit_best_are_kept():
    lag, bell = law_of("force", "strain", "lag"), law_of("force", "strain", "bell")
    trials = [Trial(lag, "my", None, 3.0), Trial(bell, "my", None, 4.0), Trial(lag, "my", None, 5.0)]
    assert [(one.law.key, one.log_z) for one in _best_of_each(trials)] == [(lag.key, 5.0), (bell.key, 4.0)]


def test_what_lies_at_a_bound_cannot_give_way():
    parameters = SimpleNamespace(low=np.array([-1.0, 0.0, 0.0]), high=np.array([1.0, 2.0, 0.015]))
    h = SimpleNamespace(vector=np.array([0.3, 0.0, 0.015]), priors=SimpleNamespace(parameters=parameters))
    assert at_bounds(h).tolist() == [False, True, True]


@dataclass
class Fitted:
    """As much of a hypothesis as its gain needs."""

    left: np.ndarray
    log_z: float
    columns: dict = field(init=False)
    robust: dict = field(init=False)

    def __post_init__(self):
        self.columns = {"force": self.left[None]}
        self.robust = {"force": np.ones_like(self.left)}


def test_a_law_of_one_minute_is_none_of_the_recording():
    rng = np.random.default_rng(0)
    noise = NOISE * rng.standard_normal(SAMPLES)
    misfit = 0.03 * np.sin(np.arange(SAMPLES))
    burst = np.where(np.arange(SAMPLES) < 100, 10 * misfit, 0.0)
    measurement = SimpleNamespace(dt_s=0.2)
    likelihood = SimpleNamespace(
        rows=np.arange(SAMPLES), share=0.05, least={"force": 0.5 * NOISE}, measurement=measurement
    )

    def of(left: np.ndarray, price: float = 3.0) -> Fitted:
        return Fitted(left, -0.5 * 0.05 * SAMPLES * np.log(np.mean(left**2)) - price)

    current = of(noise + misfit + burst, 0.0)
    everywhere, once = of(noise + burst), of(noise + misfit)
    gains, wins = stability(current, [everywhere, once], likelihood)
    assert once.log_z > everywhere.log_z  # though the one minute makes more of the evidence
    assert gains[0] >= SURE > gains[1]
    assert wins.sum() == pytest.approx(1.0)


def test_a_law_has_one_family_whatever_its_bends():
    assert law_of("force", "strain", "lag", "square").family == ("force", "strain", "lag")


def test_what_is_remembered_makes_another_family_of_a_law():
    whole, beyond = (law_of("force", "strain", *before, "lag") for before in ((), ("threshold",)))
    bends = [law_of("force", "strain", "lag", name) for name in ("square", "saturation")]
    found = [Found(law, 9.0 - k) for k, law in enumerate([*bends, whole, beyond])]
    assert [one.law for one in diverse(found, 14, OF_ONE_FAMILY)] == [*bends, beyond]


@pytest.mark.parametrize("name", ["bell at", "switch", "wave"])
def test_an_event_of_this_recording_is_no_law(name: str):
    path, strain = (law_of("force", coordinate).term for coordinate in ("path", "strain"))
    x = np.linspace(0, 1, 50)
    assert not fits(path, OPERATORS[name], 0, x)
    assert fits(strain, OPERATORS[name], 0, x)
    assert fits(law_of("force", "time").term, OPERATORS["wave"], 0, x)


@pytest.mark.parametrize(
    ("force", "conductance", "held"),
    [
        (1.004, 0.75, True),
        (1.2, 0.75, True),  # what it gains in one channel is more than the refit loses in the other
        (1.5, 0.75, False),
        (1.02, 1.0, False),
        (0.99, 1.0, True),
        (0.9, 1.1, False),
    ],
)
def test_a_law_is_taken_back_where_the_mean_rises_or_one_channel_loses_more_than_the_other_gains(
    force: float, conductance: float, held: bool
):
    before, floors = {"force": 0.1, "conductance": 0.05}, {"force": 0.01, "conductance": 0.001}
    after = {"force": force * before["force"], "conductance": conductance * before["conductance"]}
    assert holds(before, after, floors) is held


@pytest.mark.parametrize("cores", [1, 2, 3])
def test_laws_are_scored_in_one_order_on_any_number_of_cores(cores):
    points = [(SimpleNamespace(name=f"place {k % 3}"), k, {}) for k in range(20 * TOGETHER)]
    pool = SimpleNamespace(count=cores, map=lambda work, shares: [work(share) for share in shares])
    beam = SimpleNamespace(pool=pool, of_one_place=lambda part: [number for _, number, _ in part])
    found = Beam.scored(beam, points)
    assert found == [k for place in range(3) for k in range(len(points)) if k % 3 == place]
