"""One search over models: effects are added, and laws exchanged, until nothing improves the evidence."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np
from scipy.special import logsumexp
from threadpoolctl import threadpool_limits

from testbench.comparing.ladder import drawn_to_data
from testbench.diagnosis import constants
from testbench.diagnosis.discrepancy_map import Map
from testbench.diagnosis.laplace import Hypothesis, fitted, under
from testbench.diagnosis.likelihood import Likelihood, likelihood_of, noise_of, telling
from testbench.diagnosis.proposals import Proposal, Screen, laws_of
from testbench.fitting.baseline import SHAPES, starting_baseline, with_shapes, without_shapes
from testbench.fitting.measurement import Measurement, coarser
from testbench.knit.catalogue import Catalogue
from testbench.knit.effect import Effect
from testbench.knit.model import KnitModel

NOTHING, UNKNOWN = "nothing", "unknown"
Verdict = Literal["missing", "nothing_missing", "unknown"]
Progress = Callable[[str], None]
MUCH = 3.0  # squared noise floors above the noise: then a fit is worth another start


@dataclass(frozen=True, eq=False)
class Entry:
    """One law put in and refitted.

    Attributes
    ----------
    mechanism, law, name : str
        Of the catalogue; `name` is its name in the model.
    log_z : float
        Log evidence of the model, as models are compared.
    excess : float
        Squared error above the least that a law leaves, in units of it, summed over the channels.
    """

    mechanism: str
    law: str
    name: str
    hypothesis: Hypothesis
    log_z: float
    excess: float


@dataclass(frozen=True, eq=False)
class Round:
    """One step: the model so far against the same with each mechanism added.

    Attributes
    ----------
    before : Entry
        The model so far, at its best.
    log_z_unknown : float
        Log evidence of the model so far beside what it leaves: noise of any size, or a free-form map.
    entries : tuple of Entry
        What was refitted, the best first.
    proposals : tuple of Proposal
        Every law of the catalogue, to first order.
    laws : mapping of mechanism to int
        Laws that speak for it.
    likelihood : Likelihood
    """

    before: Entry
    log_z_unknown: float
    entries: tuple[Entry, ...]
    proposals: tuple[Proposal, ...]
    laws: Mapping[str, int]
    likelihood: Likelihood

    @property
    def log_z_nothing(self) -> float:
        """Log evidence that nothing is missing: what is left is then noise, whose size is known."""
        return self.before.log_z + self._complete(self.before)

    def _complete(self, entry: Entry, left: Mapping[str, float] | None = None) -> float:
        """How much likelier what an entry leaves, or else what the whole model leaves, is if no more is missing."""
        sigma = entry.hypothesis.evidence.sigma
        by_law = explained(self.before.hypothesis, entry.hypothesis)
        both = (sigma, {c: min(own, left[c]) for c, own in sigma.items()} if left else sigma)
        return max(self.likelihood.noise_log_prior(one, by_law) for one in both)

    def left(self, entry: Entry) -> float:
        """Share of the error above the least misfit that an entry leaves; an error of that size is none."""
        return float(np.sqrt(entry.excess / (self.before.excess + 1.0)))

    def is_enough(self, entry: Entry) -> bool:
        """Whether an entry leaves no more than a law is expected to leave."""
        misfit = self.likelihood.misfit
        return all(sigma < 1.001 * misfit[c] for c, sigma in entry.hypothesis.evidence.sigma.items())

    def probabilities(self, left: Mapping[str, float] | None = None) -> dict[str, float]:
        """Of nothing, of unknown and of each mechanism to be what is missing most; they sum to 1.

        Parameters
        ----------
        left : mapping of channel to float, optional
            Standard deviation of what the whole model leaves, if more was found after this.
        """
        u = constants.PRIOR_UNKNOWN
        logs = {
            NOTHING: np.log(constants.PRIOR_NOTHING * (1 - u)) + self.log_z_nothing,
            UNKNOWN: np.log(constants.PRIOR_NOTHING * u) + self.log_z_unknown,
            **{mechanism: self._log_posterior(mechanism, left) for mechanism in self.laws},
        }
        total = logsumexp(list(logs.values()))
        return {name: float(np.exp(value - total)) for name, value in logs.items()}

    def _log_posterior(self, mechanism: str, left: Mapping[str, float] | None = None) -> float:
        """Log prior and evidence of a mechanism, its laws summed; to first order if none was refitted."""
        prior = np.log((1 - constants.PRIOR_NOTHING) / len(self.laws) / self.laws[mechanism])
        found = self.candidate if left else None
        own = [
            e.log_z + self._complete(e, left if e is found else None)
            for e in self.entries
            if e.mechanism == mechanism
        ]
        if not own:
            gains = (p.gain for p in self.proposals if p.mechanism == mechanism)
            own = [self.before.log_z + min(gain, 0.0) + self._complete(self.before) for gain in gains]
        return float(prior + logsumexp(own))

    @cached_property
    def candidate(self) -> Entry | None:
        """The best law of the most probable mechanism, if it is more probable than nothing."""
        if not self.entries:
            return None
        mechanism = max({e.mechanism for e in self.entries}, key=self._log_posterior)
        if self._log_posterior(mechanism) < np.log(constants.PRIOR_NOTHING) + self.log_z_nothing:
            return None
        return max((e for e in self.entries if e.mechanism == mechanism), key=lambda e: e.log_z + self._complete(e))

    def verdict(self, left: Mapping[str, float] | None = None) -> Verdict:
        """What is said of the model before this round; `left` as in `probabilities`."""
        if self.is_named(left):
            return "missing"
        chances = self.probabilities()
        return "nothing_missing" if chances[NOTHING] >= chances[UNKNOWN] else "unknown"

    def is_named(self, left: Mapping[str, float] | None = None) -> bool:
        """Whether some mechanism is more probable than nothing and unknown together."""
        chances = self.probabilities(left)
        return self.candidate is not None and chances[NOTHING] + chances[UNKNOWN] < 0.5


@dataclass(frozen=True, eq=False)
class Ground:
    """A model to add effects to, and what the laws of the catalogue promise there, the best first.

    An effect that a flexible base has taken in shows in no residual any more; it does where the base cannot bend.
    """

    hypothesis: Hypothesis
    start: KnitModel
    proposals: tuple[Proposal, ...]
    bends: bool


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
        stiff = self.compare(self.baseline.model)
        current = max(
            self.compare(self.flexible.model, self.flexible), self.compare(self.bent(stiff.model)), key=_evidence
        )
        rounds: list[Round] = []
        found: list[Entry] = []
        with ThreadPoolExecutor(2) as self.pool:
            while len(rounds) < most:
                step = self.round(current, stiff)
                rounds.append(step)
                if step.candidate is None or (len(rounds) > 1 and not step.is_named()):
                    break
                found.append(step.candidate)
                current = step.candidate.hypothesis
                if step.is_named() and step.is_enough(step.candidate):
                    break
                stiff = self.compare(without_shapes(current.model))
        return rounds, found

    def compare(self, model: KnitModel, like: Hypothesis | None = None) -> Hypothesis:
        """A model fitted as models are compared."""
        return fitted(model, self.compared, self.reference, like)

    def bent(self, model: KnitModel) -> KnitModel:
        """A model with base laws that may bend, but do not yet."""
        return with_shapes(model, self.measurement, self.catalogue)

    def sharp(self, h: Hypothesis) -> Hypothesis:
        """The last fit of a model that was chosen."""
        return fitted(h.model, self.likelihood, self.reference, h)

    def round(self, current: Hypothesis, stiff: Hypothesis) -> Round:
        """One step.

        Parameters
        ----------
        current : Hypothesis
            The model so far, at its best.
        stiff : Hypothesis
            The same model, whose base laws cannot bend.
        """
        self.tell("screening the catalogue")
        likelihood = self.compared
        grounds = [self.ground(current), self.ground(stiff)]
        proposals = _best_of_each_law([p for ground in grounds for p in ground.proposals])
        counted: dict[str, int] = {}
        for p in proposals:
            counted[p.mechanism] = counted.get(p.mechanism, 0) + 1
        entries = self.contest(grounds, proposals)
        others = self.other_laws(current) if entries else []
        before = [current, *self.pool.map(lambda law: self.exchanged(current, law), others)]
        if entries:
            best = max(entries, key=lambda e: e.log_z)
            before.append(self.compare(best.hypothesis.model.without(best.name), best.hypothesis))
            likelihood = replace(likelihood, explained=explained(current, best.hypothesis))
        bare = max((self.entry("", under(h, likelihood), likelihood) for h in before), key=lambda e: e.log_z)
        entries = [
            self.entry(e.mechanism, under(e.hypothesis, likelihood), likelihood, e.law, e.name) for e in entries
        ]
        entries.sort(key=lambda e: -e.log_z)
        unknown = float(np.logaddexp(Map(bare.hypothesis, likelihood).log_z, bare.log_z) - np.log(2))
        return Round(bare, unknown, tuple(entries), tuple(proposals), counted, likelihood)

    def ground(self, h: Hypothesis) -> Ground:
        """A model, and what each law of the catalogue promises beside it."""
        laws = laws_of(h, self.compared, self.catalogue, self.pool)
        proposals = tuple(Screen(h, self.compared).proposals(laws))
        bends = any(name in SHAPES for name in h.model)
        start = h.model if bends else self.bent(h.model)
        return Ground(
            h if bends else fitted(start, self.compared, self.reference, iterations=0), start, proposals, bends
        )

    def other_laws(self, current: Hypothesis) -> list[Effect]:
        """Laws that could take the place of one in the model, drawn to the data."""
        present = {effect.mechanism: effect.name for effect in current.model.effects.values() if not effect.strength}
        forms = [
            form
            for form in self.catalogue.effects.values()
            if not form.strength and form.mechanism in present and form.name != present[form.mechanism]
        ]
        return [drawn_to_data(form(), self.measurement) for form in forms]

    def exchanged(self, current: Hypothesis, law: Effect) -> Hypothesis:
        return fitted(current.model.plus(law), self.compared, self.reference, current, iterations=6)

    def contest(self, grounds: Sequence[Ground], proposals: Sequence[Proposal]) -> list[Entry]:
        """The best mechanisms refitted: all quickly, on every ground that speaks for them, then the best in full."""
        likely = [p for p in proposals if p.gain > 0]
        mechanisms = list(dict.fromkeys(p.mechanism for p in likely))[: constants.REFITS]
        chosen = []
        for place, mechanism in enumerate(mechanisms):
            for ground in grounds:
                own = [p for p in ground.proposals if p.mechanism == mechanism and p.gain > 0]
                chosen += [(ground, p) for p in own[: 2 if place < 3 else 1]]
        entries = self.entered(chosen)
        if not entries:
            return []
        best = max(entries, key=lambda e: e.log_z)
        tried = {p.law for _, p in chosen}
        more = [(g, p) for g in grounds for p in g.proposals if p.mechanism == best.mechanism and p.law not in tried]
        entries = _best_fits([*entries, *self.entered([one for one in more if one[1].gain > 0][:3])])
        full = [*self.pool.map(self.settled, entries[: constants.SETTLED])]
        return [*full, *entries[constants.SETTLED :]]

    def settled(self, e: Entry) -> Entry:
        """Refitted in full; contacts that were found to feel some strain are tried with the force alone, too.

        A base that had to do without the effect may lie in a wrong valley.
        """
        h, effect = e.hypothesis, e.hypothesis.model[e.name]
        found = [self.compare(h.model, h)]
        on_force = {"strain", "force_N"} & set(effect.writes)
        if on_force and getattr(h.model.effects.get("contact_drive"), "strain_share", 0.0) > 0.02:
            found.append(self.compare(h.model.with_parameters({"contact_drive.strain_share": 0.0}), h))
        return self.entry(e.mechanism, max(found, key=_evidence), self.compared, e.law, e.name)

    def entered(self, chosen: Sequence[tuple[Ground, Proposal]]) -> list[Entry]:
        def refitted(ground: Ground, effect: Effect, p: Proposal) -> tuple[Hypothesis, str]:
            model = ground.start.plus(effect)
            name = next(n for n in model if n not in ground.start)
            address = f"{name}.{p.effect.strength}"
            believed = {address: p.believed} if p.believed and p.believed[0] > 0 else {}
            h = fitted(model, self.compared, self.reference, ground.hypothesis, 6, quick=True, believed=believed)
            return h, name

        def enter(one: tuple[Ground, Proposal]) -> Entry:
            ground, p = one
            self.tell(f"refitting with {p.law}")
            # Where the base may hold the effect already, it starts weak: room is made for it step by step.
            h, name = refitted(ground, p.first if ground.bends else p.effect, p)
            return self.entry(p.mechanism, h, self.compared, p.law, name)

        return list(self.pool.map(enter, chosen))

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


def _best_of_each_law(proposals: Sequence[Proposal]) -> list[Proposal]:
    found: dict[str, Proposal] = {}
    for p in sorted(proposals, key=lambda p: -p.gain):
        found.setdefault(p.law, p)
    return list(found.values())


def _best_fits(entries: Sequence[Entry]) -> list[Entry]:
    """One of each law, the best first."""
    found: dict[str, Entry] = {}
    for e in sorted(entries, key=lambda e: -e.log_z):
        found.setdefault(e.law, e)
    return list(found.values())


def explained(without: Hypothesis, with_it: Hypothesis) -> dict[str, float]:
    """Standard deviation of what an effect explains, per channel."""
    before, after = without.evidence.sigma, with_it.evidence.sigma
    return {c: float(np.sqrt(max(before[c] ** 2 - after[c] ** 2, 0.0))) for c in before}


def excess(h: Hypothesis, likelihood: Likelihood) -> float:
    """Squared error above the least that a law leaves, in units of it, summed over the channels."""
    least = {c: constants.LEAST_MISFIT * floor for c, floor in likelihood.floor.items()}
    return sum(max((sigma / least[c]) ** 2 - 1, 0.0) for c, sigma in h.evidence.sigma.items())
