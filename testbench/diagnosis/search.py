"""One search over models: effects are added, and laws exchanged, until nothing improves the evidence."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from threadpoolctl import threadpool_limits

from testbench.comparing.ladder import drawn_to_data
from testbench.diagnosis import constants
from testbench.diagnosis.discrepancy_map import Map
from testbench.diagnosis.laplace import Hypothesis, fitted, under
from testbench.diagnosis.likelihood import Likelihood, likelihood_of, noise_of, telling
from testbench.diagnosis.proposals import Proposal, Screen, laws_of
from testbench.diagnosis.rounds import Entry, Round, excess, explained
from testbench.diagnosis.starts import best_start
from testbench.fitting.baseline import SHAPES, laws_that_may_act, starting_baseline, with_shapes, without_shapes
from testbench.fitting.measurement import Measurement, coarser
from testbench.knit.catalogue import Catalogue
from testbench.knit.effect import Effect
from testbench.knit.model import KnitModel

Progress = Callable[[str], None]
One = TypeVar("One", Proposal, Entry)


@dataclass(frozen=True, eq=False)
class Ground:
    """A model to add effects to, and what the laws of the catalogue promise there, the best first."""

    hypothesis: Hypothesis
    proposals: tuple[Proposal, ...]


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
        self.catalogue, self.tell = catalogue, tell
        noise = noise_of(measurement)
        self.measurement = telling(coarser(measurement, constants.GRID_HZ))
        tell("fitting the baseline")
        start = start or starting_baseline(self.measurement, catalogue)
        self.reference = without_shapes(start)
        self.likelihood = replace(likelihood_of(self.reference, self.measurement, noise), pieces=pieces)
        self.compared = self.likelihood.in_pieces
        tell("fitting the shape of the base laws")
        flexible = with_shapes(self.reference, self.measurement, catalogue, like=start)
        self.flexible = fitted(flexible, self.likelihood, self.reference, iterations=16)
        # What the user has is the model as given; where its laws bend already, so does what it is compared with.
        given = any(name in SHAPES for name in start)
        self.baseline = self.flexible if given else fitted(self.reference, self.likelihood, self.reference)

    def run(self, most: int = constants.ROUNDS) -> tuple[list[Round], list[Entry]]:
        """Rounds of the search, and what was put in, one a round.

        Two effects of one size leave each other's part unexplained, so that neither can be named alone: the first is
        put in even where it leaves more than it explains, and stays if the second explains the rest.
        """
        rounds: list[Round] = []
        found: list[Entry] = []
        with ThreadPoolExecutor(2) as self.pool:
            current, *others = self.bases()
            while len(rounds) < most:
                step = self.round(current, others)
                rounds.append(step)
                if step.candidate is None or (len(rounds) > 1 and not step.is_named()):
                    break
                found.append(step.candidate)
                current = step.candidate.hypothesis
                if step.is_named() and step.is_enough(step.candidate):
                    break
                others = [self.about_to_bend(self.compare(without_shapes(current.model)))]
        return rounds, found

    def bases(self) -> list[Hypothesis]:
        """The best base, and others whose laws are about to bend: the best of those, and the first.

        Where a base has bent to take an effect in, its other parameters have moved along; in one about to bend they
        have not. All laws that a base may have are tried.
        """
        model = without_shapes(self.baseline.model)
        laws = [*self.other_laws(model), *laws_that_may_act(model, self.measurement, self.catalogue)]
        started, *exchanged = self.pool.map(self.compare, [model, *(model.plus(law) for law in laws)])
        stiff = sorted([started, *exchanged], key=_evidence)[-constants.BASES :]
        bent = self.pool.map(lambda h: self.compare(self.bent(h.model)), stiff)
        best = max(*bent, self.compare(self.flexible.model, self.flexible), key=_evidence)
        return [best, *map(self.about_to_bend, dict.fromkeys((stiff[-1], started)))]

    def about_to_bend(self, h: Hypothesis) -> Hypothesis:
        """A base as it is, its shapes there to be used."""
        return fitted(self.bent(h.model), self.compared, self.reference, iterations=0)

    def compare(self, model: KnitModel, like: Hypothesis | None = None) -> Hypothesis:
        """A model fitted as models are compared."""
        return fitted(model, self.compared, self.reference, like)

    def bent(self, model: KnitModel) -> KnitModel:
        """A model with base laws that may bend, but do not yet."""
        return with_shapes(model, self.measurement, self.catalogue)

    def sharp(self, h: Hypothesis) -> Hypothesis:
        """The last fit of a model that was chosen."""
        return fitted(h.model, self.likelihood, self.reference, h)

    def round(self, current: Hypothesis, others: Sequence[Hypothesis]) -> Round:
        """One step.

        Parameters
        ----------
        current : Hypothesis
            The model so far, at its best.
        others : sequence of Hypothesis
            The same with other bases, beside which effects are proposed, too.
        """
        self.tell("screening the catalogue")
        likelihood = self.compared
        grounds = [self.ground(h) for h in (current, *others)]
        every = sorted((p for g in grounds for p in g.proposals), key=lambda p: -p.gain)
        proposals = _first_of_each(every, lambda p: p.law)
        counted = Counter(p.mechanism for p in proposals)
        entries = self.contest(grounds, proposals)
        before = [current]
        if entries:
            best = max(entries, key=lambda e: e.log_z)
            before.append(self.compare(best.hypothesis.model.without(best.name), best.hypothesis))
            likelihood = replace(likelihood, explained=explained(current, best.hypothesis))
        bare = max((self.entry("", under(h, likelihood), likelihood) for h in before), key=lambda e: e.log_z)
        entries = [
            self.entry(e.mechanism, under(e.hypothesis, likelihood), likelihood, e.law, e.name) for e in entries
        ]
        entries = _best_first(entries)
        unknown = float(np.logaddexp(Map(bare.hypothesis, likelihood).log_z, bare.log_z) - np.log(2))
        return Round(bare, unknown, tuple(entries), tuple(proposals), counted, likelihood)

    def ground(self, h: Hypothesis) -> Ground:
        """A model, and what each law of the catalogue promises beside it."""
        laws = laws_of(h, self.compared, self.catalogue, self.pool)
        proposals = tuple(Screen(h, self.compared).proposals(laws))
        return Ground(h, proposals)

    def other_laws(self, model: KnitModel) -> list[Effect]:
        """Laws that could take the place of one in the model, drawn to the data."""
        present = {effect.mechanism: effect.name for effect in model.effects.values() if not effect.strength}
        forms = [
            form
            for form in self.catalogue.effects.values()
            if not form.strength and form.mechanism in present and form.name != present[form.mechanism]
        ]
        return [drawn_to_data(form(), self.measurement) for form in forms]

    def contest(self, grounds: Sequence[Ground], proposals: Sequence[Proposal]) -> list[Entry]:
        """The best mechanisms refitted: all quickly, on every ground that speaks for them, then the best in full."""
        likely = [p for p in proposals if p.gain > 0]
        mechanisms = list(dict.fromkeys(p.mechanism for p in likely))[: constants.REFITS]
        chosen = []
        for place, mechanism in enumerate(mechanisms):
            own = [(g, p) for g in grounds for p in g.proposals if p.mechanism == mechanism and p.gain > 0]
            own.sort(key=lambda one: -one[1].gain)
            # Gains tell the laws on one ground from each other; that of the best ground is lost on all others.
            own.sort(key=lambda one: one != next((it for it in own if it[0] is grounds[0]), None))
            chosen += own[: 4 if place < 3 else 2]
        entries = self.entered(chosen)
        if not entries:
            return []
        entries = self.champions(entries)
        best = max(entries, key=lambda e: e.log_z)
        tried = {p.law for _, p in chosen}
        more = [(g, p) for g in grounds for p in g.proposals if p.mechanism == best.mechanism and p.law not in tried]
        more = [one for one in more if one[1].gain > 0][:3]
        return self.champions([*entries, *self.entered(more)])

    def champions(self, entries: Sequence[Entry]) -> list[Entry]:
        """The best law of each mechanism refitted in full, and all the others as they are, the best first."""
        laws = _first_of_each(_best_first(entries), lambda e: e.law)
        best = _first_of_each(laws, lambda e: e.mechanism)
        rest = [e for e in laws if e not in best]
        return _best_first([*self.pool.map(self.settled, best), *rest])

    def settled(self, e: Entry) -> Entry:
        """Refitted in full; contacts that were found to feel some strain are tried with the force alone, too.

        A base that had to do without the effect may lie in a wrong valley.
        """
        if e.is_settled:
            return e
        h, effect = e.hypothesis, e.hypothesis.model[e.name]
        found = [self.compare(h.model, h)]
        on_force = {"strain", "force_N"} & set(effect.writes)
        if on_force and getattr(h.model.effects.get("contact_drive"), "strain_share", 0.0) > 0.02:
            found.append(self.compare(h.model.with_parameters({"contact_drive.strain_share": 0.0}), h))
        found_best = max(found, key=_evidence)
        return replace(self.entry(e.mechanism, found_best, self.compared, e.law, e.name), is_settled=True)

    def entered(self, chosen: Sequence[tuple[Ground, Proposal]]) -> list[Entry]:
        """Laws put in, each on its ground, and refitted quickly."""
        return list(self.pool.map(lambda one: self.enter(*one), chosen))

    def enter(self, ground: Ground, p: Proposal) -> Entry:
        self.tell(f"refitting with {p.law}")
        model = best_start(ground.hypothesis, p, self.compared)
        name = next(n for n in model if n not in ground.hypothesis.model)
        believed = {f"{name}.{p.effect.strength}": p.believed} if p.believed and p.believed[0] > 0 else {}
        h = fitted(model, self.compared, self.reference, ground.hypothesis, 6, quick=True, believed=believed)
        return self.entry(p.mechanism, h, self.compared, p.law, name)

    def entry(self, mechanism: str, h: Hypothesis, likelihood: Likelihood, law: str = "", name: str = "") -> Entry:
        return Entry(mechanism, law, name, h, h.log_z, excess(h, likelihood))


def searched(
    measurement: Measurement,
    catalogue: Catalogue,
    most: int,
    start: KnitModel | None = None,
    tell: Progress | None = None,
    pieces: float = constants.INDEPENDENT,
) -> tuple[Search, list[Round], list[Entry]]:
    """A search, its rounds and what was put in, one a round; see `Search`."""
    # The kernels let go of the interpreter, so threads do run side by side; those of BLAS would only fight them.
    with threadpool_limits(1, "blas"):
        search = Search(measurement, catalogue, tell or (lambda _text: None), start, pieces)
        return search, *search.run(most)


def _evidence(h: Hypothesis) -> float:
    return h.log_z


def _first_of_each(ordered: Iterable[One], kind: Callable[[One], str]) -> list[One]:
    first: dict[str, One] = {}
    for one in ordered:
        first.setdefault(kind(one), one)
    return list(first.values())


def _best_first(entries: Iterable[Entry]) -> list[Entry]:
    return sorted(entries, key=lambda e: -e.log_z)
