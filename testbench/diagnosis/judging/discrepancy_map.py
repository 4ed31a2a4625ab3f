"""What no law of a model explains: a free-form map of its residual, over what the knit did and went through.

Source: Kennedy & O'Hagan, J. R. Statist. Soc. B 63 (2001) 425 (a model beside its discrepancy).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from testbench.comparing.freeform import features
from testbench.fitting.evidence.evidence import maximised, switched_on
from testbench.fitting.evidence.hypothesis import Hypothesis, tail
from testbench.fitting.evidence.likelihood import Likelihood
from testbench.knit.effect import FloatArray
from testbench.measurements.measurement import Measurement

SMALL = 10.0  # factor on the precision of each group from which the evidence looks for it: a map begins small


@dataclass(frozen=True)
class Map:
    """The map beside one fitted model.

    Attributes
    ----------
    log_z : float
        Log evidence of the model with the map, as models are compared.
    gains : dict of (channel, coordinate) to float
        Share of the residual's squares that the map explains by each group of coordinates.
    """

    log_z: float
    gains: dict[tuple[str, str], float]


def mapped(h: Hypothesis, likelihood: Likelihood) -> Map:
    """The map of what a model leaves; parameters of laws move along with it, also in the model without it."""
    names, groups, values = _features(likelihood.measurement)
    channels, base, own, sigma = list(h.columns), h.weighted, h.evidence.scale, h.evidence.sigma
    count, size = len(values), len(h.priors.mean)
    rows = {c: np.zeros((count * len(channels), len(likelihood.rows))) for c in channels}
    parts = {c: slice(place * count, (place + 1) * count) for place, c in enumerate(channels)}
    for c, part in parts.items():
        rows[c][part] = values[:, likelihood.rows] * (likelihood.weight[c] * h.robust[c])
    precision = np.repeat([sigma[c] ** -2.0 for c in channels], count)
    group = len(own) + np.concatenate([np.array(groups) + place * len(names) for place in range(len(channels))])
    plain = replace(h.pinned, least=likelihood.misfit)  # a closer fit earns a map nothing, either
    without = maximised(plain, scale=own, sigma=sigma)
    scale = np.r_[switched_on(own), np.full(len(names) * len(channels), SMALL)]
    bigger = plain.extended(base, rows, np.zeros(len(precision)), precision, group)
    found = maximised(bigger, scale=scale, sigma=sigma)
    gains, tails = {}, 0.0
    for c, part in parts.items():
        robust, amounts, mine = h.robust[c], found.coefficients[size:][part], rows[c][part]
        residual = base[c][0] - found.coefficients[:size] @ base[c][1:]
        bare = base[c][0] - without.coefficients @ base[c][1:]
        tails += tail((residual - amounts @ mine) / robust / found.sigma[c], robust, likelihood.share)
        tails -= tail(bare / robust / without.sigma[c], robust, likelihood.share)
        for g, name in enumerate(names):
            inside = np.flatnonzero(np.array(groups) == g)
            gains[c, name] = float(np.mean((amounts[inside] @ mine[inside]) ** 2) / np.mean(residual**2))
    return Map(h.log_z + found.value - without.value + tails, gains)


def log_z_with_map(hypothesis: Hypothesis, likelihood: Likelihood) -> float:
    """Log evidence of a model with its map or without, which are as likely as each other: no law is exact."""
    return float(np.logaddexp(mapped(hypothesis, likelihood).log_z, hypothesis.log_z) - np.log(2))


@lru_cache(maxsize=2)
def _features(measurement: Measurement) -> tuple[tuple[str, ...], tuple[int, ...], FloatArray]:
    """Names of the groups, the group of each feature, and the features, shape (m, n)."""
    found = features(measurement)
    numbers = tuple(g for g, rows in enumerate(found.values()) for _ in rows)
    return tuple(found), numbers, np.vstack(list(found.values()))
