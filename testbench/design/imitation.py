"""How closely one model can imitate another on a motion, when its parameters are let go."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from testbench.fitting import constants
from testbench.fitting.evidence.independent_samples import news_of
from testbench.fitting.evidence.laplace import fitted
from testbench.fitting.evidence.likelihood import Likelihood
from testbench.fitting.evidence.sample_noise import known_noise
from testbench.knit.effect import FloatArray
from testbench.knit.model import KnitModel
from testbench.measurements.measurement import Measurement

# A search that begins anew where another ended leaves valleys in which one alone would stay.
SEARCHES, ENOUGH = 4, 0.9  # at most; share of what was left before, above which the next is the last

Noise = Mapping[str, float]  # what a fit leaves anyway, by channel


@dataclass(frozen=True)
class Rival:
    """One hypothesis: a fitted model under a short name."""

    name: str
    model: KnitModel


@dataclass(frozen=True)
class Imitation:
    """What remains of one rival when another has imitated it.

    Attributes
    ----------
    truth, imitator : str
        Names of the rivals.
    left : dict of channel to ndarray, shape (n,)
        Truth minus imitation over the noise floor, at the samples that count, means taken out: force zero and
        conductance gain belong to each mounting.
    independent_share : float
        Independent samples per sample of `left`, of a recording as many as the diagnosis compares models by.
    """

    truth: str
    imitator: str
    left: Mapping[str, FloatArray]
    independent_share: float

    @property
    def noise_units(self) -> float:
        """RMS of what remains over the noise floor, in the channel where it is largest."""
        return max(float(np.sqrt(np.mean(values**2))) for values in self.left.values())

    @property
    def log_odds(self) -> float:
        """Log-likelihood ratio for the truth that a diagnosis is expected to find."""
        return 0.5 * self.independent_share * sum(float(np.sum(values**2)) for values in self.left.values())

    @property
    def channel(self) -> str:
        """The channel that shows it best."""
        return max(self.left, key=lambda one: float(np.sum(self.left[one] ** 2)))


def imitate(truth: Rival, imitator: Rival, measurement: Measurement, noise: Noise) -> Imitation:
    """Move the parameters of the imitator until it comes as near to the truth as it can.

    A fit (`testbench.fitting.evidence.laplace`) to readings without any noise in them, which count as if they had it:
    what is left is the expected misfit of a wrong hypothesis.

    Parameters
    ----------
    truth, imitator : Rival
        The parameters of the imitator are believed near where each search begins, within wide limits.
    measurement : Measurement
        The motion, with the channels of `noise`.
    noise : mapping of channel to float
        Standard deviations.
    """
    modelled = measurement.modelled(truth.model)
    clean = replace(measurement, measured={channel: modelled[channel] for channel in noise})
    known = known_noise(clean, noise)
    # From far away the valleys of the noise that is known are narrow: the first searches take what is left for noise.
    found = _searched(truth, imitator, replace(known, is_known=False), noise)
    found += _searched(truth, found[-1][0], known, noise)
    return min((left for _, left in found), key=lambda left: left.log_odds)


def _searched(truth: Rival, imitator: Rival, likelihood: Likelihood, noise: Noise) -> list[tuple[Rival, Imitation]]:
    """Where each of a few searches has come to, each from the end of the one before, and what is left there."""
    clean, before, found = likelihood.measurement, np.inf, []
    share = news_of(clean, constants.INDEPENDENT) / clean.counts.sum()
    for _ in range(SEARCHES):
        imitator = replace(imitator, model=fitted(imitator.model, likelihood, imitator.model).model)
        left = {c: _counted(values, clean) / noise[c] for c, values in clean.residual(imitator.model).items()}
        found.append((imitator, Imitation(truth.name, imitator.name, left, share)))
        if found[-1][1].log_odds > ENOUGH * before:
            break
        before = found[-1][1].log_odds
    return found


def _counted(values: FloatArray, measurement: Measurement) -> FloatArray:
    picked = values[measurement.counts]
    return picked - picked.mean()
