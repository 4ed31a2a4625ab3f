"""Weighing the evidence: which idea explains most of what the base cannot, at a fair price."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from testbench.discrepancy.candidates import Candidate
from testbench.discrepancy.fit import Fit
from testbench.discrepancy.measurement import Measurement
from testbench.discrepancy.screen import FLEXIBLE, STIFF, Judgement, judge_ideas
from testbench.discrepancy.traces import Traces, collect
from testbench.knit.catalogue import Catalogue

# What one shape of the base costs, as a share of what it buys: a physical effect that explains nearly as much with
# one or two numbers is the better explanation.
PRICE_OF_SHAPE = 0.08


Interval = tuple[float, float, float]  # value, low, high


@dataclass(frozen=True)
class Evidence:
    """One idea's case.

    Attributes
    ----------
    idea, form : str
        Physical idea and the catalogue effect that speaks for it.
    gain : float
        Mean over both weighings of ln(loss of the best base alone / loss with the idea).
    gains : dict of weighing to float
    mode : str
        How the base may bend when the idea is in.
    candidate : Candidate
    coefficient : float
        Of its trace, from the calibration recording.
    held_out : (value, low, high), optional
        ln(squared held-out error without / with it) once put in and refitted, with its 95 % interval; None where it
        was not worth a refit.
    seen : bool
        The readings themselves show it (`Effect.seen`).
    """

    idea: str
    form: str
    gain: float
    gains: Mapping[str, float]
    mode: str
    candidate: Candidate
    coefficient: float
    held_out: Interval | None = None
    seen: bool = False


@dataclass(frozen=True)
class Weighing:
    """All evidence of one screening.

    Attributes
    ----------
    ranking : tuple of Evidence
        Best first.
    base_mode : str
        How the base alone bends at the best price.
    base_gain : float
        ln(loss of the stiff base / loss of the best base): how much the base law itself misfits.
    ceiling : float
        ln(loss of the best base / loss with a free-form map): what any effect could gain.
    depends_on : tuple of (channel, coordinate, gain)
        What the residual depends on, most first.
    """

    ranking: tuple[Evidence, ...]
    base_mode: str
    base_gain: float
    ceiling: float
    depends_on: tuple[tuple[str, str, float], ...]


def structure_left(fitted: Fit, calibration: Measurement, held: Measurement) -> float:
    """How much a free-form map could still explain of what a model leaves: ln(loss without / loss with it)."""
    return weigh(collect(fitted, fitted.model, calibration, held, Catalogue({}))).ceiling


def weigh(traces: Mapping[str, Traces]) -> Weighing:
    """Judge every idea under both weighings and rank by the mean gain."""
    with ThreadPoolExecutor(len(traces)) as pool:
        judged = dict(zip(traces, pool.map(judge_ideas, traces.values()), strict=True))
    priced = {name: _priced(judgement) for name, judgement in judged.items()}
    ideas = set.intersection(*(set(judgement.ideas) for judgement in judged.values()))
    ranking = sorted((_evidence(idea, judged, priced) for idea in sorted(ideas)), key=lambda e: -e.gain)
    base_mode = min(priced["plain"].base, key=lambda mode: priced["plain"].base[mode])
    base_gain = float(np.mean([np.log(p.base[STIFF] / p.best_base) for p in priced.values()]))
    ceiling = float(np.mean([np.log(_base_loss(judged[n]) / judged[n].ceiling) for n in judged]))
    return Weighing(tuple(ranking), base_mode, base_gain, max(ceiling, 0.0), _dependence(judged))


@dataclass(frozen=True)
class _Priced:
    base: Mapping[str, float]
    ideas: Mapping[str, Mapping[str, float]]

    @property
    def best_base(self) -> float:
        return min(self.base.values())


def _priced(judgement: Judgement) -> _Priced:
    """Losses with the price of the shapes that each mode uses."""
    flexible = judgement.base[FLEXIBLE]
    shapes = [mode for mode in judgement.base if mode not in (STIFF, FLEXIBLE)]
    price = {shape: PRICE_OF_SHAPE * max(judgement.base[shape] - flexible, 0.0) for shape in shapes}
    total = sum(price.values())
    of_mode = {STIFF: 0.0, FLEXIBLE: total} | {shape: total - price[shape] for shape in shapes}
    base = {mode: loss + of_mode[mode] for mode, loss in judgement.base.items()}
    ideas = {
        idea: {mode: loss + of_mode[mode] for mode, loss in losses.items()}
        for idea, losses in judgement.ideas.items()
    }
    return _Priced(base, ideas)


def _evidence(idea: str, judged: Mapping[str, Judgement], priced: Mapping[str, _Priced]) -> Evidence:
    modes = priced["plain"].ideas[idea].keys()
    # One way of bending for both weighings: the best on the whole.
    totals = {
        mode: float(np.mean([np.log(p.best_base / p.ideas[idea][mode]) for p in priced.values()])) for mode in modes
    }
    mode = max(totals, key=lambda m: totals[m])
    gains = {name: float(np.log(p.best_base / p.ideas[idea][mode])) for name, p in priced.items()}
    score = judged["plain"].spokesmen[idea, mode]
    return Evidence(idea, score.best.form, totals[mode], gains, mode, score.best, score.coefficient)


def ranked_with_costs(weighing: Weighing, measured: Collection[str]) -> Weighing:
    """The ranking, best first, after each idea has paid for being rare or for imitating others easily.

    Parameters
    ----------
    measured : collection of str
        Signals that were recorded: an effect that follows a measured temperature pays nothing.
    """
    paid = [replace(entry, gain=entry.gain * share_after_costs(entry, measured)) for entry in weighing.ranking]
    return ranked(weighing, paid)


def depending_on(weighing: Weighing, channel: str, coordinate: str, gain: float) -> Weighing:
    """The weighing with one more coordinate that something unknown depends on."""
    found = [*weighing.depends_on, (channel, coordinate, gain)]
    return replace(weighing, depends_on=tuple(sorted(found, key=lambda item: -item[2])))


def ranked(weighing: Weighing, entries: Iterable[Evidence]) -> Weighing:
    """The weighing with these entries, best first."""
    return replace(weighing, ranking=tuple(sorted(entries, key=lambda entry: -entry.gain)))


def share_after_costs(entry: Evidence, measured: Collection[str]) -> float:
    """Share of the gain that an idea keeps after its cost."""
    effect = entry.candidate.effect
    known = bool(effect.optional_reads) and all(name in measured for name in effect.optional_reads)
    return 1.0 if known else 1.0 - effect.cost


def _base_loss(judgement: Judgement) -> float:
    return min(judgement.base.values())


def _dependence(judged: Mapping[str, Judgement]) -> tuple[tuple[str, str, float], ...]:
    names = judged["plain"].depends_on.keys()
    gains = [
        (
            channel,
            group,
            float(np.mean([np.log(_base_loss(j) / j.depends_on[channel, group]) for j in judged.values()])),
        )
        for channel, group in names
    ]
    return tuple(sorted((item for item in gains if item[2] > 0.005), key=lambda item: -item[2]))
