"""Effects put into a model and refitted: quickly where they seem likely, the best of each mechanism to its end."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from testbench.diagnosis.judging.entries import Entry, Proposal
from testbench.diagnosis.judging.ranking import best_first, evidence_of, first_of_each
from testbench.diagnosis.searching.candidates import can_act, is_vector
from testbench.diagnosis.searching.fits import Fits, law_names, like_another, newest
from testbench.diagnosis.searching.rivals import rivals_of
from testbench.diagnosis.searching.starts import best_start
from testbench.fitting import constants
from testbench.fitting.baseline import framed, without_shapes
from testbench.fitting.evidence.hypothesis import Hypothesis
from testbench.fitting.evidence.laplace import fitted
from testbench.knit.effect import Effect
from testbench.knit.model import KnitModel, by_stage, parts_of

LIKELIEST = 3  # mechanisms that are tried in more places, and by more of their laws
MORE, FEW = 4, 2  # places (a law beside a null model) in which one of those, and one of the others, is tried at first
NO_WORSE = 3.0  # standard deviations of the error of an evidence: what is this near the best may be as good


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


class Refits:
    """What is refitted in one step of a search.

    Attributes
    ----------
    fits : Fits
    """

    def __init__(self, fits: Fits) -> None:
        self.fits, self.pool, self.compared = fits, fits.pool, fits.compared

    def of(self, nulls: Sequence[NullModel], mechanisms: Sequence[str]) -> list[Entry]:
        """Mechanisms refitted: quickly beside the null models that speak for them, then the best of each in full."""
        chances = {m: self.chances(nulls, m) for m in mechanisms}
        chosen = [one for k, own in enumerate(chances.values()) for one in own[: MORE if k < LIKELIEST else FEW]]
        if not chosen:
            return []
        entries = self.best_of_each(self.on_better_bases(self.entered(chosen)))
        tried = {p.law for _, p in chosen}
        likeliest = list(dict.fromkeys(e.mechanism for e in entries))[:LIKELIEST]
        left = [[one for one in chances[m] if one[1].law not in tried] for m in likeliest]
        more = self.entered([one for own in left for one in own[: constants.LAWS]])
        more += self.on_other_bases(entries[0], nulls) + self.swapped(entries[0])
        return self.best_of_each(self.on_better_bases([*entries, *more]))

    def chances(self, nulls: Sequence[NullModel], mechanism: str) -> list[tuple[NullModel, Proposal]]:
        """Where a mechanism is refitted: its best law beside the first null model, then all its laws, the best first.

        Each law beside a base that bends, and beside one that does not: there a refit costs a tenth of a second, and
        tells more than its first step.
        """
        every = _chances(nulls, mechanism)
        laws = first_of_each(every[1:], lambda one: (one[1].law, one[0].bends))
        where = [null for null, _ in laws]
        refitted = zip(where, self.pool.map(self.stiff, where, [p for _, p in laws]), strict=True)
        return [*every[:1], *sorted(refitted, key=lambda one: -one[1].gain)]

    def stiff(self, null: NullModel, p: Proposal) -> Proposal:
        """A law refitted, if the base does not bend."""
        h = null.hypothesis
        if null.bends or p.model:
            return p
        model = best_start(h, p, self.compared)
        there = fitted(model, self.compared, self.fits.reference, h)
        return replace(p, gain=there.log_z - h.log_z, model=there.model)

    def entered(self, chosen: Sequence[tuple[NullModel, Proposal]]) -> list[Entry]:
        """Laws put in, each beside its null model, and refitted quickly."""
        return self.pool.map(lambda one: self.enter(*one), chosen)

    def enter(self, null: NullModel, p: Proposal) -> Entry:
        """A law refitted with shapes; beside a stiff base it was put in its place before they can take it over."""
        self.fits.tell(f"refitting with {p.law}")
        before = p.model or best_start(null.hypothesis, p, self.compared)
        h = self.fits.quickly(self.fits.bent(before), null.like)
        return Entry(p.mechanism, p.law, newest(before, null.hypothesis.model), h, h.log_z)

    def on_other_bases(self, e: Entry, nulls: Sequence[NullModel]) -> list[Entry]:
        """A law beside each stiff base of other laws: it need not be at its best where it was found."""

        def entry(null: NullModel) -> Entry:
            model = null.hypothesis.model.plus(e.hypothesis.model[e.name], e.name)
            stiff = fitted(model, self.compared, self.fits.reference, null.hypothesis)
            return e.refitted(self.fits.quickly(self.fits.bent(stiff.model), null.like))

        own = law_names(without_shapes(e.base).effects)
        others = [null for null in nulls if not null.bends and law_names(null.hypothesis.model.effects) != own]
        return self.pool.map(entry, others)

    def on_better_bases(self, entries: Sequence[Entry]) -> list[Entry]:
        """All entries; those beside other laws of the base than the best one also beside its laws.

        The base of a law may be worse by more than laws differ, most of all in a channel that it does not change:
        what acts on the conductance alone needs only the laws of the force from the best that does.
        """
        found = list(entries)
        for whole in (True, False):
            alike = [e for e in entries if acts_on_force(e.hypothesis.model[e.name]) == whole]
            best = max(alike, key=evidence_of, default=None)
            if best is not None:
                laws = law_names(_of_base(best, whole))
                others = [e for e in alike if law_names(_of_base(e, whole)) != laws]
                found += self.pool.map(partial(self.beside, best, whole), others)
        return found

    def beside(self, best: Entry, whole: bool, e: Entry) -> Entry:
        """A law beside the base of another or, if not the `whole`, beside its laws of the force, refitted quickly."""
        taken = _of_base(best, whole)
        own = e.hypothesis.model.effects
        rest = {name: own[name] for name in own if name == e.name or not (whole or acts_on_force(own[name]))}
        model = by_stage(taken | rest)
        known_priors = {a: prior for a, prior in best.hypothesis.priors.by_address.items() if parts_of(a)[0] in taken}
        return e.refitted(self.fits.quickly(model, e.hypothesis, known_priors))

    def swapped(self, best: Entry) -> list[Entry]:
        """The other laws of a mechanism in the place of its best one, as strong as that, refitted quickly."""
        here, strength = best.hypothesis, best.hypothesis.model[best.name].strength
        state = here.model.simulate(self.fits.measurement.signals, self.fits.measurement.dt_s)
        others = [law for law in self.fits.catalogue.mechanisms()[best.mechanism] if law.name != best.law]
        as_strong = [law for law in others if law.strength == strength and not is_vector(law, strength)]

        def entry(law: type[Effect]) -> Entry:
            model = best.base.plus(framed(like_another(here.model[best.name], law), best.base, self.fits.measurement))
            h = self.fits.quickly(model, here)
            return Entry(best.mechanism, law.name, newest(model, best.base), h, h.log_z)

        return self.pool.map(entry, [law for law in as_strong if can_act(law, state)])

    def rivals(self, e: Entry) -> list[Entry]:
        """Laws of other mechanisms that could do what a law does, in its place and refitted quickly.

        Where they were refitted before, they may have met a worse base.
        """
        here = fitted(e.base, self.compared, self.fits.reference, e.hypothesis, iterations=0)
        null = NullModel(here, here, tuple(rivals_of(e, self.fits)))
        likely = promising([null])[: constants.BENDING]
        return self.entered([one for m in likely for one in _chances([null], m)[: constants.LAWS]])

    def best_of_each(self, entries: Sequence[Entry]) -> list[Entry]:
        """The best law of each mechanism, and some more of the best two, refitted in full; the best first.

        A law may gain hundreds of nats on the way to its end.
        """
        laws = first_of_each(best_first(entries), lambda e: e.law)
        best = first_of_each(laws, lambda e: e.mechanism)
        own = [
            [e for e in laws if e.mechanism == one.mechanism][1 : constants.LAWS] for one in best[: constants.BEAM]
        ]
        chosen = [*best, *itertools.chain(*own)]
        rest = [e for e in laws if e not in chosen]
        return best_first([*self.pool.map(self.settled, chosen), *rest])

    def settled(self, e: Entry) -> Entry:
        """Refitted in full; one that acts on the force also from other points of its base, if laws there declare any.

        A base that had to do without the effect may lie in a wrong valley.
        """
        if e.is_settled:
            return e
        h = e.hypothesis
        found = [self.fits.at_rest(self.fits.compare(h.model, h))]
        if acts_on_force(h.model[e.name]):
            found += [self.fits.compare(model, h) for model in _begun_elsewhere(h.model)]
        return e.refitted(max(found, key=evidence_of), is_settled=True)

    def on_one_base(self, entries: Sequence[Entry]) -> tuple[Hypothesis, list[Entry]]:
        """The base of the best law, refitted without it; and all laws, where rivals were tried on that base as well.

        They may not have met it. Rivals are the best law of each other mechanism, and all others that are as good
        within what is known of an evidence.
        """
        best, *others = first_of_each([e for e in entries if e.is_settled], lambda e: e.mechanism)
        others += [e for e in entries if e not in (best, *others) and _as_good(e, best)]
        without = partial(self.fits.without, best.hypothesis, best.name)
        fits = [without, *(partial(self.in_place_of, best, e) for e in others)]
        base, *found = self.pool.map(lambda fit: fit(), fits)
        return base, first_of_each(best_first([*entries, *found]), lambda e: e.law)

    def in_place_of(self, best: Entry, e: Entry) -> Entry:
        """A law on the base of another."""
        h = self.fits.compare(best.base.plus(e.hypothesis.model[e.name], e.name), best.hypothesis)
        return e.refitted(self.fits.at_rest(h) if _as_good(h, best) else h, is_settled=True)


def promising(nulls: Iterable[NullModel]) -> list[str]:
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
    each = first_of_each(own, lambda one: one[1].law)
    return list(dict.fromkeys([*first, *each, *own]))


def _begun_elsewhere(model: KnitModel) -> Iterator[KnitModel]:
    """The model with each of its laws at each of the points that it declares and is not near."""
    for name, law in model.effects.items():
        for point in law.also_from:
            if not all(np.isclose(getattr(law, key), value, atol=0.02) for key, value in point.items()):
                yield model.with_parameters({f"{name}.{key}": value for key, value in point.items()})


def acts_on_force(effect: Effect) -> bool:
    """Whether it changes the force, and not only what the force and the strain make of the contacts."""
    return bool({"strain", "force_N"} & set(effect.writes))


def _of_base(e: Entry, whole: bool) -> dict[str, Effect]:
    """The laws of an entry's base, all or those of the force."""
    return {name: effect for name, effect in e.base.effects.items() if whole or acts_on_force(effect)}


def _as_good(one: Entry | Hypothesis, best: Entry) -> bool:
    """Within what is known of an evidence."""
    return one.log_z > best.log_z - NO_WORSE * constants.EVIDENCE_ERROR
