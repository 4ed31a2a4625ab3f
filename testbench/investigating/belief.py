"""What all recordings so far say: the diagnosis, and the models that speak for what is still likely."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np
from scipy.special import logsumexp

from testbench.diagnosis.judging.probabilities import NOTHING, UNKNOWN, mixed_with_prior, prior_of
from testbench.diagnosis.judging.put_in import whole_of
from testbench.diagnosis.judging.rounds import Round
from testbench.diagnosis.searching.search import searched
from testbench.fitting import constants
from testbench.fitting.evidence.hypothesis import Hypothesis
from testbench.investigating.state import BeliefState, LikelyState
from testbench.knit.catalogue import Catalogue
from testbench.knit.model import KnitModel
from testbench.measurements.measurement import Measurement

RIVALS, LEAST = 4, 1e-3  # hypotheses that a motion is designed to separate; least probability of one


def belief_after(
    measurement: Measurement,
    runs: int,
    catalogue: Catalogue,
    start: KnitModel | None = None,
    most: int = 1,
    tell: Callable[[str], None] | None = None,
) -> BeliefState:
    """Diagnose a measurement that consists of `runs` recordings; each of them has its own independent pieces.

    The probabilities of ``nothing``, ``unknown`` and every mechanism are means over the errors of the evidences.

    Parameters
    ----------
    measurement : Measurement
        Of all recordings so far, joined.
    runs : int
        How many recordings these are.
    catalogue : Catalogue
    start : KnitModel, optional
        The model so far; default: the baseline.
    most : int
        Effects to find at most. The belief is about the one that is missing most.
    """
    _, rounds, put_in = searched(measurement, catalogue, most, start, tell, constants.INDEPENDENT * runs)
    first = rounds[0]
    whole = whole_of(rounds, put_in)
    verdict = first.verdict(whole)
    probabilities = dict(first.probabilities(whole if verdict == "missing" else None))
    return BeliefState(
        probabilities=probabilities,
        own=probabilities,
        verdict=verdict,
        noise=_noise(first),
        pieces=constants.INDEPENDENT,
        likely=_likely(first, probabilities),
    )


def before_any(names: Iterable[str]) -> dict[str, float]:
    """What is believed before the first recording."""
    return prior_of([name for name in names if name not in (NOTHING, UNKNOWN)])


def over_specimens(beliefs: Sequence[Mapping[str, float]]) -> dict[str, float]:
    """The probabilities that recordings of several fresh specimens give together.

    Specimens share what is missing and nothing else, so their evidence multiplies: the posteriors do, over the prior
    that each of them has in it.
    """
    logs = {name: np.log(chance) for name, chance in before_any(dict.fromkeys(n for b in beliefs for n in b)).items()}
    for one in beliefs:
        own = before_any(one)
        for name in logs:
            said = name if name in one else NOTHING  # of what cannot act it says what it says of nothing
            logs[name] += np.log(max(one.get(said, 0.0), 1e-12) / own[said])
    total = logsumexp(list(logs.values()))
    return {name: float(np.exp(value - total)) for name, value in logs.items()}


def doubted(beliefs: Sequence[Mapping[str, float]]) -> dict[str, float]:
    """The last of the beliefs that the evidence gave after each recording, as it is told.

    However sure, evidence speaks for the wrong mechanism in some sensors (`MISLED`), whose own laws are far from
    those of the catalogue in just this motion; then what was believed before any is all that is left. It is less
    doubted with each recording that has not changed the answer: one alone makes nothing sure, two that agree do.

    Parameters
    ----------
    beliefs : sequence of mapping
        Probabilities after each recording, all recordings so far in each.
    """
    last = beliefs[-1]
    answers = [max(one, key=one.__getitem__) for one in beliefs]
    agreeing = next((k for k, answer in enumerate(reversed(answers)) if answer != answers[-1]), len(answers))
    return mixed_with_prior(last, before_any(last), constants.MISLED**agreeing)


def _noise(first: Round) -> dict[str, float]:
    """What the best model leaves in each channel, at least what a law is expected to leave."""
    best = max((first.before, *first.entries), key=lambda e: e.log_z).hypothesis
    return {c: float(max(sigma, first.likelihood.misfit[c])) for c, sigma in best.evidence.sigma.items()}


def _likely(first: Round, probabilities: Mapping[str, float]) -> list[LikelyState]:
    """The best model of each hypothesis that has one; *unknown* has none that could foretell a recording."""
    found = {NOTHING: first.before.hypothesis}
    found |= {entry.mechanism: entry.hypothesis for entry in sorted(first.entries, key=lambda e: e.log_z)}
    ranked = sorted(found, key=lambda name: -probabilities[name])[:RIVALS]
    kept = [name for k, name in enumerate(ranked) if k < 2 or probabilities[name] >= LEAST]
    return [_as_likely(name, probabilities[name], found[name]) for name in kept]


def _as_likely(name: str, chance: float, h: Hypothesis) -> LikelyState:
    model = h.model_in_use
    scales = {group: float(scale) for group, scale in h.scales.items() if group.partition(".")[0] in model}
    return LikelyState(name=name, chance=chance, model=model.to_dict(), scales=scales)
