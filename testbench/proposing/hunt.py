"""Laws found one after the other: searched, refitted, and judged by their evidence."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np

from testbench.diagnosis.laplace import Hypothesis
from testbench.diagnosis.rounds import excess
from testbench.diagnosis.search import Progress, Search
from testbench.fitting.baseline import with_shapes
from testbench.knit.catalogue import Catalogue
from testbench.knit.effect import FloatArray
from testbench.knit.laws import check
from testbench.proposing.beam import Beam, Found
from testbench.proposing.chain import OpenChain
from testbench.proposing.grids import Grid, rounded
from testbench.proposing.results import Option, Step, numbered
from testbench.proposing.screening import Projector
from testbench.proposing.stability import SURE, stability
from testbench.proposing.trial import Bench, Trial
from testbench.proposing.writing import effect_class

NOTHING_LEFT = 0.3  # squared noise floors above the noise, all channels: the floors themselves are known to a tenth
LEAST_GAIN = 10.0  # nats: about ln of the number of laws that are tried
LEAST_SHARE = 0.1  # of the squared error above the noise that a law takes off
FINALISTS, OF_ONE_PLACE, OF_ONE_FAMILY, SETTLED = 6, 3, 2, 2
TIED = 3.0  # nats
WORTH_A_REFIT = 1.0  # nats to first order


class Hunt:
    """Laws found one after the other."""

    def __init__(
        self, search: Search, catalogue: Catalogue, tell: Progress, pool: ThreadPoolExecutor, name: str
    ) -> None:
        self.search, self.catalogue, self.tell, self.pool, self.name = search, catalogue, tell, pool, name
        self.measurement, self.likelihood = search.measurement, search.likelihood
        self.base = search.flexible
        self.said_nothing_left = excess(self.base, self.likelihood) < NOTHING_LEFT
        self.grid = self.grid_for(self.base)
        self.bench = Bench(self.likelihood, search.reference, self.grid)

    def grid_for(self, h: Hypothesis) -> Grid:
        """Start values of the parameters, from this recording and what a model leaves of it."""
        m = self.measurement
        span = rounded(float(np.max(m.signals["strain"])))
        residual = [values[m.counts] for values in m.residual(h.model).values()]
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
            current = found[1]
        return steps

    def round(self, current: Hypothesis, name: str) -> tuple[Step, Hypothesis] | None:
        """The best law beside a model, if one gains."""
        projector = Projector(current, self.likelihood, OpenChain(current.model, self.measurement))
        found = Beam(projector, self.grid_for(current), self.tell, self.pool).run()
        chosen = finalists([one for one in found if one.gain > LEAST_GAIN / 2])
        if not chosen:
            return None

        def refit(one: Found) -> Trial:
            self.tell(f"refitting with {one.law.key}")
            return self.bench.tried(one, name, current, projector.law_prior_sd(one.law))

        trials = list(self.pool.map(refit, chosen))
        order = sorted(range(len(trials)), key=lambda k: -trials[k].log_z)
        for k, trial in zip(order, self.pool.map(self.carried, [trials[k] for k in order[:SETTLED]]), strict=False):
            trials[k] = trial
        order.sort(key=lambda k: -trials[k].log_z)
        holds, wins = stability(current, [t.hypothesis for t in trials], self.likelihood)
        options = [
            Option(t.law, t.log_z - current.log_z, float(holds[k]), float(wins[k])) for k, t in enumerate(trials)
        ]
        paying = [k for k in order if self.pays(options[k], trials[k], current)]
        if not paying:
            return None
        best = paying[0]  # the evidence has taken off what its numbers cost
        rest = tuple(options[k] for k in order if k != best)
        tied = sum(abs(one.log_evidence - options[best].log_evidence) < TIED for one in rest)
        won = self.simpler(trials[best], current, projector)
        h, option = won.hypothesis, replace(options[best], law=won.law, log_evidence=won.log_z - current.log_z)
        return Step(option, rest, tied, self.dependence(won)), h

    def simpler(self, trial: Trial, current: Hypothesis, projector: Projector) -> Trial:
        """A law without those of its bends and factors that the evidence does not ask for."""
        best = trial
        for at in reversed(range(len(trial.law.term.operators))):
            if best.law.term.operators[at].kind == "memory":
                continue
            less = best.law.without(at)
            less = replace(less, strength=projector.of_law(less).strength)
            self.tell(f"refitting with {less.key}")
            quick = self.bench.tried(Found(less, 0.0), trial.name, current, projector.law_prior_sd(less))
            best = max(best, self.bench.settled(quick), key=lambda one: one.log_z)
        return best

    def pays(self, option: Option, trial: Trial, current: Hypothesis) -> bool:
        """Whether a law gains in evidence and in error, on nearly every part, and obeys the laws of all effects."""
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
        done = self.sharpened(self.bench.settled(trial))
        model = self.search.reference
        for key, effect in done.hypothesis.model.effects.items():
            model = model.plus(effect, key) if key.startswith(self.name) else model
        stiff = self.bench.anew(trial, model, done.hypothesis)
        free = with_shapes(stiff.hypothesis.model, self.measurement, self.catalogue)
        return max(done, stiff, self.bench.anew(trial, free, done.hypothesis), key=lambda one: one.log_z)

    def sharpened(self, trial: Trial) -> Trial:
        """A law whose numbers were sought once more beside the base that was refitted with it.

        What switches has no derivative, so no refit moves it; and beside the first base, which had taken in part of
        the law, it was best elsewhere.
        """
        chain = OpenChain(trial.hypothesis.model.without(trial.name), self.measurement)
        beam = Beam(Projector(trial.hypothesis, self.likelihood, chain), self.grid, self.tell, self.pool)
        now = beam.at(trial.law.place, trial.law.term, trial.law.values)
        then = beam.polish(now)
        if then.gain < now.gain + WORTH_A_REFIT:
            return trial
        return max(trial, self.bench.settled(self.bench.moved(trial, then.law)), key=lambda one: one.log_z)

    def dependence(self, trial: Trial) -> tuple[FloatArray, FloatArray, FloatArray]:
        """z of a law, and what the channel lacks without and with it, at samples that count."""
        m, rows, law, model = self.measurement, self.likelihood.rows, trial.law, trial.hypothesis.model
        z = law.term.evaluated(OpenChain(model, m).readable(law.place), law.values, m.dt_s)[rows]
        channel = law.place.channel if law.place.channel in m.channels else m.channels[0]
        without = m.residual(model.without(trial.name))[channel][rows]
        return z, without - np.median(without), m.residual(model)[channel][rows]


def finalists(found: Sequence[Found]) -> list[Found]:
    """The best, few of one place and family: first order cannot tell them, and some are artefacts of it."""
    kept: list[Found] = []
    for one in found:
        same = [k for k in kept if k.law.place == one.law.place]
        alike = [k for k in same if k.law.family == one.law.family]
        if len(same) < OF_ONE_PLACE and len(alike) < OF_ONE_FAMILY:
            kept.append(one)
        if len(kept) == FINALISTS:
            break
    return kept
