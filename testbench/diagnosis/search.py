"""One search over models: effects are added, and laws exchanged, until nothing improves the evidence."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import TypeVar

import numpy as np
from threadpoolctl import threadpool_limits

from testbench.comparing.ladder import drawn_to_data
from testbench.diagnosis import constants
from testbench.diagnosis.candidates import can_act, is_vector
from testbench.diagnosis.discrepancy_map import log_z_with_map
from testbench.diagnosis.evidence.hypothesis import Hypothesis, own_part, under
from testbench.diagnosis.evidence.laplace import fitted
from testbench.diagnosis.evidence.likelihood import (
    Likelihood,
    jitter_of,
    law_error_of,
    likelihood_of,
    noise_of,
    on_the_grid,
    telling,
)
from testbench.diagnosis.proposals import Law, Proposal, Screen, laws_of
from testbench.diagnosis.rounds import Entry, Round, best_set, explained
from testbench.diagnosis.side_by_side import SideBySide
from testbench.diagnosis.starts import best_start, drawn_anew
from testbench.fitting.baseline import (
    SHAPES,
    framed,
    laws_that_may_act,
    starting_baseline,
    with_shapes,
    with_zeros,
    without_shapes,
)
from testbench.knit.catalogue import Catalogue
from testbench.knit.effect import Effect
from testbench.knit.model import KnitModel, parts_of
from testbench.measurements.measurement import Measurement
from testbench.measurements.noise_level import trimmed_rms

Progress = Callable[[str], None]
One = TypeVar("One", Proposal, Entry, Hypothesis, "tuple[NullModel, Proposal]")


@dataclass(frozen=True, eq=False)
class NullModel:
    """A model without the effect that is sought, and what the laws of the catalogue promise there, the best first.

    Attributes
    ----------
    hypothesis : Hypothesis
    like : Hypothesis
        The same with its shapes, whose sensitivities a refit begins with.
    proposals : tuple of Proposal
    """

    hypothesis: Hypothesis
    like: Hypothesis
    proposals: tuple[Proposal, ...]

    @property
    def bends(self) -> bool:
        """Whether it has its shapes."""
        return self.like is self.hypothesis


class Search:
    """A search over models of one measurement.

    Attributes
    ----------
    measurement : Measurement
        On the grid of the comparison; only samples that say something new count.
    reference : KnitModel
        The base as it was started from the data.
    likelihood : Likelihood
        For the last fit of a model.
    compared : Likelihood
        As models are compared.
    baseline, flexible : Hypothesis
        The user's model, and the same with base laws that bend.
    """

    def __init__(
        self,
        measurement: Measurement,
        catalogue: Catalogue,
        tell: Progress,
        start: KnitModel | None = None,
        pieces: float = constants.INDEPENDENT,
    ):
        self.catalogue, self.tell, self.pieces = catalogue, tell, pieces
        self.pool = SideBySide([*catalogue.effects.values(), *map(type, start.effects.values() if start else ())])
        self.whole, self.noise = measurement, noise_of(measurement)
        self.measurement = telling(on_the_grid(measurement))
        tell("fitting the baseline")
        start = with_zeros(start or starting_baseline(self.measurement, catalogue), self.measurement, catalogue)
        self.reference = without_shapes(start)
        tell("fitting the shape of the base laws")
        flexible = with_shapes(self.reference, self.measurement, catalogue, like=start)
        without_jitter = likelihood_of(self.reference, self.measurement, self.noise)
        first = fitted(flexible, without_jitter, self.reference, iterations=16)
        self.jitter_s = jitter_of((self.reference, first.model), measurement)
        self.likelihood = self.likelihood_on(self.measurement)
        self.flexible = fitted(first.model, self.likelihood, self.reference, first, iterations=16)
        # What the user has is the model as given; where its laws bend already, so does what it is compared with.
        given = any(name in SHAPES for name in start)
        self.baseline = self.flexible if given else fitted(self.reference, self.likelihood, self.reference)
        law_error = law_error_of(self.flexible.model, self.likelihood)
        self.compared = self.likelihood.with_law_error(law_error).in_pieces

    def run(self, most: int = constants.ROUNDS) -> tuple[list[Round], list[Entry]]:
        """Rounds of the search, and what was put in, one a round.

        Two effects of one size leave each other's part unexplained, so that neither can be named alone: what adds
        most evidence is put in even where it leaves more than it explains, and stays if the second explains the
        rest. A law that only bends the base is put in as well; if anything is found beside it, that is what is
        missing.
        """
        rounds: list[Round] = []
        found: list[Entry] = []
        bent, stiff = self.bases()
        while len(rounds) < most:
            step = self.round(bent, stiff)
            rounds.append(step)
            best = step.goes_in or (None if found else step.bend)
            if best is None or (found and not step.is_named()):
                break
            found.append(best)
            bent = [best.hypothesis]
            if step.is_enough(best) and (step.is_named() or best is step.bend):
                break
            stiff = [self.compare(without_shapes(bent[0].model))]
        while len(found) > 1 and found[0] is rounds[0].bend:
            del rounds[0], found[0]
        return rounds, best_set(rounds, found)

    def bases(self) -> tuple[list[Hypothesis], list[Hypothesis]]:
        """Bases whose laws bend, the best first; the best two whose laws do not, of these, all others and the first.

        In each place, all laws that may stand there are tried beside the best of the others so far.
        """
        first = best = self.compare(without_shapes(self.baseline.model))
        tried, before = [first], None
        while best is not before:
            before = best
            for place in first.model:
                tried += self.pool.map(self.compare, self.exchanged(best.model, place))
                best = max(tried, key=_evidence)
        may_act = laws_that_may_act(best.model, self.measurement, self.catalogue)
        tried += self.pool.map(self.compare, map(best.model.plus, may_act))
        stiff = sorted(tried, key=_evidence)[-constants.BASES :]
        starts = [*((self.bent(h.model), None) for h in stiff), (self.flexible.model, self.flexible)]
        bent = self.pool.map(lambda start: self.at_rest(self.compare(*start)), starts)
        bent = sorted(bent, key=_evidence, reverse=True)
        # One that was stripped of its shapes has parameters that moved along with them: the last choice of its kind.
        stripped = self.compare(without_shapes(bent[0].model))
        others = _first_of_each((stiff[-1], first, stripped), lambda h: _laws(h.model))
        return bent, sorted(others, key=_evidence, reverse=True)[: constants.BASES]

    def about_to_bend(self, h: Hypothesis) -> Hypothesis:
        """A base as it is, its shapes there to be used.

        Where a base has bent to take an effect in, its other parameters have moved along; here they have not.
        """
        return fitted(self.bent(h.model), self.compared, self.reference, iterations=0)

    def compare(self, model: KnitModel, like: Hypothesis | None = None) -> Hypothesis:
        """A model fitted as models are compared; one that was already is never left worse than it was."""
        found = fitted(model, self.compared, self.reference, like)
        if like is None or like.model != model or not like.counts_as(self.compared):
            return found
        return max(found, like, key=_evidence)

    def bent(self, model: KnitModel) -> KnitModel:
        """A model with base laws that may bend, but do not yet."""
        return with_shapes(model, self.measurement, self.catalogue)

    def sharp(self, chosen: Sequence[Hypothesis]) -> list[Hypothesis]:
        """The last fits of models that were chosen."""
        finest = self.finest

        def last(h: Hypothesis) -> Hypothesis:
            return fitted(h.model, finest, self.reference, h if finest is self.likelihood else None)

        return self.pool.map(last, chosen)

    @cached_property
    def finest(self) -> Likelihood:
        """For last fits: a recording of hours was searched on a coarse grid."""
        finer = telling(on_the_grid(self.whole, constants.FINER))
        if finer.dt_s == self.measurement.dt_s:
            return self.likelihood
        return self.likelihood_on(finer)

    def likelihood_on(self, measurement: Measurement) -> Likelihood:
        """How the samples of a grid count."""
        return likelihood_of(self.reference, measurement, self.noise, self.jitter_s, self.pieces)

    def round(self, bent: Sequence[Hypothesis], stiff: Sequence[Hypothesis]) -> Round:
        """One step.

        Parameters
        ----------
        bent : sequence of Hypothesis
            The model so far, at its best; the same with other bases, beside which effects are proposed, too.
        stiff : sequence of Hypothesis
            The same with bases none of whose laws bends.
        """
        self.tell("screening the catalogue")
        likelihood = self.compared
        current, open_ones = bent[0], [self.about_to_bend(h) for h in stiff]
        beside = [(h, h) for h in (*bent, *open_ones)] + list(zip(stiff, open_ones, strict=True))
        proposed = self.pool.map(self.proposals, [h for h, _ in beside])
        nulls = [NullModel(h, like, found) for (h, like), found in zip(beside, proposed, strict=True)]
        bending = nulls[: len(bent) + len(open_ones)]
        likely = _promising(bending)[: constants.BENDING]
        others = [m for m in _promising(nulls[len(bending) :]) if m not in likely]
        likely += others[: constants.STIFF]
        every = sorted((p for null in nulls for p in null.proposals), key=lambda p: -p.gain)
        proposals = _first_of_each(every, lambda p: p.law)
        counted = Counter(p.mechanism for p in proposals)
        before, entries = [current], self.refitted(nulls, likely)
        if entries:
            base, entries = self.on_one_base(entries)
            before.append(base)
            likelihood = replace(likelihood, explained=explained(current, entries[0].hypothesis))
        bare = max((self.judged(Entry("", "", "", h, h.log_z), likelihood) for h in before), key=lambda e: e.log_z)
        entries = self.all_judged(entries, likelihood)
        return Round(bare, tuple(entries), tuple(proposals), counted, likelihood)

    def all_judged(self, entries: Sequence[Entry], likelihood: Likelihood) -> list[Entry]:
        """The best first, which is carried to its end: a map may stand in for what a fit has not reached yet."""
        found = _best_first(self.judged(e, likelihood) for e in entries)
        while found and not found[0].is_settled:
            found = _best_first([self.judged(self.settled(found[0]), likelihood), *found[1:]])
        return found

    def judged(self, e: Entry, likelihood: Likelihood) -> Entry:
        """An entry as the hypotheses of a round are weighed: beside a map of what it leaves, or without."""
        h = under(e.hypothesis, likelihood)
        judged = replace(e, hypothesis=h, log_z=log_z_with_map(h, likelihood))
        if not e.name:
            return judged
        own = own_part(h, e.name, likelihood)
        return replace(judged, own_part=own, log_prior_bend=self.log_prior_bend(h.model[e.name], own))

    def log_prior_bend(self, effect: Effect, own: Mapping[str, float]) -> float:
        """Log probability that a law of the base is off by what an effect changes; minus infinity if none can be.

        Laws are off by `INEXACT` of what they explain. All effects that bend a law are as likely.
        """
        if not effect.is_a_bend(self.measurement.signals):
            return -np.inf
        alike = sum(one.bends_a_law for one in self.catalogue.effects.values())
        size = sum((own[c] / variation) ** 2 for c, variation in self.variation.items())
        return float(-0.5 * size / constants.INEXACT**2 - np.log(alike))

    @cached_property
    def variation(self) -> dict[str, float]:
        """Standard deviation of what was measured, over its relative noise, per channel."""
        likelihood, measured = self.compared, self.measurement.measured
        return {c: trimmed_rms(likelihood.picked(x - np.median(x), c)) for c, x in measured.items()}

    def proposals(self, h: Hypothesis) -> tuple[Proposal, ...]:
        """What each law of the catalogue promises beside a model, the best first."""
        laws = laws_of(h, self.compared, self.catalogue)
        found = Screen(h, self.compared).proposals(laws)
        if not any(name in SHAPES for name in h.model):
            found += [self.anew(h, law) for law in laws if law.is_of_strain and law.candidates[0].from_data]
        return tuple(_first_of_each(sorted(found, key=lambda p: -p.gain), lambda p: p.law))

    def anew(self, h: Hypothesis, law: Law) -> Proposal:
        """A law of the strain beside a stiff base that is drawn to the data anew, refitted."""
        there = fitted(drawn_anew(h, law, self.compared), self.compared, self.reference, h)
        effect = there.model[_newest(there.model, h.model)]
        size = abs(getattr(effect, effect.strength))
        gain = there.log_z - h.log_z - float(np.log(len(law.candidates)))
        return Proposal(law.mechanism, effect.name, effect, gain, np.zeros(0), (size, 0.3 * size), there.model)

    def chances(self, nulls: Sequence[NullModel], mechanism: str) -> list[tuple[NullModel, Proposal]]:
        """Where a mechanism is refitted: its best law beside the first null model, then all its laws, the best first.

        Each law beside a base that bends, and beside one that does not: there a refit costs a tenth of a second, and
        tells more than its first step.
        """
        every = _chances(nulls, mechanism)
        laws = _first_of_each(every[1:], lambda one: (one[1].law, one[0].bends))
        where = [null for null, _ in laws]
        refitted = zip(where, self.pool.map(self.stiff, where, [p for _, p in laws]), strict=True)
        return [*every[:1], *sorted(refitted, key=lambda one: -one[1].gain)]

    def stiff(self, null: NullModel, p: Proposal) -> Proposal:
        """A law refitted, if the base does not bend."""
        h = null.hypothesis
        if null.bends or p.model:
            return p
        model = best_start(h, p, self.compared)
        there = fitted(model, self.compared, self.reference, h, believed=self.believed(h, model, p))
        return replace(p, gain=there.log_z - h.log_z, model=there.model)

    def believed(self, h: Hypothesis, model: KnitModel, p: Proposal) -> dict[str, tuple[float, float]]:
        """Priors of a law's strength that only the data have a scale for."""
        if not p.believed or p.believed[0] <= 0:
            return {}
        return {f"{_newest(model, h.model)}.{p.effect.strength}": p.believed}

    def exchanged(self, model: KnitModel, place: str) -> list[KnitModel]:
        """The model with each other law of the catalogue that could stand in a place of it, drawn to the data."""
        there = model[place]
        others = [law for law in self.catalogue.effects.values() if law.name != there.name]
        others = [law for law in others if model.place_of(law) == place]
        return [model.replacing(place, self.started_like(there, law, model)) for law in others]

    def started_like(self, other: Effect, law: type[Effect], model: KnitModel) -> Effect:
        """A law that starts as another of its kind in what they share, and is drawn to the data in the rest."""
        return framed(drawn_to_data(_like(other, law), self.measurement), model, self.measurement)

    def refitted(self, nulls: Sequence[NullModel], mechanisms: Sequence[str]) -> list[Entry]:
        """Mechanisms refitted: quickly beside the null models that speak for them, then the best of each in full."""
        chances = {m: self.chances(nulls, m) for m in mechanisms}
        chosen = [one for k, own in enumerate(chances.values()) for one in own[: 4 if k < 3 else 2]]
        if not chosen:
            return []
        entries = self.best_of_each(self.on_better_bases(self.entered(chosen)))
        tried = {p.law for _, p in chosen}
        likeliest = list(dict.fromkeys(e.mechanism for e in entries))[:3]
        left = [[one for one in chances[m] if one[1].law not in tried] for m in likeliest]
        more = self.entered([one for own in left for one in own[:3]])
        return self.best_of_each(self.on_better_bases([*entries, *more, *self.swapped(entries[0])]))

    def on_better_bases(self, entries: Sequence[Entry]) -> list[Entry]:
        """All entries; those beside other laws of the base than the best one also beside its laws.

        The base of a law may be worse by more than laws differ, most of all in a channel that it does not change:
        what acts on the conductance alone needs only the laws of the force from the best that does.
        """
        found = list(entries)
        for whole in (True, False):
            alike = [e for e in entries if acts_on_force(e.hypothesis.model[e.name]) == whole]
            best = max(alike, key=_evidence, default=None)
            if best is not None:
                others = [e for e in alike if _laws(best.base, whole) != _laws(e.base, whole)]
                found += self.pool.map(partial(self.beside, best, whole), others)
        return found

    def beside(self, best: Entry, whole: bool, e: Entry) -> Entry:
        """A law beside the base of another or, if not the `whole`, beside its laws of the force, refitted quickly."""
        taken = {name: effect for name, effect in best.base.effects.items() if whole or acts_on_force(effect)}
        own = e.hypothesis.model.effects
        rest = {name: own[name] for name in own if name == e.name or not (whole or acts_on_force(own[name]))}
        model = KnitModel(dict(sorted((taken | rest).items(), key=lambda item: item[1].stage)))
        believed = {a: prior for a, prior in best.hypothesis.priors.believed.items() if parts_of(a)[0] in taken}
        h = fitted(model, self.compared, self.reference, e.hypothesis, 6, quick=True, believed=believed)
        return replace(e, hypothesis=h, log_z=h.log_z, is_settled=False)

    def swapped(self, best: Entry) -> list[Entry]:
        """The other laws of a mechanism in the place of its best one, as strong as that, refitted quickly."""
        here, strength = best.hypothesis, best.hypothesis.model[best.name].strength
        known = here.priors.believed.get(f"{best.name}.{strength}")
        state = here.model.simulate(self.measurement.signals, self.measurement.dt_s)
        others = [law for law in self.catalogue.mechanisms()[best.mechanism] if law.name != best.law]
        as_strong = [law for law in others if law.strength == strength and not is_vector(law, strength)]

        def entry(law: type[Effect]) -> Entry:
            model = best.base.plus(framed(_like(here.model[best.name], law), best.base, self.measurement))
            name = _newest(model, best.base)
            believed = {f"{name}.{strength}": known} if known else {}
            h = fitted(model, self.compared, self.reference, here, 6, quick=True, believed=believed)
            return Entry(best.mechanism, law.name, name, h, h.log_z)

        return self.pool.map(entry, [law for law in as_strong if can_act(law, state)])

    def on_one_base(self, entries: Sequence[Entry]) -> tuple[Hypothesis, list[Entry]]:
        """The base of the best law, refitted without it; and all laws, where rivals were tried on that base as well.

        They may not have met it. Rivals are the best law of each other mechanism, and all others that are as good
        within what is known of an evidence.
        """
        best, *others = _first_of_each([e for e in entries if e.is_settled], lambda e: e.mechanism)
        others += [e for e in entries if e not in (best, *others) and _as_good(e, best)]
        without = partial(self.without, best.hypothesis, best.name)
        fits = [without, *(partial(self.in_place_of, best, e) for e in others)]
        base, *found = self.pool.map(lambda fit: fit(), fits)
        return base, _first_of_each(_best_first([*entries, *found]), lambda e: e.law)

    def without(self, h: Hypothesis, name: str) -> Hypothesis:
        """A model without one of its effects, refitted."""
        return self.at_rest(self.compare(h.model.without(name), h))

    def in_place_of(self, best: Entry, e: Entry) -> Entry:
        """A law on the base of another."""
        h = self.compare(best.base.plus(e.hypothesis.model[e.name], e.name), best.hypothesis)
        if _as_good(h, best):
            h = self.at_rest(h)
        return replace(e, hypothesis=h, log_z=h.log_z, is_settled=True)

    def best_of_each(self, entries: Sequence[Entry]) -> list[Entry]:
        """The best law of each mechanism, and some more of the best two, refitted in full; the best first.

        A law may gain hundreds of nats on the way to its end.
        """
        laws = _first_of_each(_best_first(entries), lambda e: e.law)
        best = _first_of_each(laws, lambda e: e.mechanism)
        own = [[e for e in laws if e.mechanism == one.mechanism][1 : constants.SETTLED_LAWS] for one in best[:2]]
        chosen = [*best, *itertools.chain(*own)]
        rest = [e for e in laws if e not in chosen]
        return _best_first([*self.pool.map(self.settled, chosen), *rest])

    def settled(self, e: Entry) -> Entry:
        """Refitted in full; contacts that were found to feel some strain are tried with the force alone, too.

        A base that had to do without the effect may lie in a wrong valley.
        """
        if e.is_settled:
            return e
        h, effect = e.hypothesis, e.hypothesis.model[e.name]
        found = [self.at_rest(h)]
        if acts_on_force(effect) and getattr(h.model.effects.get("contact_drive"), "strain_share", 0.0) > 0.02:
            found.append(self.compare(h.model.with_parameters({"contact_drive.strain_share": 0.0}), h))
        found_best = max(found, key=_evidence)
        return replace(e, hypothesis=found_best, log_z=found_best.log_z, is_settled=True)

    def at_rest(self, h: Hypothesis) -> Hypothesis:
        """Refitted until nothing is gained, at first with shapes as free as they are without data.

        Shapes that were fitted beside another law hold what is in the way of this one.
        """
        best = max(self.compare(h.model, h.opened), h, key=_evidence)
        for _ in range(constants.REFITS):
            better = self.compare(best.model, best)
            if better.log_z < best.log_z + constants.EVIDENCE_ERROR:
                return better
            best = better
        return best

    def entered(self, chosen: Sequence[tuple[NullModel, Proposal]]) -> list[Entry]:
        """Laws put in, each beside its null model, and refitted quickly."""
        return self.pool.map(lambda one: self.enter(*one), chosen)

    def enter(self, null: NullModel, p: Proposal) -> Entry:
        """A law refitted with shapes; beside a stiff base it was put in its place before they can take it over."""
        self.tell(f"refitting with {p.law}")
        before = p.model or best_start(null.hypothesis, p, self.compared)
        name, believed = _newest(before, null.hypothesis.model), self.believed(null.hypothesis, before, p)
        model = self.bent(before)
        h = fitted(model, self.compared, self.reference, null.like, 6, quick=True, believed=believed)
        return Entry(p.mechanism, p.law, name, h, h.log_z)


def searched(
    measurement: Measurement,
    catalogue: Catalogue,
    most: int,
    start: KnitModel | None = None,
    tell: Progress | None = None,
    pieces: float = constants.INDEPENDENT,
) -> tuple[Search, list[Round], list[Entry]]:
    """A search, its rounds and what was put in, one a round; see `Search`."""
    # Threads of BLAS would only fight what runs side by side.
    with threadpool_limits(1, "blas"):
        search = Search(measurement, catalogue, tell or (lambda _text: None), start, pieces)
        return search, *search.run(most)


def _like(other: Effect, law: type[Effect]) -> Effect:
    """A law with the parameters that it shares with another."""
    return law().near(**{key: getattr(other, key) for key in law.model_fields if key in type(other).model_fields})


def acts_on_force(effect: Effect) -> bool:
    """Whether it changes the force, and not only what the force and the strain make of the contacts."""
    return bool({"strain", "force_N"} & set(effect.writes))


def _laws(model: KnitModel, whole: bool = True) -> str:
    """Which laws a model has, all or those of the force."""
    return " ".join(effect.name for effect in model.effects.values() if whole or acts_on_force(effect))


def _newest(model: KnitModel, before: KnitModel) -> str:
    """Name of the effect that a model has, and the one before it has not."""
    return next(name for name in model if name not in before)


def _evidence(found: Hypothesis | Entry) -> float:
    return found.log_z


def _as_good(one: Entry | Hypothesis, best: Entry) -> bool:
    """Within what is known of an evidence."""
    return one.log_z > best.log_z - 3 * constants.EVIDENCE_ERROR


def _promising(nulls: Iterable[NullModel]) -> list[str]:
    """Mechanisms that are worth their parameters to first order, the best first."""
    likely = sorted((p for null in nulls for p in null.proposals if p.gain > 0), key=lambda p: -p.gain)
    return list(dict.fromkeys(p.mechanism for p in likely))


def _chances(nulls: Sequence[NullModel], mechanism: str) -> list[tuple[NullModel, Proposal]]:
    """Where a mechanism is worth its parameters to first order.

    The best beside the first null model, then each law beside that where it gains most, then the rest: a general law
    gains most everywhere, which is no reason to try no other.
    """
    own = [(null, p) for null in nulls for p in null.proposals if p.mechanism == mechanism and p.gain > 0]
    own.sort(key=lambda one: -one[1].gain)
    # Gains tell the laws beside one null model from each other, not the null models.
    first = [one for one in own if one[0] is nulls[0]][:1]
    each = _first_of_each(own, lambda one: one[1].law)
    return list(dict.fromkeys([*first, *each, *own]))


def _first_of_each(ordered: Iterable[One], kind: Callable[[One], Hashable]) -> list[One]:
    first: dict[Hashable, One] = {}
    for one in ordered:
        first.setdefault(kind(one), one)
    return list(first.values())


def _best_first(entries: Iterable[Entry]) -> list[Entry]:
    return sorted(entries, key=lambda e: -e.log_z)
