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
from testbench.diagnosis.likelihood import Likelihood, correlated, likelihood_of, noise_of, telling
from testbench.diagnosis.proposals import Proposal, Screen, laws_of
from testbench.fitting.baseline import SHAPES, starting_baseline, with_shapes, without_shapes
from testbench.fitting.measurement import Measurement, coarser
from testbench.knit.catalogue import Catalogue
from testbench.knit.effect import Effect
from testbench.knit.model import KnitModel

NOTHING, UNKNOWN = "nothing", "unknown"
Verdict = Literal["missing", "nothing_missing", "unknown"]
Progress = Callable[[str], None]
KEPT = 0.5  # of the gain to first order: a refit that keeps less started in the wrong place
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
        return self.before.log_z - self.likelihood.surplus(self.before.hypothesis.evidence.sigma)

    def left(self, entry: Entry) -> float:
        """Share of the error above the least misfit that an entry leaves; an error of that size is none."""
        return float(np.sqrt(entry.excess / (self.before.excess + 1.0)))

    def is_enough(self, entry: Entry) -> bool:
        """Whether an entry leaves no more than a law is expected to leave."""
        misfit = self.likelihood.misfit
        return all(sigma < 1.001 * misfit[c] for c, sigma in entry.hypothesis.evidence.sigma.items())

    def probabilities(self, left: float | None = None) -> dict[str, float]:
        """Of nothing, of unknown and of each mechanism to be what is missing most; they sum to 1.

        Parameters
        ----------
        left : float, optional
            Share of the error above the noise that the whole model leaves, if more was found after this.
        """
        u = constants.PRIOR_UNKNOWN
        logs = {
            NOTHING: np.log(constants.PRIOR_NOTHING * (1 - u)) + self.log_z_nothing,
            UNKNOWN: np.log(constants.PRIOR_NOTHING * u) + self.log_z_unknown,
            **{mechanism: self._log_posterior(mechanism) for mechanism in self.laws},
        }
        found = self.candidate
        if found:
            share = self.left(found) if left is None else min(left, self.left(found))
            # Laws of the catalogue are never quite the sensor's own: what is mostly explained is not unknown.
            logs[UNKNOWN] = min(logs[UNKNOWN], logs[found.mechanism] - _named(share))
        rest = max(logs[NOTHING], logs[UNKNOWN])
        for entry in self._speakers().values():
            share = self.left(entry) if entry is not found or left is None else min(left, self.left(entry))
            # And what explains little is no name, however much better it is than nothing.
            if share > constants.MOST_LEFT:
                logs[entry.mechanism] = min(logs[entry.mechanism], rest + _named(share))
        untried = self.left(self.before)
        if untried > constants.MOST_LEFT:
            for mechanism in set(self.laws) - set(self._speakers()):
                logs[mechanism] = min(logs[mechanism], rest + _named(untried))
        total = logsumexp(list(logs.values()))
        return {name: float(np.exp(value - total)) for name, value in logs.items()}

    def _speakers(self) -> dict[str, Entry]:
        """The best refitted law of each mechanism; two that both reach the noise differ in what they cost."""
        return {e.mechanism: e for e in sorted(self.entries, key=lambda e: e.hypothesis.log_z)}

    def _log_posterior(self, mechanism: str) -> float:
        """Log prior and evidence of a mechanism, its laws summed; to first order if none was refitted."""
        prior = np.log((1 - constants.PRIOR_NOTHING) / len(self.laws) / self.laws[mechanism])
        own = [e.log_z for e in self.entries if e.mechanism == mechanism]
        if not own:
            gains = (p.gain for p in self.proposals if p.mechanism == mechanism)
            # What the data do not ask for has nothing but its Occam factor, which no samples made.
            own = [self.before.log_z + min(gain, gain / self.likelihood.temperature) for gain in gains]
        return float(prior + logsumexp(own))

    @cached_property
    def candidate(self) -> Entry | None:
        """The best law of the mechanism with the most evidence, if it has more than nothing has."""
        speakers = self._speakers()
        if not speakers:
            return None
        mechanism = max(speakers, key=self._log_posterior)
        if self._log_posterior(mechanism) < np.log(constants.PRIOR_NOTHING) + self.log_z_nothing:
            return None
        return speakers[mechanism]

    def verdict(self, left: float | None = None) -> Verdict:
        """What is said of the model before this round; `left` as in `probabilities`."""
        if self.is_named(left):
            return "missing"
        chances = self.probabilities()
        return "nothing_missing" if chances[NOTHING] >= chances[UNKNOWN] else "unknown"

    def is_named(self, left: float | None = None) -> bool:
        """Whether some mechanism is more probable than nothing and unknown together."""
        chances = self.probabilities(left)
        return self.candidate is not None and chances[NOTHING] + chances[UNKNOWN] < 0.5


class Search:
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
        current = self.flexible
        rounds: list[Round] = []
        found: list[Entry] = []
        with ThreadPoolExecutor(2) as self.pool:
            while len(rounds) < most:
                step = self.round(current)
                rounds.append(step)
                if step.candidate is None or (len(rounds) > 1 and not step.is_named()):
                    break
                found.append(step.candidate)
                current = step.candidate.hypothesis
                if step.is_named() and step.is_enough(step.candidate):
                    break
        return rounds, found

    def round(self, current: Hypothesis) -> Round:
        self.tell("screening the catalogue")
        likelihood = self.likelihood
        current = under(current, likelihood)
        laws = laws_of(current, likelihood, self.catalogue, self.pool)
        proposals = Screen(current, likelihood).proposals(laws)
        counted: dict[str, int] = {}
        for p in proposals:
            counted[p.mechanism] = counted.get(p.mechanism, 0) + 1
        entries = self.contest(current, proposals, likelihood)
        others = self.other_laws(current) if entries else []
        before = [current, *self.pool.map(lambda law: self.exchanged(current, law, likelihood), others)]
        if entries:
            best = max(entries, key=lambda e: e.log_z)
            likelihood = correlated(likelihood, Map(best.hypothesis, likelihood).left)
            before.append(
                fitted(best.hypothesis.model.without(best.name), likelihood, self.reference, best.hypothesis)
            )
            likelihood = replace(likelihood, explained=explained(current, best.hypothesis))
        bare = max(
            (self.entry("", under(h, likelihood), likelihood) for h in before),
            key=lambda e: e.log_z,
        )
        entries = [
            self.entry(e.mechanism, under(e.hypothesis, likelihood), likelihood, e.law, e.name) for e in entries
        ]
        entries.sort(key=lambda e: -e.log_z)
        unknown = float(np.logaddexp(Map(bare.hypothesis, likelihood).log_z, bare.log_z) - np.log(2))
        return Round(bare, unknown, tuple(entries), tuple(proposals), counted, likelihood)

    def other_laws(self, current: Hypothesis) -> list[Effect]:
        """Laws that could take the place of one in the model, drawn to the data."""
        present = {effect.mechanism: effect.name for effect in current.model.effects.values() if not effect.strength}
        forms = [
            form
            for form in self.catalogue.effects.values()
            if not form.strength and form.mechanism in present and form.name != present[form.mechanism]
        ]
        return [drawn_to_data(form(), self.measurement) for form in forms]

    def exchanged(self, current: Hypothesis, law: Effect, likelihood: Likelihood) -> Hypothesis:
        return fitted(current.model.plus(law), likelihood, self.reference, current, iterations=6)

    def contest(self, current: Hypothesis, proposals: Sequence[Proposal], likelihood: Likelihood) -> list[Entry]:
        """The best mechanisms refitted: all quickly, then the best of them in full, then its other laws."""
        likely = [p for p in proposals if p.gain > 0]
        if not likely or likely[0].gain < likelihood.temperature:
            return []
        mechanisms = list(dict.fromkeys(p.mechanism for p in likely))
        chosen = []
        for place, mechanism in enumerate(mechanisms[: constants.REFITS]):
            chosen += [p for p in likely if p.mechanism == mechanism][: 2 if place < 3 else 1]
        entries = self.entered(current, chosen, likelihood)
        best = max(entries, key=lambda e: e.log_z)
        more = [p for p in likely if p.mechanism == best.mechanism and p not in chosen][:3]
        entries += self.entered(current, more, likelihood)
        entries.sort(key=lambda e: -e.log_z)
        full = [*self.pool.map(lambda e: self.settled(e, likelihood), entries[: constants.SETTLED])]
        return [*full, *entries[constants.SETTLED :]]

    def settled(self, e: Entry, likelihood: Likelihood) -> Entry:
        """Refitted in full from several starts: a base that had to do without the effect may lie in a wrong valley.

        Contacts that were found to feel some strain are tried with the force alone; and where much is left, so is the
        base as it was started from the data.
        """
        h, effect = e.hypothesis, e.hypothesis.model[e.name]
        on_force = {"strain", "force_N"} & set(effect.writes)
        found = [fitted(h.model, likelihood, self.reference, h)]
        if on_force and getattr(h.model.effects.get("contact_drive"), "strain_share", 0.0) > 0.02:
            alone = h.model.with_parameters({"contact_drive.strain_share": 0.0})
            found.append(fitted(alone, likelihood, self.reference, h))
        if on_force and excess(found[0], likelihood) > MUCH:
            anew = with_shapes(self.reference, self.measurement, self.catalogue).plus(effect, e.name)
            found.append(fitted(anew, likelihood, self.reference, iterations=16))
        best = max(found, key=lambda one: one.log_z)
        return self.entry(e.mechanism, best, likelihood, e.law, e.name)

    def entered(self, current: Hypothesis, proposals: Sequence[Proposal], likelihood: Likelihood) -> list[Entry]:
        def refitted(p: Proposal, start: Effect) -> tuple[Hypothesis, str]:
            model = current.model.plus(start)
            name = next(n for n in model if n not in current.model)
            address = f"{name}.{p.effect.strength}"
            believed = {address: p.believed} if p.believed and p.believed[0] > 0 else {}
            return fitted(model, likelihood, self.reference, current, 6, quick=True, believed=believed), name

        def enter(p: Proposal) -> Entry:
            self.tell(f"refitting with {p.law}")
            h, name = refitted(p, p.first)
            if p.first != p.effect and h.log_z - current.log_z < KEPT * p.gain:
                # A weak effect that holds on to nothing (a hum in another phase) loses itself.
                h = max(h, refitted(p, p.effect)[0], key=lambda one: one.log_z)
            return self.entry(p.mechanism, h, likelihood, p.law, name)

        return list(self.pool.map(enter, proposals))

    def entry(self, mechanism: str, h: Hypothesis, likelihood: Likelihood, law: str = "", name: str = "") -> Entry:
        log_z = likelihood.judged(h.log_z, h.evidence.sigma)
        return Entry(mechanism, law, name, h, log_z, excess(h, likelihood))


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


def _named(share_left: float) -> float:
    """Log odds that an effect which leaves this share of the error above the noise deserves to be named."""
    return 0.5 * (constants.MOST_LEFT**2 - share_left**2) / constants.LAW_ERROR**2


def explained(without: Hypothesis, with_it: Hypothesis) -> dict[str, float]:
    """Standard deviation of what an effect explains, per channel."""
    before, after = without.evidence.sigma, with_it.evidence.sigma
    return {c: float(np.sqrt(max(before[c] ** 2 - after[c] ** 2, 0.0))) for c in before}


def excess(h: Hypothesis, likelihood: Likelihood) -> float:
    """Squared error above the least that a law leaves, in units of it, summed over the channels."""
    least = {c: constants.LEAST_MISFIT * floor for c, floor in likelihood.floor.items()}
    return sum(max((sigma / least[c]) ** 2 - 1, 0.0) for c, sigma in h.evidence.sigma.items())
