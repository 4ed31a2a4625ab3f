"""What no law of a model explains: a free-form map of its residual, over what the knit did and went through.

Source: Kennedy & O'Hagan, J. R. Statist. Soc. B 63 (2001) 425 (a model beside its discrepancy).
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from testbench.comparing.freeform import features
from testbench.diagnosis.evidence.evidence import maximised, opened
from testbench.diagnosis.evidence.hypothesis import Hypothesis, tail
from testbench.diagnosis.evidence.likelihood import Likelihood
from testbench.diagnosis.proposals import extended
from testbench.knit.effect import FloatArray
from testbench.measurements.measurement import Measurement


class Map:
    """The map beside one fitted model.

    Attributes
    ----------
    log_z : float
        Log evidence of the model with the map, as models are compared.
    gains : dict of (channel, coordinate) to float
        Share of the residual's squares that the map explains by each group of coordinates.
    left : dict of channel to ndarray, shape (k,)
        What model and map leave together, over its relative noise.
    """

    def __init__(self, hypothesis: Hypothesis, likelihood: Likelihood) -> None:
        names, groups, values = _features(likelihood.measurement)
        channels = list(hypothesis.columns)
        base = hypothesis.weighted
        picked = values[:, likelihood.rows]
        count, size = len(values), len(hypothesis.priors.mean)
        rows = {c: np.zeros((count * len(channels), len(likelihood.rows))) for c in channels}
        precision: list[float] = []
        group: list[int] = []
        first = len(hypothesis.evidence.scale)
        for place, c in enumerate(channels):
            part = slice(place * count, (place + 1) * count)
            rows[c][part] = picked * (likelihood.weight[c] * hypothesis.robust[c])
            precision += [hypothesis.evidence.sigma[c] ** -2.0] * count
            group += [first + place * len(names) + g for g in groups]
        own, sigma = hypothesis.evidence.scale, hypothesis.evidence.sigma
        # Parameters of laws move along with the map, so that it is told from what they would do without it.
        plain = replace(hypothesis.pinned, least=likelihood.misfit)  # a closer fit earns a map nothing, either
        without = maximised(plain, scale=own, sigma=sigma)
        normal = extended(plain, base, rows, [0.0] * len(precision), precision, group)
        scale = np.r_[opened(own), np.full(len(names) * len(channels), 10.0)]
        found = maximised(normal, scale=scale, sigma=sigma)
        self.left, self.gains, tails = {}, {}, 0.0
        for place, c in enumerate(channels):
            amounts = found.coefficients[size:]
            residual = base[c][0] - found.coefficients[:size] @ base[c][1:]
            self.left[c] = residual - amounts @ rows[c]
            robust = hypothesis.robust[c]
            tails += tail(self.left[c] / robust / found.sigma[c], robust, likelihood.share)
            bare = base[c][0] - without.coefficients @ base[c][1:]
            tails -= tail(bare / robust / without.sigma[c], robust, likelihood.share)
            for g, name in enumerate(names):
                inside = np.flatnonzero(np.asarray(groups) == g) + place * count
                self.gains[c, name] = float(np.mean((amounts[inside] @ rows[c][inside]) ** 2) / np.mean(residual**2))
        self.log_z = hypothesis.log_z + found.value - without.value + tails


def log_z_with_map(hypothesis: Hypothesis, likelihood: Likelihood) -> float:
    """Log evidence of a model with its map or without, which are as likely as each other: no law is exact."""
    return float(np.logaddexp(Map(hypothesis, likelihood).log_z, hypothesis.log_z) - np.log(2))


@lru_cache(maxsize=2)
def _features(measurement: Measurement) -> tuple[tuple[str, ...], tuple[int, ...], FloatArray]:
    """Names of the groups, the group of each feature, and the features, shape (m, n)."""
    found = features(measurement)
    numbers = tuple(g for g, rows in enumerate(found.values()) for _ in rows)
    return tuple(found), numbers, np.vstack(list(found.values()))
