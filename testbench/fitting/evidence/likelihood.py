"""How the samples of a measurement count: the noise at each of them, and how many of them are independent."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from testbench.fitting import constants
from testbench.fitting.downhill import huber, huber_weight
from testbench.knit.effect import FloatArray
from testbench.knit.model import KnitModel
from testbench.measurements.measurement import Measurement
from testbench.measurements.noise_level import trimmed_rms


@dataclass(frozen=True, eq=False)
class Likelihood:
    """How the samples of one measurement count.

    Attributes
    ----------
    rows : ndarray of int, shape (k,)
        Samples that enter the normal equations.
    weight : mapping of channel to ndarray, shape (k,)
        Typical noise over the noise at this sample.
    floor : mapping of channel to float
        Standard deviation of the white noise at a typical sample.
    share : float
        Independent samples that each of them stands for.
    explained : mapping of channel to float, optional
        Standard deviation of what the best law explains.
    pieces : float
        Independent pieces of the measurement: those of one recording for each that it consists of.
    is_known : bool
        The noise is that of the floor, Gaussian; otherwise it is found from what a model leaves, and has tails.
    """

    measurement: Measurement
    rows: np.ndarray
    weight: Mapping[str, FloatArray]
    floor: Mapping[str, float]
    share: float
    explained: Mapping[str, float] = field(default_factory=dict)
    pieces: float = constants.INDEPENDENT
    is_known: bool = False

    @property
    def count(self) -> float:
        """Independent samples of each channel."""
        return len(self.rows) * self.share

    @property
    def least(self) -> dict[str, float]:
        """The least that a model can leave: half of the white noise, since that is an estimate."""
        return {channel: 0.5 * floor for channel, floor in self.floor.items()}

    @property
    def least_misfit(self) -> dict[str, float]:
        """The least that a law is expected to leave, standard deviation."""
        return {channel: constants.LEAST_MISFIT * floor for channel, floor in self.floor.items()}

    @property
    def misfit(self) -> dict[str, float]:
        """What a law is expected to leave, standard deviation: no law is the sensor's own, and instruments drift."""
        inexact = {channel: constants.INEXACT * self.explained.get(channel, 0.0) for channel in self.floor}
        return {c: float(np.hypot(least, inexact[c])) for c, least in self.least_misfit.items()}

    def expected(self, explained: Mapping[str, float], whole: Mapping[str, float] | None = None) -> dict[str, float]:
        """What a complete model leaves where laws that explain so much err as usual; all are standard deviations.

        A law errs by `LAW_ERROR` of what it explains, and by `INEXACT` of all that it changes: the base, which could
        have done most of that, does not know where the law is wrong.
        """
        found = {}
        for c, least in self.least_misfit.items():
            error = constants.LAW_ERROR * explained.get(c, 0.0)
            found[c] = float(np.linalg.norm((least, error, constants.INEXACT * (whole or {}).get(c, 0.0))))
        return found

    def log_odds_complete(
        self, sigma: Mapping[str, float], explained: Mapping[str, float], whole: Mapping[str, float] | None = None
    ) -> float:
        """Log density of what a model leaves, if nothing else is missing, over the same if anything is.

        A model that is complete leaves in each channel the misfit of its base and the error of its last law, each
        within a factor. What is missing changes some of the channels, every choice of them alike; in those every size
        of what is left is alike, up to `MOST_LEFT` times the least one.

        Parameters
        ----------
        sigma, explained, whole : mapping of channel to float
            Standard deviations of what the model leaves, of what its last law explains, and of all that it changes.
        """
        expected = self.expected(explained, whole)
        complete = np.array([self._log_complete(left, c, expected[c]) for c, left in sigma.items()])
        changed = -np.log(np.log(constants.MOST_LEFT))
        either = float(np.sum(np.logaddexp(complete, changed)))
        none = float(np.sum(complete))
        some = either + np.log(-np.expm1(none - either)) - np.log(2 ** len(complete) - 1)
        return float(none - some)

    def most_added(self, sigma: Mapping[str, float]) -> float:
        """Log evidence, in nats, that a law can add at most to a model that leaves so much: a bound.

        No law is asked to leave less than `misfit`. A coefficient that makes g nats of likelihood pays
        (1 + ln 2g) / 2 of them at least, however well its prior was chosen (the evidence of one Gaussian weight at
        its best scale; MacKay, Neural Computation 4 (1992) 415).
        """
        best = {c: min(left, self.misfit[c]) for c, left in sigma.items()}
        made = self.count * sum(float(np.log(left / best[c])) for c, left in sigma.items())
        paid = 0.5 * (1 + np.log(2 * made)) if made > 0.5 else made
        likelier = self.log_odds_complete(best, {}) - self.log_odds_complete(sigma, {})
        return float(made - paid + likelier)

    def _log_complete(self, left: float, channel: str, expected: float) -> float:
        """Log density of ln(what is left in a channel) where the model is complete."""
        share = 1 - (self.least_misfit[channel] / expected) ** 2  # of the error that is the law's
        spread = np.hypot((1 - share) * constants.NOISE_SPREAD, share * constants.LAW_SPREAD)
        over = np.log(max(left / expected, 1.0))
        return float(np.log(np.sqrt(2 / np.pi) / spread) - 0.5 * (over / spread) ** 2)

    @property
    def in_pieces(self) -> Likelihood:
        """The likelihood by which models are compared, none of which is quite true.

        A law errs for longer than a sample does, so a recording counts as `INDEPENDENT` pieces (a power posterior;
        Grunwald & van Ommen, Bayesian Anal. 12 (2017) 1069).
        """
        return replace(self, share=min(self.pieces / len(self.rows), self.share))

    def with_law_error(self, error: Mapping[str, float]) -> Likelihood:
        """The same with the error of a law added to the noise: equally at all samples, however quiet they are.

        Parameters
        ----------
        error : mapping of channel to float
            Standard deviation; see `law_error_of`.
        """
        weight, floor = {}, {}
        for channel, white in self.floor.items():
            noise = white / self.weight[channel]
            total = np.hypot(noise, error.get(channel, 0.0))
            weight[channel] = float(np.mean(total**-2.0) ** -0.5) / total
            floor[channel] = float(np.sqrt(np.mean((noise * weight[channel]) ** 2)))
        return replace(self, weight=weight, floor=floor)

    def sigma(self, found: Mapping[str, float]) -> dict[str, float]:
        """The noise where so much was found in what a model leaves, standard deviation of each channel."""
        return dict(self.floor if self.is_known else found)

    def loss(self, z: FloatArray) -> FloatArray:
        """Minus the log density of the noise, shape of `z`: what is left over its standard deviation, >= 0."""
        return 0.5 * z * z if self.is_known else huber(z)

    def robust(self, z: FloatArray) -> FloatArray:
        """Square roots of the weights with which squares have the slope of `loss`, shape of `z`."""
        return np.ones_like(z) if self.is_known else np.sqrt(huber_weight(z))

    def picked(self, values: FloatArray, channel: str) -> FloatArray:
        """The samples that enter, over their relative noise; along the last axis."""
        return values[..., self.rows] * self.weight[channel]


def law_error_of(model: KnitModel, likelihood: Likelihood) -> dict[str, float]:
    """Standard deviation of the error of a law that explains all that a model leaves above the noise."""
    found = {}
    for channel, left in likelihood.measurement.residual(model).items():
        noise = likelihood.floor[channel] / likelihood.weight[channel]
        above = trimmed_rms(left[likelihood.rows]) ** 2 - float(np.mean(noise**2))
        found[channel] = constants.LAW_ERROR * max(above, 0.0) ** 0.5
    return found
