"""Probabilities of hypotheses about what is missing: before the data, after them, and as they are told."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from functools import cache
from zlib import crc32

import numpy as np
from scipy.special import logsumexp

from testbench.fitting import constants
from testbench.knit.effect import FloatArray
from testbench.knit.effect_names import HYPOTHESES

NOTHING, UNKNOWN = HYPOTHESES
SO_FAR = ""  # the source that is the model so far
DRAWS = 10_000  # of the errors of the evidences: a mean is then known within half a percent
# Log prior and evidence of each hypothesis, by source: the model so far, or that with a law of some mechanism.
Evidences = Mapping[str, Mapping[str, float]]


def by_source(logs: Iterable[tuple[str, float]]) -> dict[str, float]:
    """Numbers, as logarithms, with their sources; those of one source are summed."""
    found: dict[str, float] = {}
    for source, log in logs:
        found[source] = float(np.logaddexp(found.get(source, -np.inf), log))
    return found


def prior_of(mechanisms: Collection[str]) -> dict[str, float]:
    """Prior probabilities of nothing, of unknown and of each mechanism, all of which are alike; they sum to 1."""
    missing, unknown = 1 - constants.PRIOR_NOTHING, constants.PRIOR_UNKNOWN if mechanisms else 1.0
    shared = {name: missing * (1 - unknown) / len(mechanisms) for name in mechanisms}
    return {**shared, NOTHING: 1 - missing, UNKNOWN: missing * unknown}


def over_errors(evidences: Evidences) -> dict[str, float]:
    """Probabilities averaged over the errors of the evidences: hypotheses a few nats apart are nearly tied.

    Each source draws errors of its own, the same in whatever order they come. What a model with some law predicts is
    wrong alike for all hypotheses that it speaks for: that this law is missing, and that something like it is.
    """
    sources = {source for parts in evidences.values() for source in parts}
    errors = {source: constants.EVIDENCE_ERROR * _draws_of(source) for source in sources}
    each = [logsumexp([log + errors[s] for s, log in parts.items()], axis=0) for parts in evidences.values()]
    told = np.exp(each - logsumexp(each, axis=0)).mean(axis=1)
    return dict(zip(evidences, told.tolist(), strict=True))


@cache
def _draws_of(source: str) -> FloatArray:
    """Standard normal numbers, shape (DRAWS,), the same whenever a source is asked for."""
    return np.random.default_rng(crc32(source.encode())).normal(size=DRAWS)


def mixed_with_prior(chances: Mapping[str, float], prior: Mapping[str, float], misled: float) -> dict[str, float]:
    """Probabilities as they are told: no evidence is surer than the laws that it was found with.

    In some sensors all laws of the right mechanism are so far from its own that another does better, however long
    the recording; what was believed before is all that is left then.

    Parameters
    ----------
    chances : mapping
        After the data, as `over_errors` gives them.
    prior : mapping
        May have mechanisms that were not weighed, for they are in the model already.
    misled : float
        Probability that this is such a sensor.
    """
    return {name: (1 - misled) * chances.get(name, 0.0) + misled * one for name, one in prior.items()}
