"""One search over models: effects are added, and laws exchanged, until nothing improves the evidence."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp

from testbench.diagnosis import constants
from testbench.diagnosis.discrepancy_map import Map
from testbench.diagnosis.laplace import Hypothesis, fitted, under
from testbench.diagnosis.likelihood import Likelihood, correlated, likelihood_of
from testbench.diagnosis.proposals import Proposal, Screen, laws_of
from testbench.discrepancy.baseline import SHAPES, starting_baseline, with_shapes, without_shapes
from testbench.discrepancy.fit import fit
from testbench.discrepancy.ladder import _drawn_to_data as drawn_to_data
from testbench.discrepancy.measurement import Measurement, coarser
from testbench.discrepancy.motion import reading_noise
from testbench.knit.catalogue import Catalogue
from testbench.knit.effect import Effect
from testbench.knit.model import KnitModel

NOTHING, UNKNOWN = "nothing", "unknown"
Progress = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class Entry:
    """One law put in and refitted."""

    mechanism: str
    law: str
    name: str
    hypothesis: Hypothesis
    log_z: float
    log_z_with_map: float

    @property
    def best(self) -> float:
        return float(np.logaddexp(self.log_z, self.log_z_with_map + np.log(constants.PRIOR_UNKNOWN)))


@dataclass(frozen=True, eq=False)
class Round:
    """One step: the model so far against the same with each mechanism added."""

    before: Entry
    entries: tuple[Entry, ...]
    proposals: tuple[Proposal, ...]
    laws: Mapping[str, int]
    likelihood: Likelihood

    def probabilities(self) -> dict[str, float]:
        u, count = constants.PRIOR_UNKNOWN, max(len(self.laws), 1)
        logs = {
            NOTHING: np.log(constants.PRIOR_NOTHING * (1 - u)) + self.before.log_z,
            UNKNOWN: np.log(constants.PRIOR_NOTHING * u) + self.before.log_z_with_map,
        }
        for mechanism in self.laws:
            own = [e for e in self.entries if e.mechanism == mechanism]
            prior = np.log((1 - constants.PRIOR_NOTHING) / count)
            if own:
                each = [np.logaddexp(np.log(1 - u) + e.log_z, np.log(u) + e.log_z_with_map) for e in own]
                logs[mechanism] = prior + float(logsumexp(each)) - np.log(self.laws[mechanism])
            else:
                gain = max((p.gain for p in self.proposals if p.mechanism == mechanism), default=-np.inf)
                logs[mechanism] = prior + self.before.log_z + gain - np.log(self.laws[mechanism])
        known = max(self.laws, key=lambda name: logs[name], default=None)
        entry = next((e for e in self.entries if e.mechanism == known), None)
        if known and entry:
            # Laws of the catalogue are never quite the sensor's own: what is mostly explained is not unknown.
            left = excess(entry.hypothesis, self.likelihood) / max(
                excess(self.before.hypothesis, self.likelihood), 1e-9
            )
            least = 0.5 * (left - constants.MOST_LEFT**2) / constants.LAW_ERROR**2
            logs[UNKNOWN] = min(logs[UNKNOWN], logs[known] + least)
        total = logsumexp(list(logs.values()))
        return {name: float(np.exp(value - total)) for name, value in logs.items()}

    @cached_property
    def accepted(self) -> Entry | None:
        """The best law of the most probable mechanism, if some mechanism is more probable than none."""
        chances = self.probabilities()
        if chances[NOTHING] + chances[UNKNOWN] > 0.5:
            return None
        mechanism = max(self.laws, key=lambda name: chances[name])
        return max((e for e in self.entries if e.mechanism == mechanism), key=lambda e: e.best, default=None)


class Search:
    def __init__(
        self,
        measurement: Measurement,
        catalogue: Catalogue,
        tell: Callable[[str], None],
        start: KnitModel | None = None,
    ):
        self.catalogue, self.tell = catalogue, tell
        self.measurement = coarser(measurement, constants.GRID_HZ)
        time_s = measurement.signals["time_s"]
        noise = {c: max(reading_noise(time_s, values), 1e-12) for c, values in measurement.measured.items()}
        tell("fitting the baseline")
        start = start or starting_baseline(self.measurement, catalogue)
        self.reference = fit(without_shapes(start), [self.measurement]).model
        self.likelihood = likelihood_of(self.reference, self.measurement, noise)
        tell("fitting the shape of the base laws")
        flexible = with_shapes(self.reference, self.measurement, catalogue, like=start)
        self.flexible = fitted(flexible, self.likelihood, self.reference, iterations=16)
        # What the user has is the model as given; where its laws bend already, so does what it is compared with.
        given = any(name in SHAPES for name in start)
        self.baseline = (
            self.flexible if given else fitted(self.reference, self.likelihood, self.reference, iterations=1)
        )

    def run(self, most: int = constants.ROUNDS) -> list[Round]:
        """Rounds of the search; only the last may find nothing."""
        current, rounds = self.flexible, []
        with ThreadPoolExecutor(2) as self.pool:
            for _ in range(most):
                rounds.append(self.round(current))
                found = rounds[-1].accepted
                if found is None:
                    break
                current = found.hypothesis
        return rounds

    def round(self, current: Hypothesis) -> Round:
        self.tell("screening the catalogue")
        laws = laws_of(current, self.likelihood, self.catalogue, self.pool)
        likelihood = self.likelihood
        current = under(current, likelihood)
        proposals = Screen(current, likelihood).proposals(laws)
        counted: dict[str, int] = {}
        for p in proposals:
            counted[p.mechanism] = counted.get(p.mechanism, 0) + 1
        entries = self.contest(current, proposals, likelihood)
        before = [
            current,
            *self.pool.map(
                lambda law: self.exchanged(current, law, likelihood), self.other_laws(current) if entries else []
            ),
        ]
        if entries:
            best = max(entries, key=lambda e: e.best)
            likelihood = correlated(likelihood, Map(best.hypothesis, likelihood).left)
            before.append(
                fitted(best.hypothesis.model.without(best.name), likelihood, self.reference, best.hypothesis)
            )
        bare = max(
            (self.entry("", under(h, likelihood), likelihood) for h in before if np.isfinite(h.log_z)),
            key=lambda e: e.best,
        )
        entries = [
            self.entry(e.mechanism, under(e.hypothesis, likelihood), likelihood, e.law, e.name) for e in entries
        ]
        return Round(bare, tuple(sorted(entries, key=lambda e: -e.best)), tuple(proposals), counted, likelihood)

    def other_laws(self, current: Hypothesis) -> list[Effect]:
        """Laws that could take the place of one in the model, drawn to the data."""
        present = {
            effect.idea or effect.name: effect.name
            for effect in current.model.effects.values()
            if not effect.strength
        }
        forms = [
            form
            for form in self.catalogue.effects.values()
            if not form.strength
            and (form.idea or form.name) in present
            and form.name != present[form.idea or form.name]
        ]
        return [drawn_to_data(form(), self.measurement) for form in forms]

    def exchanged(self, current: Hypothesis, law: Effect, likelihood: Likelihood) -> Hypothesis:
        return fitted(current.model.plus(law), likelihood, self.reference, current, iterations=6)

    def contest(self, current: Hypothesis, proposals: Sequence[Proposal], likelihood: Likelihood) -> list[Entry]:
        """The best mechanisms refitted: all quickly, then the best of them in full, then its other laws."""
        least = -np.log((1 - constants.PRIOR_NOTHING) / constants.PRIOR_NOTHING / 30)
        likely = [p for p in proposals if p.gain > 0]
        if not likely or likely[0].gain < least - 2:
            return []
        mechanisms = list(dict.fromkeys(p.mechanism for p in likely))
        chosen = []
        for place, mechanism in enumerate(mechanisms[: constants.REFITS]):
            chosen += [p for p in likely if p.mechanism == mechanism][: 2 if place < 3 else 1]
        entries = self.entered(current, chosen, likelihood)
        best = max(entries, key=lambda e: e.best)
        more = [p for p in likely if p.mechanism == best.mechanism and p not in chosen][:3]
        entries += self.entered(current, more, likelihood)
        entries.sort(key=lambda e: -e.best)
        full, rest, seen = [], [], set()
        for e in entries:
            (full if len(full) < 4 and list(seen).count(e.mechanism) < 2 else rest).append(e)
            seen.add(e.mechanism)
        return [*self.pool.map(lambda e: self.settled(e, likelihood), full), *rest]

    def settled(self, e: Entry, likelihood: Likelihood) -> Entry:
        """Refitted in full, also with contacts that feel the force alone where they were found to feel some strain."""
        h = e.hypothesis
        starts = [h.model]
        drive = getattr(h.model.effects.get("contact_drive"), "strain_share", 0.0)
        if drive > 0.02 and {"strain", "force_N"} & set(h.model[e.name].writes):
            starts.append(h.model.with_parameters({"contact_drive.strain_share": 0.0}))
        found = [fitted(start, likelihood, self.reference, h) for start in starts]
        best = max(found, key=lambda one: one.log_z)
        return self.entry(e.mechanism, best, likelihood, e.law, e.name)

    def entered(self, current: Hypothesis, proposals: Sequence[Proposal], likelihood: Likelihood) -> list[Entry]:
        def enter(p: Proposal) -> Entry:
            model = current.model.plus(p.effect)
            name = next(n for n in model if n not in current.model)
            self.tell(f"refitting with {p.law}")
            address = f"{name}.{p.effect.strength}"
            believed = {address: p.believed} if p.believed and p.believed[0] > 0 else {}
            h = fitted(model, likelihood, self.reference, current, iterations=6, quick=True, believed=believed)
            return self.entry(p.mechanism, h, likelihood, p.law, name)

        return list(self.pool.map(enter, proposals))

    def entry(self, mechanism: str, h: Hypothesis, likelihood: Likelihood, law: str = "", name: str = "") -> Entry:
        return Entry(mechanism, law, name, h, h.log_z + remainder(h, likelihood), Map(h, likelihood).log_z)


def excess(h: Hypothesis, likelihood: Likelihood) -> float:
    """Squared error above the noise, in noise floors, summed over the channels."""
    return sum(max((sigma / likelihood.floor[c]) ** 2 - 1, 0.0) for c, sigma in h.evidence.sigma.items())


def remainder(h: Hypothesis, likelihood: Likelihood) -> float:
    """Log prior of what a complete model leaves: an instrument's slow noise is of the size of its quick noise."""
    return -0.5 * excess(h, likelihood) / constants.SLOW_NOISE**2
