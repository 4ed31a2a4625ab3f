"""Laws found one after the other: searched, refitted, and judged by their evidence."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from testbench.diagnosis.judging.comparison import excess
from testbench.diagnosis.judging.ranking import best_first, evidence_of, first_of_each
from testbench.diagnosis.searching.search import Search
from testbench.fitting.baseline import without_shapes
from testbench.fitting.evidence.hypothesis import Hypothesis
from testbench.fitting.evidence.laplace import fitted
from testbench.knit.effect import FloatArray
from testbench.knit.model import KnitModel
from testbench.knit.rules import check
from testbench.proposing.beam import Beam, diverse
from testbench.proposing.grids import Grid, rounded
from testbench.proposing.laws.law import Law
from testbench.proposing.laws_found import Option, Step, numbered
from testbench.proposing.open_chain import OpenChain
from testbench.proposing.screening import Projector
from testbench.proposing.stability import SURE, stability
from testbench.proposing.trial import TIED_NATS, LawFitter, Trial
from testbench.proposing.writing import effect_class

NOTHING_LEFT = 0.3  # squared noise floors above the noise, all channels: the floors themselves are known to a tenth
LEAST_GAIN = 10.0  # nats: about ln of the number of laws that are tried
LEAST_SHARE = 0.1  # of the squared error above the noise that a law takes off
FINALISTS, OF_ONE_PLACE, OF_ONE_FAMILY, SETTLED = 5, 3, 2, 2


class Hunt:
    """Laws found one after the other."""

    def __init__(self, search: Search, name: str, given: bool = False) -> None:
        """Make ready for a search.

        Parameters
        ----------
        name : str
            Of the effect.
        given : bool
            Whether the user gave the model: its laws are kept then.
        """
        self.search, self.tell, self.pool, self.name = search, search.tell, search.pool, name
        self.measurement, self.likelihood = search.measurement, search.likelihood
        keeps = given or excess(search.flexible, self.likelihood) < NOTHING_LEFT
        self.base = search.flexible if keeps else best_base(search)
        self.said_nothing_left = excess(self.base, self.likelihood) < NOTHING_LEFT
        self.stiff = stiff_start(search, self.base)
        self.grid = self.grid_for(self.base.model)
        self.found: list[Law] = []
        self.fitter = LawFitter(self.likelihood, search.reference, self.grid)

    def grid_for(self, model: KnitModel) -> Grid:
        """Start values of the parameters, from this recording and what a model leaves of it."""
        m = self.measurement
        span = rounded(float(np.max(m.signals["strain"])))
        residual = [values[m.counts] for values in m.residual(model).values()]
        return Grid(max(span, 1e-3), m.dt_s, float(m.signals["time_s"][-1]), residual)

    def run(self, most: int) -> list[tuple[Step, Hypothesis]]:
        """Laws that each gain, with the model that has them all so far."""
        current = self.base
        steps: list[tuple[Step, Hypothesis]] = []
        while len(steps) < most and excess(current, self.likelihood) >= NOTHING_LEFT:
            found = self.round(current, numbered(self.name, len(steps)))
            if found is None:
                break
            steps.append(found)
            self.found.append(found[0].option.law)
            current = found[1]
        return steps

    def round(self, current: Hypothesis, name: str) -> tuple[Step, Hypothesis] | None:
        """The best law beside a model, if one gains.

        It is sought three times: a base that has bent to take part of a law in makes another law of it, so laws are
        sought beside one that has not bent yet as well. The third time the base is where the best law so far,
        refitted with it, has taken it to.
        """
        nulls = (self.projected(current), self.projected(self.unbent(current)))
        trials = [one for null in nulls for one in self.look(null, name)]
        if not trials:
            return None
        first = self.fitter.settled(max(trials, key=evidence_of))
        null = self.projected(first.hypothesis, without=first.name)
        trials = _best_of_each([first, *trials, *self.look(null, name)])
        trials = _best_of_each([*self.pool.map(self.carried, trials[:SETTLED]), *trials])
        holds, wins = stability(current, [t.hypothesis for t in trials], self.likelihood)
        options = [
            Option(t.law, t.log_z - current.log_z, float(holds[k]), float(wins[k])) for k, t in enumerate(trials)
        ]
        best = next((k for k, o in enumerate(options) if self.pays(o, trials[k], current)), None)
        if best is None:
            return None
        rest = tuple(one for k, one in enumerate(options) if k != best)
        tied = sum(abs(one.log_evidence - options[best].log_evidence) < TIED_NATS for one in rest)
        won = self.simpler(trials[best], null)
        option = replace(options[best], law=won.law, log_evidence=won.log_z - current.log_z)
        return Step(option, rest, tied, self.dependence(won)), won.hypothesis

    def unbent(self, h: Hypothesis) -> Hypothesis:
        """A model whose base laws were fitted without their shapes, and may bend now."""
        stiff = fitted(without_shapes(h.model), self.likelihood, self.search.reference, h)
        return fitted(self.search.bent(stiff.model), self.likelihood, self.search.reference, stiff, iterations=0)

    def projected(self, h: Hypothesis, without: str = "") -> Projector:
        """Where laws are sought: beside a fitted model, or beside it without an earlier guess at the law.

        Without it the model is not fitted anew: it would bend to take the law in again.
        """
        base = h.model.without(without) if without else h.model
        return Projector(h, self.likelihood, OpenChain(base, self.measurement))

    def look(self, null: Projector, name: str) -> list[Trial]:
        """The best laws beside a base, refitted with it, quickly."""
        beam = Beam(null, self.grid_for(null.chain.model), self.tell, self.pool, self.found)
        found = beam.run()
        promising = [one for one in found if one.gain > LEAST_GAIN / 2]
        chosen = diverse(promising, FINALISTS, OF_ONE_FAMILY, OF_ONE_PLACE)
        return self.pool.map(lambda one: self.refitted(one.law, null, name), chosen)

    def refitted(self, law: Law, null: Projector, name: str) -> Trial:
        """A law refitted with its base, quickly, in the better of the ways in which it may act."""
        self.tell(f"refitting with {law.key}")
        sd = null.law_prior_sd(law)
        tried = [self.fitter.tried(one, name, null.hypothesis, sd, null.chain.model) for one in law.ways()]
        return max(tried, key=evidence_of)

    def simpler(self, trial: Trial, null: Projector) -> Trial:
        """A law without those of its pieces that the evidence does not ask for."""
        best = trial
        for at in reversed(range(len(trial.law.term.operators))):
            less = best.law.without(at)
            gain, strength = null.of_law(less)
            if gain > null.of_law(best.law)[0] - LEAST_GAIN:
                quick = self.refitted(replace(less, strength=strength), null, trial.name)
                best = max(best, self.fitter.settled(quick), key=evidence_of)
        return best

    def pays(self, option: Option, trial: Trial, current: Hypothesis) -> bool:
        """Whether a law gains in evidence and in error, on nearly every part, and keeps the rules of all effects."""
        before, after = excess(current, self.likelihood), excess(trial.hypothesis, self.likelihood)
        return (
            option.log_evidence > LEAST_GAIN
            and option.holds >= SURE
            and after < (1 - LEAST_SHARE) * before
            and not check(effect_class(option.law, trial.name, self.grid)())
        )

    def carried(self, trial: Trial) -> Trial:
        """A refit carried to its end, and beside bases that never bent to take the law in: stiff, and free to bend.

        A base that has done so has moved its other parameters along, and may not find back beside the law; and what
        it was bent by may not be needed any more.
        """
        done = self.fitter.settled(trial)
        model = self.stiff
        for key, effect in done.hypothesis.model.effects.items():
            model = model if key in self.base.model else model.plus(effect, key)
        stiff = self.fitter.anew(done, model)
        free = self.fitter.anew(done, self.search.bent(stiff.hypothesis.model))
        return max(done, stiff, free, key=evidence_of)

    def dependence(self, trial: Trial) -> tuple[FloatArray, FloatArray, FloatArray]:
        """z of a law, and what the channel lacks without and with it, at samples that count."""
        m, rows, law, model = self.measurement, self.likelihood.rows, trial.law, trial.hypothesis.model
        z = law.term.evaluated(OpenChain(model, m).readable(law.place), law.values, m.dt_s)[rows]
        channel = law.place.channel if law.place.channel in m.channels else m.channels[0]
        without = m.residual(model.without(trial.name))[channel][rows]
        return z, without - np.median(without), m.residual(model)[channel][rows]


def best_base(search: Search) -> Hypothesis:
    """The base whose laws were exchanged one by one for others of the catalogue while the evidence rose.

    A curve or a friction of the wrong kind leaves more than its shapes can mend, and what it leaves looks like a law
    that is missing. The diagnosis chooses its base in the same way. What is tied with the usual base stays out.
    """
    search.tell("choosing the laws of the base")
    bent, _ = search.bases()
    chosen = fitted(bent[0].model, search.likelihood, search.reference, bent[0])
    return chosen if chosen.log_z > search.flexible.log_z + TIED_NATS else search.flexible


def stiff_start(search: Search, base: Hypothesis) -> KnitModel:
    """The laws of a base where they lie without their shapes: a fit that shall not begin bent begins there."""
    if base is search.flexible:
        return search.start
    return fitted(without_shapes(base.model), search.likelihood, search.reference).model


def _best_of_each(trials: Sequence[Trial]) -> list[Trial]:
    """The best trial of each structure, the best first: its numbers are those of the base that it met."""
    return first_of_each(best_first(trials), lambda one: one.law.key)
