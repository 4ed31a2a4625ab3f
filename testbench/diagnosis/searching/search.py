"""One search over models: effects are added, and laws exchanged, until nothing improves the evidence."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np
from threadpoolctl import threadpool_limits

from testbench.diagnosis.judging.comparison import explained
from testbench.diagnosis.judging.discrepancy_map import log_z_with_map
from testbench.diagnosis.judging.entries import Entry, Proposal
from testbench.diagnosis.judging.put_in import best_set, log_posterior_of, whole_of
from testbench.diagnosis.judging.ranking import best_first, evidence_of, first_of_each
from testbench.diagnosis.judging.rounds import Round
from testbench.diagnosis.searching.fits import Fits, Progress, law_names, newest
from testbench.diagnosis.searching.proposals import Law, Screen, laws_of
from testbench.diagnosis.searching.refits import NullModel, Refits, promising
from testbench.diagnosis.searching.starts import drawn_anew
from testbench.fitting import constants
from testbench.fitting.baseline import SHAPES, laws_that_may_act, without_shapes
from testbench.fitting.evidence.hypothesis import Hypothesis, own_part, under
from testbench.fitting.evidence.laplace import fitted
from testbench.fitting.evidence.likelihood import Likelihood
from testbench.knit.catalogue import Catalogue
from testbench.knit.effect import Effect
from testbench.knit.model import KnitModel
from testbench.measurements.measurement import Measurement
from testbench.measurements.noise_level import trimmed_rms


class Search(Fits):
    """A search over models of one measurement; see `Fits` for what it has."""

    @cached_property
    def refits(self) -> Refits:
        """The moves of a step."""
        return Refits(self)

    def run(self, most: int = constants.ROUNDS) -> tuple[list[Round], list[Entry]]:
        """Rounds of the search, and what was put in, one a round.

        Where no first step can be named, the search goes on from each of the best; what comes of it decides.
        """
        first = self.round(*self.bases(), {})
        walks = []
        for begin in first.begins[: constants.BEAM]:
            walks.append(self.walk(first, begin, most))
            rounds, put_in = walks[-1]
            if rounds[0].is_named(whole_of(rounds, put_in)):
                break
            first = replace(first, dead_ends=first.dead_ends | {begin.mechanism})
        return max(walks, key=log_posterior_of, default=([first], []))

    def walk(self, first: Round, begin: Entry, most: int) -> tuple[list[Round], list[Entry]]:
        """Rounds, and what was put in, from one first step on.

        Two effects of one size leave each other's part unexplained, so that neither can be named alone: what adds
        most evidence is put in even where it leaves more than it explains, and stays if the second explains the
        rest. A law that only bends the base is put in as well; if anything is found beside it, that is what is
        missing.
        """
        rounds, found = [first], [begin]
        so_far: dict[str, float] = {}
        while len(rounds) < most and not rounds[-1].is_all(found[-1]):
            last = found[-1]
            so_far = {c: float(np.hypot(so_far.get(c, 0.0), some)) for c, some in rounds[-1].by_law(last).items()}
            bent = [last.hypothesis]
            rounds.append(self.round(bent, [self.compare(without_shapes(bent[0].model))], so_far))
            # Beside what goes in next, what went in last may have left a wrong valley.
            later = self.judged(replace(last, hypothesis=rounds[-1].before.hypothesis), rounds[-2].likelihood)
            if later.log_z > last.log_z:
                found[-1], rounds[-2] = later, rounds[-2].with_entry(later)
            best = rounds[-1].goes_in
            if best is None or not rounds[-1].is_named():
                break
            found.append(best)
        while len(found) > 1 and found[0] is rounds[0].bend:
            del rounds[0], found[0]
        put_in = best_set(rounds, found)
        return rounds, self.each_left_out(put_in, rounds[len(put_in) - 1].likelihood)

    def each_left_out(self, put_in: Sequence[Entry], likelihood: Likelihood) -> list[Entry]:
        """What was put in, each with all the others, if there are any, at their best without it."""
        if len(put_in) < 2:
            return list(put_in)

        def rest(e: Entry) -> Entry:
            h = self.without(put_in[-1].hypothesis, e.name)
            return self.judged(Entry.bare(h), likelihood)

        return [replace(e, without=one) for e, one in zip(put_in, self.pool.map(rest, put_in), strict=True)]

    def bases(self) -> tuple[list[Hypothesis], list[Hypothesis]]:
        """Bases whose laws bend, the best first; and the best two of those whose laws do not.

        One of each kind of conduction bends, however little it explains before: an effect may hide which it is.
        """
        base = without_shapes(self.baseline.model)
        begins = [KnitModel({name: (base if name in base else kind)[name] for name in kind}) for kind in self.kinds]
        kinds = [self.stiff_bases(one) for one in begins]
        stiff = best_first(h for tried in kinds for h in tried)[: constants.BEAM]
        begun = [*stiff, *(max(tried, key=evidence_of) for tried in kinds)]
        starts = [*((self.bent(h.model), None) for h in dict.fromkeys(begun)), (self.flexible.model, self.flexible)]
        bent = best_first(self.pool.map(lambda start: self.at_rest(self.compare(*start)), starts))
        # One that was stripped of its shapes has parameters that moved along with them: the last choice of its kind.
        stripped = self.compare(without_shapes(bent[0].model))
        others = first_of_each((stiff[0], kinds[0][0], stripped), lambda h: law_names(h.model.effects))
        return bent, best_first(others)[: constants.BEAM]

    def stiff_bases(self, start: KnitModel) -> list[Hypothesis]:
        """A base, and all in which a law of it was exchanged.

        In each place, all laws that may stand there are tried beside the best of the others so far.
        """
        best = self.compare(start)
        tried, before = [best], None
        while best is not before:
            before = best
            for place in start:
                tried += self.pool.map(self.compare, self.exchanged(best.model, place))
                best = max(tried, key=evidence_of)
        may_act = laws_that_may_act(best.model, self.measurement, self.catalogue)
        return tried + self.pool.map(self.compare, map(best.model.plus, may_act))

    def exchanged(self, model: KnitModel, place: str) -> list[KnitModel]:
        """The model with each other law of the catalogue that could stand in a place of it, drawn to the data."""
        there = model[place]
        others = [law for law in self.catalogue.effects.values() if law.name != there.name]
        others = [law for law in others if model.place_of(law) == place]
        return [model.replacing(place, self.started_like(there, law, model)) for law in others]

    def other_laws(self, before: KnitModel, after: KnitModel) -> dict[str, str]:
        """Laws of a base that took the place of others, or make the other kind of conduction: which stands where."""
        there = {name: effect.name for name, effect in after.effects.items()}
        kind = set(self.reference) - set(self.start)
        return {n: law for n, law in there.items() if n in kind or (n in before and law != before[n].name)}

    def round(self, bent: Sequence[Hypothesis], stiff: Sequence[Hypothesis], so_far: Mapping[str, float]) -> Round:
        """One step.

        Parameters
        ----------
        bent : sequence of Hypothesis
            The model so far, at its best; the same with other bases, beside which effects are proposed, too.
        stiff : sequence of Hypothesis
            The same with bases none of whose laws bends.
        so_far : mapping of channel to float
            What the laws explain that were put in before; see `Round.explained_before`.
        """
        self.tell("screening the catalogue")
        likelihood, current = self.compared, bent[0]
        nulls = self.null_models(bent, stiff)
        likely = promising(null for null in nulls if null.bends)[: constants.BENDING]
        others = [m for m in promising(null for null in nulls if not null.bends) if m not in likely]
        likely += others[: constants.STIFF]
        every = sorted((p for null in nulls for p in null.proposals), key=lambda p: -p.gain)
        proposals = first_of_each(every, lambda p: p.law)
        counted = Counter(p.mechanism for p in proposals)
        before, entries = [current], self.refits.of(nulls, likely)
        if entries:
            base, entries = self.refits.on_one_base(entries)
            before.append(base)
            likelihood = replace(likelihood, explained=explained(current, entries[0].hypothesis))
        bare = max((self.judged(Entry.bare(h), likelihood) for h in before), key=lambda e: e.log_z)
        entries = self.all_judged(entries, likelihood)
        return Round(bare, likelihood, tuple(entries), tuple(proposals), counted, so_far).lean

    def null_models(self, bent: Sequence[Hypothesis], stiff: Sequence[Hypothesis]) -> list[NullModel]:
        """Models beside which laws are proposed: those that bend, those that are about to, and the stiff ones."""
        open_ones = [self.about_to_bend(h) for h in stiff]
        beside = [(h, h) for h in (*bent, *open_ones)] + list(zip(stiff, open_ones, strict=True))
        proposed = self.pool.map(self.proposals, [h for h, _ in beside])
        return [NullModel(h, like, found) for (h, like), found in zip(beside, proposed, strict=True)]

    def proposals(self, h: Hypothesis) -> tuple[Proposal, ...]:
        """What each law of the catalogue promises beside a model, the best first."""
        laws = laws_of(h, self.compared, self.catalogue)
        found = Screen(h, self.compared).proposals(laws)
        if not any(name in SHAPES for name in h.model):
            found += [self.anew(h, law) for law in laws if law.is_of_strain and law.candidates[0].from_data]
        return tuple(first_of_each(sorted(found, key=lambda p: -p.gain), lambda p: p.law))

    def anew(self, h: Hypothesis, law: Law) -> Proposal:
        """A law of the strain beside a stiff base that is drawn to the data anew, refitted."""
        there = fitted(drawn_anew(h, law, self.compared), self.compared, self.reference, h)
        effect = there.model[newest(there.model, h.model)]
        gain = there.log_z - h.log_z - float(np.log(len(law.candidates)))
        return Proposal(law.mechanism, effect.name, effect, gain, np.zeros(0), there.model)

    def all_judged(self, entries: Sequence[Entry], likelihood: Likelihood) -> list[Entry]:
        """The best first, which is carried to its end and has met its rivals where it stands.

        A map may stand in for what a fit has not reached yet; or a fit, on its way to an end without a map, leaves
        where it is best with one.
        """
        found, met = best_first(self.pool.map(lambda e: self.judged(e, likelihood), entries)), set()
        while found and not (found[0].is_settled and found[0].mechanism in met):
            best, *others = found
            if best.is_settled:
                met.add(best.mechanism)
                tried = self.refits.rivals(best)
            else:
                tried, best = [self.refits.settled(best)], replace(best, is_settled=True)
            judged = self.pool.map(lambda e: self.judged(e, likelihood), tried)
            found = first_of_each(best_first([best, *others, *judged]), lambda e: e.law)
        return found

    def judged(self, e: Entry, likelihood: Likelihood) -> Entry:
        """An entry as the hypotheses of a round are weighed: beside a map of what it leaves, or without."""
        h = under(e.hypothesis, likelihood)
        judged = replace(e, hypothesis=h, log_z=log_z_with_map(h, likelihood))
        if not e.name:
            return judged
        own, whole = own_part(h, e.name, likelihood)
        bend = self.log_prior_bend(h.model[e.name], own)
        return replace(judged, own_part=own, whole_part=whole, log_prior_bend=bend)

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
