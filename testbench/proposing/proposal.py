"""From what the best model leaves to a law: searched, refitted, judged, and put on the ladder."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from threadpoolctl import threadpool_limits

from testbench.comparing.ladder import on_the_ladder
from testbench.diagnosis import constants
from testbench.diagnosis.laplace import Hypothesis, fitted
from testbench.diagnosis.rounds import excess
from testbench.diagnosis.search import Progress, Search
from testbench.fitting.baseline import SHAPES, with_shapes
from testbench.fitting.errors import noise_floors, over_the_floors
from testbench.fitting.fit import Fit
from testbench.fitting.measurement import Measurement, split
from testbench.fitting.model_file import ModelFile
from testbench.knit.catalogue import Catalogue, load_catalogue
from testbench.knit.effect import FloatArray
from testbench.knit.laws import check
from testbench.knit.model import KnitModel
from testbench.proposing.beam import Beam, Found
from testbench.proposing.blindness import not_judged
from testbench.proposing.chain import OpenChain
from testbench.proposing.grids import Grid, rounded
from testbench.proposing.law import Law
from testbench.proposing.places import PLACES
from testbench.proposing.screening import Projector
from testbench.proposing.stability import SURE, stability
from testbench.proposing.trial import Bench, Trial, as_fitted
from testbench.proposing.writing import effect_class
from testbench.recordings.recording import Recording

Verdict = Literal["proposed", "nothing_left", "no_law", "does_not_hold"]
MOST_LAWS = 2
NOTHING_LEFT = 0.3  # squared noise floors above the noise, all channels: the floors themselves are known to a tenth
MUCH = 3.0  # squared noise floors above the noise: then a fit is worth another start
LEAST_GAIN = 10.0  # nats: about ln of the number of laws that are tried
LEAST_SHARE = 0.1  # of the squared error above the noise that a law takes off
FINALISTS, OF_ONE_PLACE, OF_ONE_FAMILY, SETTLED = 6, 3, 2, 2
TIED = 3.0  # nats
WORTH_A_REFIT = 1.0  # nats to first order
MAY_RISE = (2 * constants.INDEPENDENT) ** -0.5  # of an error: so well is the RMS of a recording's pieces known


@dataclass(frozen=True)
class Option:
    """A law that was refitted.

    Attributes
    ----------
    law : Law
    log_evidence : float
        ln Z over the model without it, in nats.
    holds, chosen : float
        Shares of resampled recordings in which it gains, and in which it is the best.
    """

    law: Law
    log_evidence: float
    holds: float
    chosen: float


@dataclass(frozen=True)
class Step:
    """One law found, and what else could be it.

    Attributes
    ----------
    option : Option
    alternatives : tuple of Option
        The other laws that were refitted, the best first.
    tied : int
        How many of them these recordings cannot tell from it.
    dependence : tuple of ndarray
        z at the samples, and what is left of the channel there without and with the law.
    """

    option: Option
    alternatives: tuple[Option, ...]
    tied: int
    dependence: tuple[FloatArray, FloatArray, FloatArray]


@dataclass(frozen=True)
class Proposed:
    """Result of `propose_law`.

    Attributes
    ----------
    verdict : {"proposed", "nothing_left", "no_law", "does_not_hold"}
    name : str
        Of the effect; a second law is called ``NAME_2``.
    steps : tuple of Step
        The laws, in the order in which they were found.
    rejected : Step or None
        What was found on the calibration and does not hold on the held-out recording.
    notes : tuple of str
        What this recording cannot judge.
    before, after : ModelFile
        The ladder up to the wide base, and with the laws.
    error_before, error_after, noise_floor : mapping of channel to float
        Held-out RMS in N and in ln S.
    calibration, held : Measurement
    grid : Grid
    """

    verdict: Verdict
    name: str
    steps: tuple[Step, ...]
    rejected: Step | None
    notes: tuple[str, ...]
    before: ModelFile
    after: ModelFile
    error_before: Mapping[str, float]
    error_after: Mapping[str, float]
    noise_floor: Mapping[str, float]
    calibration: Measurement
    held: Measurement
    grid: Grid

    @property
    def laws(self) -> tuple[tuple[Law, str], ...]:
        """Laws and their names."""
        return tuple((step.option.law, numbered(self.name, k)) for k, step in enumerate(self.steps))


def numbered(name: str, index: int) -> str:
    """The name of the first law, the second, ..."""
    return name if index == 0 else f"{name}_{index + 1}"


def propose_law(
    recording: Recording,
    held_out: Recording | None = None,
    model: KnitModel | ModelFile | None = None,
    name: str = "my_effect",
    catalogue: Catalogue | None = None,
    progress: Progress | None = None,
    most: int = MOST_LAWS,
) -> Proposed:
    """Find the law that is missing from a model, whatever the catalogue knows.

    Parameters
    ----------
    recording : Recording
        To calibrate on; everything is chosen on it.
    held_out : Recording, optional
        For the final error, and to take back a law that does not hold; default the last third of `recording`.
    model : KnitModel or ModelFile, optional
        The best model so far; its base laws are made free to bend. Default: the baseline.
    name : str
        Of the effect.
    catalogue : Catalogue, optional
        Where the laws of the base come from.
    progress : callable, optional
        Called with a short text at each step.
    most : int
        Laws at most.

    Raises
    ------
    UserError
        If the recordings are too short or too still, have a constant channel, or do not fit together.
    """
    tell = progress or (lambda text: None)
    catalogue = catalogue or load_catalogue()
    file = model if isinstance(model, ModelFile) else None
    play_mm = file.clamp_play_mm if file and held_out else 0.0
    calibration, held = split(recording, held_out, clamp_play_mm=play_mm)
    given = file.model if file else model if isinstance(model, KnitModel) else None
    with threadpool_limits(1, "blas"), ThreadPoolExecutor(2) as pool:
        search = Search(calibration, catalogue, tell, given)
        hunt = Hunt(search, catalogue, tell, pool, name)
        found = hunt.run(most)
        return _judged(hunt, found, file, calibration, held)


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
        return Step(option, rest, tied, self.dependence(won.law, h)), h

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
        """A refit carried to its end; where much is left, also from the base as it was started from the data."""
        done = self.sharpened(self.bench.settled(trial))
        if excess(done.hypothesis, self.likelihood) < MUCH:
            return done
        effects = {n: e for n, e in done.hypothesis.model.effects.items() if n.startswith(self.name)}
        anew = with_shapes(self.search.reference, self.measurement, self.catalogue)
        for key, effect in effects.items():
            anew = anew.plus(effect, key)
        again = self.bench.trial(
            trial.law, trial.name, fitted(anew, self.likelihood, self.search.reference, iterations=16)
        )
        return max(done, again, key=lambda one: one.log_z)

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

    def dependence(self, law: Law, after: Hypothesis) -> tuple[FloatArray, FloatArray, FloatArray]:
        """z of a law, and what the channel lacks without and with it, at samples that count."""
        m, rows = self.measurement, self.likelihood.rows
        chain = OpenChain(after.model, m)
        z = law.term.evaluated(chain.readable(law.place), law.values, m.dt_s)[rows]
        channel = law.place.channel if law.place.channel in m.channels else m.channels[0]
        without = m.residual(after.model.without(_name_of(after.model, law, self.name)))[channel][rows]
        return z, without - np.median(without), m.residual(after.model)[channel][rows]


def _name_of(model: KnitModel, law: Law, name: str) -> str:
    """The last law of ours in a model."""
    return max((key for key in model if key.startswith(name)), key=len)


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


def _judged(
    hunt: Hunt,
    found: Sequence[tuple[Step, Hypothesis]],
    file: ModelFile | None,
    calibration: Measurement,
    held: Measurement,
) -> Proposed:
    """On the ladder, as far as each law holds on the held-out recording."""
    hunt.tell("judging on the held-out recording")
    given = any(name in SHAPES for name in (file.model if file else ()))
    before = file or on_the_ladder(_as_fit(hunt.search.baseline), None, "baseline", calibration, held)
    step_name = "refitted" if given else "+ shape freedom"
    before = on_the_ladder(_as_fit(hunt.base), before, step_name, calibration, held)
    floors = noise_floors(held)
    after = before
    rejected: Step | None = None
    kept: list[Step] = []
    for index, (step, h) in enumerate(found):
        step = replace(step, option=replace(step.option, law=at_its_instrument(step.option.law)))
        tried = on_the_ladder(
            _as_fit(with_class(h, step.option.law, numbered(hunt.name, index), hunt.grid)),
            after, f"+ {numbered(hunt.name, index)}", calibration, held,
        )  # fmt: skip
        if not holds(_held(after), _held(tried), floors):
            rejected = step
            break
        after = tried
        kept.append(step)
    # A law that came later has moved the numbers of those before it.
    kept = [_as_in(after.model, step, numbered(hunt.name, k)) for k, step in enumerate(kept)]
    verdict: Verdict = "proposed" if kept else "does_not_hold" if rejected else "no_law"
    if hunt.said_nothing_left:
        verdict = "nothing_left"
    return Proposed(
        verdict, hunt.name, tuple(kept), rejected, tuple(not_judged(calibration)), before, after,
        _held(before), _held(after), floors, calibration, held, hunt.grid,
    )  # fmt: skip


def _as_in(model: KnitModel, step: Step, name: str) -> Step:
    return replace(step, option=replace(step.option, law=as_fitted(step.option.law, model[name])))


def with_class(h: Hypothesis, law: Law, name: str, grid: Grid) -> Hypothesis:
    """The hypothesis with the law as the file will hold it."""
    effect = effect_class(law, name, grid)()
    model = KnitModel({k: e for k, e in h.model.effects.items() if k != name}).plus(effect, name)
    return replace(h, model=model)


def holds(before: Mapping[str, float], after: Mapping[str, float], floors: Mapping[str, float]) -> bool:
    """Whether the held-out error, the mean of the channels in noise floors, falls, and rises surely in none."""
    return over_the_floors(after, floors) < over_the_floors(before, floors) and all(
        after[c] <= (1 + MAY_RISE) * before[c] for c in floors
    )


def at_its_instrument(law: Law) -> Law:
    """A law of the conductance that depends on readings alone, at once or by a dead band, is one of the meter."""
    readings = {"conductance", "force", "force rate"}
    at_once = law.term.memory in ("", "late", "dead band")
    if law.place.name == "conductance" and law.term.coordinate.name in readings and at_once:
        return replace(law, place=PLACES["conductance reading"])
    return law


def _held(file: ModelFile) -> Mapping[str, float]:
    return file.history[-1]["errors"]["held_out"]


def _as_fit(h: Hypothesis) -> Fit:
    """A hypothesis as a fit, for the ladder."""
    return Fit(h.model, h.priors.parameters, h.vector, h.evidence.covariance, dict(h.evidence.sigma), 0)
