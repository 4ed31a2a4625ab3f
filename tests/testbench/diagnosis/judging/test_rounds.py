"""What is said of one round: a law that explains all is named, one that explains a part speaks for *unknown*."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.special import logsumexp

from testbench.diagnosis.judging.entries import Entry
from testbench.diagnosis.judging.probabilities import NOTHING, UNKNOWN, Evidences, mixed_with_prior
from testbench.diagnosis.judging.put_in import best_set, leading, whole_of
from testbench.diagnosis.judging.rounds import Round
from testbench.diagnosis.searching.search import Search
from testbench.fitting import constants
from testbench.fitting.evidence.likelihood import Likelihood
from testbench.knit.model import KnitModel

FLOOR = {"force": 0.005, "conductance": 8e-4}
BARE = 8.0  # noise floors that the base leaves in the force
LAWS = {"stress_relaxation": 2, "clamp_slip": 1, "self_heating": 3}


def entry(mechanism: str, floors: float, log_z: float) -> Entry:
    """A law put in: what it leaves in the force, in noise floors; in the conductance nothing is missing."""
    sigma = {"force": floors * FLOOR["force"], "conductance": 1.25 * FLOOR["conductance"]}
    hypothesis = SimpleNamespace(evidence=SimpleNamespace(sigma=sigma), log_z=log_z)
    return Entry(mechanism, mechanism, mechanism, hypothesis, log_z)  # type: ignore[arg-type]


def a_round(before: Entry, *entries: Entry, so_far: Mapping[str, float] | None = None) -> Round:
    likelihood = Likelihood(SimpleNamespace(), np.arange(10), {}, FLOOR, 1.0)  # type: ignore[arg-type]
    return Round(before, likelihood, entries, (), LAWS, so_far or {})


def if_exact(evidences: Evidences) -> dict[str, float]:
    """Probabilities if evidences had no errors."""
    logs = {name: logsumexp(list(parts.values())) for name, parts in evidences.items()}
    return {name: float(np.exp(log - logsumexp(list(logs.values())))) for name, log in logs.items()}


def test_a_law_that_leaves_noise_is_named():
    found = a_round(entry("", BARE, 50.0), entry("stress_relaxation", 1.3, 100.0))
    assert found.verdict() == "missing"
    assert found.probabilities()["stress_relaxation"] > 0.98


def test_a_law_of_the_same_evidence_that_leaves_much_speaks_for_an_unknown_effect():
    found = a_round(entry("", BARE, 50.0), entry("stress_relaxation", 0.7 * BARE, 100.0))
    assert found.verdict() == "unknown"
    assert found.probabilities()[UNKNOWN] > 0.9


def test_where_the_base_leaves_much_and_no_law_helps_it_is_unknown():
    found = a_round(entry("", 5.0, 0.0), entry("self_heating", 5.0, 0.5))
    assert found.verdict() == "unknown"


def test_nothing_is_not_said_where_one_channel_is_left_at_twice_the_noise():
    found = a_round(entry("", 2.7, 0.0), entry("self_heating", 2.7, 0.5))
    assert found.verdict() == "unknown"


def test_of_nothing_and_unknown_the_verdict_is_what_is_told_as_more_probable():
    for floors in np.linspace(1.9, 2.2, 61):  # in the middle of which the two are tied
        found = a_round(entry("", floors, 0.0), entry("self_heating", floors, 0.5))
        told = found.doubted()
        assert (found.verdict() == "nothing_missing") == (told[NOTHING] >= told[UNKNOWN])


def test_a_law_that_is_probable_and_leaves_most_is_no_name_and_something_is_missing():
    changes_N = {"force": 0.6}  # by 5 % of which it may err
    much = replace(entry("stress_relaxation", 0.6 * BARE, 100.0), whole_part=changes_N)
    found = a_round(entry("", BARE, 50.0), much)
    told = found.doubted()
    assert told["stress_relaxation"] > 0.8
    assert told[NOTHING] > told[UNKNOWN]  # both have what all evidence is doubted by
    assert found.verdict() == "unknown"


def test_where_the_base_leaves_noise_nothing_is_missing():
    found = a_round(entry("", 1.25, 0.0), entry("self_heating", 1.25, 2.0))
    assert found.verdict() == "nothing_missing"
    assert found.probabilities()[NOTHING] > 0.5


@pytest.mark.parametrize(
    ("log_prior_bend", "verdict"), [(-np.inf, "missing"), (-12.0, "missing"), (0.0, "nothing_missing")]
)
def test_a_bend_as_small_as_laws_of_the_base_are_off_is_nothing_missing(log_prior_bend, verdict):
    jam = replace(entry("clamp_slip", 1.25, 30.0), log_prior_bend=log_prior_bend)
    assert a_round(entry("", 1.25, 0.0), jam).verdict() == verdict


@pytest.mark.parametrize(("changes", "verdict"), [(0.0, "unknown"), (4.0, "missing")])
def test_a_name_leaves_at_most_half_of_what_it_should_explain(changes, verdict):
    """That is what the base leaves, or what the law changes itself where the base has bent to do the same."""
    own = {"force": changes * BARE * FLOOR["force"], "conductance": 0.0}
    found = a_round(entry("", BARE, 0.0), replace(entry("clamp_slip", 0.6 * BARE, 200.0), own_part=own))
    assert found.verdict() == verdict


def test_two_effects_that_leave_each_others_part_are_named_together():
    first = entry("stress_relaxation", 0.7 * BARE, 70.0)
    second = entry("clamp_slip", 1.3, 160.0)
    rounds = [
        a_round(entry("", BARE, 50.0), first),
        a_round(first, second),
    ]
    assert rounds[0].verdict() == "unknown"
    assert rounds[0].verdict(whole_of(rounds, [first, second])) == "missing"
    assert rounds[0].verdict(whole_of(rounds[:1], [first])) == "unknown"


def test_what_adds_most_goes_in_where_nothing_explains_enough():
    """The creep explains the force to its end; the knit that relaxes explains more, but not all."""
    floor = {"force": 1.25 * FLOOR["force"], "conductance": BARE * FLOOR["conductance"]}
    creeps, relaxes = entry("clamp_slip", 1.25, 80.0), entry("stress_relaxation", 1.25, 100.0)
    for one, changed in ((creeps, 0.0), (relaxes, 5.0)):
        one.hypothesis.evidence.sigma = floor
        one.own_part.update(force=BARE * FLOOR["force"], conductance=changed * FLOOR["conductance"])
    bare = entry("", BARE, 0.0)
    bare.hypothesis.evidence.sigma = {**floor, "force": BARE * FLOOR["force"]}
    found = a_round(bare, relaxes, creeps)
    assert found.candidate is creeps
    assert found.goes_in is relaxes


def test_what_explains_enough_goes_in_though_another_adds_more():
    good, more = entry("stress_relaxation", 1.3, 100.0), entry("clamp_slip", 0.7 * BARE, 101.0)
    assert a_round(entry("", BARE, 50.0), more, good).goes_in is good


def test_what_went_in_and_got_no_company_gives_way_to_the_candidate():
    candidate, more = entry("stress_relaxation", 0.5 * BARE, 100.0), entry("clamp_slip", 0.7 * BARE, 103.0)
    first = a_round(entry("", BARE, 50.0), more, candidate)
    assert (first.candidate, first.goes_in) == (candidate, more)
    assert best_set([first], [more]) == [candidate]
    worse, better = entry("self_heating", 0.7 * BARE, 103.0), entry("self_heating", 1.25, 160.0)
    assert best_set([first, a_round(more, worse)], [more, worse]) == [candidate]
    assert best_set([first, a_round(more, better)], [more, better]) == [more, better]


def test_in_company_the_first_is_as_likely_as_what_it_adds():
    """Alone it left more than another; with company that is no reason against it."""
    first, other = entry("stress_relaxation", 0.7 * BARE, 70.0), entry("self_heating", 0.6 * BARE, 60.0)
    second = entry("clamp_slip", 1.3, 160.0)
    rounds = [a_round(entry("", BARE, 50.0), first, other), a_round(first, second)]
    alone = rounds[0].probabilities()
    together = if_exact(rounds[0].evidences(whole_of(rounds, [first, second])))
    assert alone["stress_relaxation"] < 0.1
    assert together["stress_relaxation"] > 0.9 > 1e3 * together["self_heating"]


def test_a_single_law_is_weighed_once():
    """What was put in alone is among the entries already: it must not speak twice for *something like it*."""
    found = entry("stress_relaxation", 2.0, 100.0)
    only = a_round(entry("", BARE, 50.0), found)
    assert only.probabilities(whole_of([only], [found])) == only.probabilities()


def test_what_the_last_model_misses_most_leads_whichever_was_found_first():
    found = [entry("stress_relaxation", 1.3, 160.0), entry("self_heating", 1.3, 160.0)]
    put_in = [replace(e, without=entry("", 2.0, log_z)) for e, log_z in zip(found, (150.0, 90.0), strict=True)]
    assert leading(put_in) == 1
    assert leading(put_in[::-1]) == 0
    assert leading(found[:1]) == leading([]) == 0


def test_a_map_does_not_stand_in_for_what_the_last_model_misses():
    """One hold of 24 h was a warming room: without its relaxation, a map of the past does nearly what that did."""
    found = [entry("stress_relaxation", 1.3, 160.0), entry("self_heating", 1.3, 160.0)]
    without = [replace(entry("", 9.0, 20.0), log_z=139.0), entry("", 2.0, 137.0)]
    assert leading([replace(e, without=w) for e, w in zip(found, without, strict=True)]) == 0


def test_what_adds_nothing_keeps_no_company_for_what_adds_only_beside_others():
    """The first added next to nothing alone, and is needed beside the second; an idle one is not."""
    first, second = entry("stress_relaxation", 0.9 * BARE, 51.0), entry("clamp_slip", 1.3, 160.0)
    rounds = [a_round(entry("", BARE, 50.0), first, entry("self_heating", BARE, 50.0)), a_round(first, second)]
    idle = {}
    for adds in (0.0, 30.0):
        rest = entry("", BARE, second.log_z - adds)
        whole = whole_of(rounds, [replace(first, without=rest), second])
        chances = rounds[0].probabilities(whole)
        idle[adds] = chances["self_heating"] / chances["stress_relaxation"]
    assert idle[0.0] > 0.1
    assert idle[30.0] < 1e-6


def test_what_was_named_alone_gets_no_other_name_in_company():
    """Another that adds more, but explains less, was weighed against it already."""
    good, more = entry("stress_relaxation", 1.3, 100.0), entry("clamp_slip", 0.7 * BARE, 101.0)
    second = entry("self_heating", 1.25, 140.0)
    rounds = [a_round(entry("", BARE, 50.0), more, good), a_round(good, second)]
    chances = rounds[0].probabilities(whole_of(rounds, [good, second]))
    assert max(chances, key=lambda name: chances[name]) == "stress_relaxation"


def test_what_a_round_does_not_weigh_is_told_as_it_was_believed_before():
    found = a_round(entry("", BARE, 5.0), entry("stress_relaxation", 2.0, 10.0))
    half = found.prior["clamp_slip"] / 2
    prior = {**found.prior, "clamp_slip": half, "mullins_softening": half}
    told = mixed_with_prior(found.probabilities(), prior, constants.MISLED)
    assert told["mullins_softening"] == pytest.approx(constants.MISLED * half)
    assert set(told) == set(prior)


def test_probabilities_and_what_is_told_of_them_sum_to_one():
    found = a_round(entry("", BARE, 5.0), entry("stress_relaxation", 2.0, 10.0))
    for chances in (found.probabilities(), found.doubted()):
        assert sum(chances.values()) == pytest.approx(1.0)
        assert set(chances) == {*LAWS, NOTHING, UNKNOWN}


def test_that_something_like_a_law_is_missing_is_as_sure_as_that_law():
    """What a perfect law leaves speaks for the law, whatever the error of its evidence."""
    found = a_round(entry("", BARE, 50.0), entry("stress_relaxation", 1.25, 100.0))
    law, like_it = (found.evidences()[name]["stress_relaxation"] for name in ("stress_relaxation", UNKNOWN))
    told = found.probabilities()
    assert told[UNKNOWN] / told["stress_relaxation"] == pytest.approx(np.exp(like_it - law), rel=0.1)


def test_the_best_of_many_laws_needs_a_few_nats_more_than_a_single_one():
    many = {f"mechanism_{k}": 4 for k in range(30)}
    base = entry("", 1.25, 0.0)

    def chance(laws: dict[str, int], nats: float) -> float:
        found = a_round(base, entry("mechanism_0", 1.25, nats))
        return if_exact(replace(found, laws=laws).evidences())["mechanism_0"]

    assert chance(many, 4.0) < 0.2
    assert chance(many, 12.0) > 0.9
    assert chance({"mechanism_0": 1}, 4.0) > 0.8, "alone it was not chosen"


def test_a_law_is_asked_for_the_channels_that_it_changes():
    """What is left in another speaks for more that is missing, not against this."""

    def left(floors: float, conductance: float) -> dict[str, float]:
        return {"force": floors * FLOOR["force"], "conductance": conductance * FLOOR["conductance"]}

    before, after = entry("", BARE, 50.0), entry("stress_relaxation", 1.3, 100.0)
    before.hypothesis.evidence.sigma = left(BARE, 3.0)
    after.hypothesis.evidence.sigma = left(1.3, 3.0)
    assert a_round(before, after).is_named()
    after.hypothesis.evidence.sigma = left(5.0, 1.3)  # and in its own it does
    assert not a_round(before, after).is_named()


def test_a_law_that_explains_one_channel_is_named_though_the_other_lacks_much():
    """And what is left is told of both."""
    before, after = entry("", BARE, 0.0), entry("stress_relaxation", 1.3, 100.0)
    for one in (before, after):
        one.hypothesis.evidence.sigma = {**one.hypothesis.evidence.sigma, "conductance": 20 * FLOOR["conductance"]}
    found = a_round(before, after)
    assert found.verdict() == "missing"
    assert found.left(after) < 0.05
    assert found.left(after, everywhere=True) == pytest.approx(0.93, abs=0.01)


@pytest.mark.parametrize(
    ("explained", "verdict"),
    [
        ({"force": 100 * BARE, "conductance": 0.0}, "nothing_missing"),  # a hundredth of it: so far off is any law
        ({"force": BARE, "conductance": 0.0}, "missing"),
        ({"force": 0.0, "conductance": 100 * BARE}, "missing"),  # a law of the conductance does not err in the force
    ],
)
def test_what_the_laws_put_in_may_err_by_is_no_second_effect(explained, verdict):
    so_far = {c: floors * FLOOR[c] for c, floors in explained.items()}
    second = entry("clamp_slip", 1.25, 60.0)
    assert a_round(entry("", BARE, 0.0), second).verdict() == "missing"
    assert a_round(entry("", BARE, 0.0), second, so_far=so_far).verdict() == verdict


def a_bend(floors: float = 1.25, conductance: float = 1.25, log_prior_bend: float = 0.0) -> Entry:
    """A law that changes the force as a bent law of the base would."""
    jam = replace(entry("clamp_slip", floors, 30.0), log_prior_bend=log_prior_bend)
    jam.hypothesis.evidence.sigma["conductance"] = conductance * FLOOR["conductance"]
    return jam


def test_a_bent_base_is_complete_only_if_it_is_in_every_channel():
    left = entry("", 4.0, 0.0)
    left.hypothesis.evidence.sigma["conductance"] = 4 * FLOOR["conductance"]
    assert a_round(left, a_bend()).verdict() == "nothing_missing"
    assert a_round(left, a_bend(conductance=4.0)).verdict() != "nothing_missing"


@pytest.mark.parametrize(("log_prior_bend", "is_bend"), [(-np.inf, False), (-12.0, False), (0.0, True)])
def test_a_law_is_a_bend_where_that_is_likelier_than_an_effect(log_prior_bend, is_bend):
    jam = a_bend(log_prior_bend=log_prior_bend)
    assert a_round(entry("", BARE, 0.0), jam).bend is (jam if is_bend else None)


def test_what_says_no_more_than_the_base_bends_nothing():
    assert a_round(entry("", BARE, 40.0), a_bend()).bend is None


def searched(*steps: Round) -> tuple[list[Round], list[Entry]]:
    """A search whose rounds are these, whatever it goes on from."""
    search, left = Search.__new__(Search), iter(steps)
    search.bases = lambda: ([], [])  # type: ignore[method-assign]
    search.round = lambda bent, stiff, so_far: next(left)  # type: ignore[method-assign]
    search.compare = lambda model: None  # type: ignore[method-assign, assignment, return-value]
    search.judged = lambda e, likelihood: replace(e, log_z=e.hypothesis.log_z)  # type: ignore[method-assign]
    search.each_left_out = lambda put_in, likelihood: list(put_in)  # type: ignore[method-assign]
    return search.run()


def test_what_is_found_beside_a_bent_base_is_what_is_missing():
    bend = a_bend(conductance=5.0)
    bend.hypothesis.model = KnitModel.of()
    relaxed = entry("stress_relaxation", 1.25, 200.0)
    beside = a_round(bend, relaxed)
    rounds, found = searched(a_round(entry("", BARE, 0.0), bend), beside)
    assert (rounds, found) == ([beside], [relaxed])


def test_a_bend_and_nothing_beside_it_is_nothing_missing():
    bend = a_bend()
    bend.hypothesis.model = KnitModel.of()
    first = a_round(entry("", BARE, 0.0), bend)
    rounds, found = searched(first, a_round(bend, entry("stress_relaxation", 1.25, 30.0)))
    assert rounds[0] is first
    assert found == []
    assert first.verdict() == "nothing_missing"


def in_a_model(mechanism: str, floors: float, log_z: float) -> Entry:
    """A law that a search can go on from."""
    e = entry(mechanism, floors, log_z)
    e.hypothesis.model = KnitModel.of()
    return e


def test_where_what_adds_most_leads_nowhere_the_search_begins_with_the_second():
    base, most, second = (
        entry("", BARE, 0.0),
        in_a_model("clamp_slip", 4.0, 60.0),
        in_a_model("self_heating", 6.0, 40.0),
    )
    first, rest = a_round(base, most, second), in_a_model("stress_relaxation", 1.25, 120.0)
    assert first.begins == [most, second]
    dead_end = a_round(most, in_a_model("stress_relaxation", 4.0, 61.0))
    done = a_round(rest)
    rounds, found = searched(first, dead_end, a_round(second, rest), done)
    assert [e.mechanism for e in found] == ["self_heating", "stress_relaxation"]
    told = rounds[0].probabilities(whole_of(rounds, found))
    assert told["self_heating"] > 0.9, "the other adds more, but the search has gone on from it"
    assert first.probabilities(whole_of(rounds, found))["clamp_slip"] > 0.9


def test_the_search_begins_once_where_a_law_explains_all_or_nothing_is_missing():
    good, more = entry("stress_relaxation", 1.3, 100.0), entry("clamp_slip", 0.7 * BARE, 101.0)
    assert a_round(entry("", BARE, 50.0), more, good).begins == [good]
    assert a_round(entry("", 1.25, 50.0), entry("stress_relaxation", 1.25, 51.0)).begins == []


def test_where_nothing_would_be_said_of_a_poor_base_the_search_begins_with_what_adds_anything():
    some, none = entry("clamp_slip", 6.0, 5.0), entry("self_heating", BARE, -1.0)
    first = a_round(replace(entry("", BARE, 0.0), log_z=90.0), some, none)
    assert (first.candidate, first.verdict()) == (None, "unknown")
    assert first.begins == [some]


def test_what_went_in_is_told_as_the_next_step_left_it():
    """Two rivals may share a valley that neither finds alone."""
    rough, fine = in_a_model("clamp_slip", 4.0, 60.0), in_a_model("clamp_slip", 1.25, 100.0)
    rounds, found = searched(
        a_round(entry("", BARE, 0.0), rough), a_round(fine, in_a_model("self_heating", 1.25, 99.0))
    )
    assert found[0].hypothesis is fine.hypothesis
    assert rounds[0].verdict() == "missing"


def test_of_the_laws_of_a_mechanism_the_one_goes_in_that_is_best_without_a_map_of_what_it_leaves():
    poorer, better = entry("stress_relaxation", 1.4, 100.0), entry("stress_relaxation", 1.3, 108.0)
    poorer, better = replace(poorer, law="one", log_z=115.0), replace(better, law="other", log_z=110.0)
    found = a_round(entry("", BARE, 50.0), poorer, better)
    assert found.candidate is found.goes_in is better


def test_only_what_the_search_may_go_on_from_keeps_its_sensitivities():
    """They are most of the memory of a round; what is said of it needs none."""

    def own(e: Entry) -> Entry:
        h = e.hypothesis
        return replace(e, hypothesis=SimpleNamespace(**vars(h), lean=SimpleNamespace(**vars(h), columns={})))

    best, *others = (own(entry(m, BARE - 2 * k, 100.0 + k)) for k, m in zip((3, 2, 1), LAWS, strict=True))
    whole = a_round(entry("", BARE, 50.0), best, *others)
    kept = whole.lean.entries
    assert kept[0] is whole.candidate is best
    assert [e.hypothesis for e in kept[1:]] == [e.hypothesis.lean for e in others]
    assert whole.lean.probabilities() == whole.probabilities()
    assert whole.lean.verdict() == whole.verdict() == "missing"


@pytest.mark.parametrize(("floors", "is_all"), [(1.25, True), (1.27, True), (1.5, False), (4.0, False)])
def test_the_search_ends_where_no_further_law_could_earn_its_prior(floors: float, is_all: bool) -> None:
    put_in = entry("stress_relaxation", floors, 500.0)
    found = a_round(entry("", 20.0, 50.0), put_in)
    found = replace(found, likelihood=replace(found.likelihood, rows=np.arange(constants.INDEPENDENT)))
    assert found.is_named()
    assert found.is_all(put_in) == is_all


def test_of_two_as_likely_hypotheses_the_law_has_added_what_its_prior_asks() -> None:
    found = a_round(entry("", BARE, 50.0), entry("stress_relaxation", 1.3, 100.0))
    asked = np.exp(found.least_asked - found.luck)
    chance = found.prior["stress_relaxation"]
    assert asked * chance == pytest.approx(found.prior[NOTHING] / 2)
