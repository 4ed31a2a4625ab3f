"""How samples count: the noise at each of them, and how many of them are independent.

The error of sample i in channel c is e_i = sigma_c s_i z_i, where z_i has unit size. s_i follows the noise of the
reading at its level, the noise of the displacement times the slope of the model (effective variance, Orear, Am. J.
Phys. 50 (1982) 912), the jitter of the reading's age times its speed, and by how much a glitch jumps.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from testbench.fitting import constants
from testbench.knit.effect import FloatArray
from testbench.knit.model import KnitModel
from testbench.measurements.measurement import Measurement, channel_of, coarser, sampled
from testbench.measurements.motion import reading_noise
from testbench.measurements.noise_level import (
    FEWEST,
    glitches,
    noise_floor,
    robust_sd,
    rounding,
    spread,
    trimmed_rms,
    within_range,
)

LEVELS, MOST_NOISE = 10, 30.0  # levels whose noise is told apart; largest over typical noise
JERK_S = 0.3  # a machine's jerks are quicker, strokes are slower
RIPPLE_POINTS = 200  # over the strain, of a ripple: some five for each of forty turns of a screw
FINEST = 3e-6  # of the spread of a reading: 20 bits free of noise, the best of converters; simulations may have none
MOTION_STEP, HOLD_STEP = 1e-4, 0.02  # of the range of the strain in a step; of the time since the motion ended


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
    """

    measurement: Measurement
    rows: np.ndarray
    weight: Mapping[str, FloatArray]
    floor: Mapping[str, float]
    share: float
    explained: Mapping[str, float] = field(default_factory=dict)
    pieces: float = constants.INDEPENDENT

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

    def noise_log_prior(
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
        for channel, typical in self.floor.items():
            noise = typical / self.weight[channel]
            total = np.hypot(noise, error.get(channel, 0.0))
            weight[channel] = float(np.mean(total**-2.0) ** -0.5) / total
            floor[channel] = float(np.sqrt(np.mean((noise * weight[channel]) ** 2)))
        return replace(self, weight=weight, floor=floor)

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


def on_the_grid(measurement: Measurement, finer: int = 1) -> Measurement:
    """Thinned to the grid of the comparison, or to one of `finer` times as many points."""
    return coarser(measurement, constants.GRID_HZ, finer * constants.GRID_POINTS)


def telling(measurement: Measurement) -> Measurement:
    """Only samples that say something new count: in a hold they repeat each other, ever more so.

    All are kept while the knit moves; in a hold one after each `HOLD_STEP` of the time since the motion ended. A ramp
    of seconds before a hold of hours would weigh nothing otherwise.
    """
    strain, dt_s = measurement.signals["strain"], measurement.dt_s
    moving = np.abs(np.diff(strain, prepend=strain[:1])) > MOTION_STEP * max(float(np.ptp(strain)), 1e-9)
    index = np.arange(len(strain))
    still_s = (index - np.maximum.accumulate(np.where(moving, index, 0))) * dt_s
    passed = np.cumsum(dt_s / np.maximum(dt_s, HOLD_STEP * still_s))
    counting = np.flatnonzero(measurement.counts)
    new = np.diff(np.floor(passed[counting] + 1e-9), prepend=-1) > 0
    counts = np.zeros_like(measurement.counts)
    counts[counting[new]] = True
    return replace(measurement, counts=counts)


def independent_share(measurement: Measurement) -> float:
    """Independent samples per sample of the grid: a finer grid adds samples, not knowledge."""
    return min(measurement.dt_s / constants.ALIKE_S, 1.0)


def noise_of(measurement: Measurement) -> dict[str, float]:
    """Standard deviation of the white noise at a grid point, per channel: force in N, conductance in ln S."""
    found = {}
    for channel in measurement.channels:
        time_s, values = sampled(measurement, channel)
        inside = within_range(values)
        read = reading_noise(time_s[inside], values[inside])
        noise = max(min(noise_floor(values), read), rounding(values), FINEST * spread(values))
        found[channel] = max(noise / measurement.averaged**0.5, 1e-12)
    return found


def jitter_of(models: Sequence[KnitModel], measurement: Measurement) -> dict[str, float]:
    """Standard deviation of each reading's age in seconds: by how much noisier it is the faster it moves.

    Converters average and hold, and loops ask for them at any time: that shows from sample to sample. A machine moves
    in jerks that the displacement beside the readings does not show: that shows over `JERK_S`. The larger counts.

    What one model leaves may be an error of its own that is as quick. Jitter is what all models leave, and what the
    last of them would leave if it knew any ripple that is the same at the same strain (of the drive, say).
    """
    lags = {1, max(int(JERK_S / measurement.dt_s), 1)}
    left = [measurement.residual(model) for model in models]
    left.append({c: _without_ripple(values, measurement) for c, values in left[-1].items()})

    def jitter(values: FloatArray, channel: str) -> float:
        return max(_jitter(values, channel, measurement, lag) for lag in lags)

    return {c: min(jitter(one[c], c) for one in left) for c in measurement.channels}


def _without_ripple(left: FloatArray, measurement: Measurement) -> FloatArray:
    """What a model leaves, less its mean at each strain on the way out and on the way back, shape (n,)."""
    strain, rest = measurement.signals["strain"], left.copy()
    out = np.gradient(strain) >= 0
    for way in (np.flatnonzero(out), np.flatnonzero(~out)):
        ordered = way[np.argsort(strain[way])]
        parts = np.array_split(ordered, min(max(len(way) // FEWEST, 1), RIPPLE_POINTS))
        at, mean = (np.array([x[part].mean() for part in parts if len(part)]) for x in (strain, left))
        if len(at):
            rest[way] -= np.interp(strain[way], at, mean)
    return rest


def _jitter(left: FloatArray, channel: str, measurement: Measurement, lag: int) -> float:
    """Jitter of one channel in s, from sixth differences of what a model leaves, over samples that are `lag` apart.

    They show no motion, however wrong the model; what its laws may err by is taken off. Their variance grows with the
    square of the speed.
    """
    values = measurement.measured[channel]
    modelled = values - left
    inner = slice(3 * lag, len(values) - 3 * lag)
    inside = (measurement.counts & within_range(values))[inner]
    speed = np.abs(np.gradient(modelled, measurement.signals["time_s"]))[inner][inside]
    rough, of_motion = (_sixth_differences(x, lag)[inside] for x in (left, modelled))
    parts = _slower_halves(np.argsort(speed))
    by_law = np.array([constants.LAW_ERROR * robust_sd(of_motion[part]) for part in parts])
    variance = np.maximum(np.array([robust_sd(rough[part]) for part in parts]) ** 2 - by_law**2, 0.0)
    square = np.array([np.median(speed[part] ** 2) for part in parts])
    if len(parts) < 2 or np.ptp(square) == 0 or np.ptp(variance) == 0:
        return 0.0
    # Readings rarer than the grid were interpolated: they show no noise, which must not make them certain.
    sure = np.sqrt([len(part) for part in parts]) / np.maximum(variance, 1e-6 * np.max(variance))
    return max(float(np.polyfit(square, variance, 1, w=sure)[0]), 0.0) ** 0.5


def _sixth_differences(x: FloatArray, lag: int) -> FloatArray:
    """Over samples that are `lag` apart, shape (n - 6 lag,); white noise keeps its standard deviation."""
    for _ in range(6):
        x = x[lag:] - x[:-lag]
    return x / np.sqrt(924)  # the squares of the weights, summed


def _slower_halves(ordered: np.ndarray) -> list[np.ndarray]:
    """The slower half, the slower half of the rest, and so on: few samples are as fast as the fastest."""
    parts = []
    while len(ordered) >= 2 * FEWEST:
        half = len(ordered) // 2
        parts.append(ordered[:half])
        ordered = ordered[half:]
    return [*parts, ordered]


def likelihood_of(
    model: KnitModel,
    measurement: Measurement,
    noise: Mapping[str, float],
    jitter_s: Mapping[str, float] | None = None,
    pieces: float = constants.INDEPENDENT,
) -> Likelihood:
    """Samples and their relative noise, taken as independent.

    Parameters
    ----------
    noise, jitter_s : mapping of channel to float
        See `noise_of` and `jitter_of`; without the latter there is no jitter.
    pieces : float
        See `Likelihood`; several recordings have each their own share of a last fit, too.
    """
    rows = _thinned(measurement)
    most = constants.IN_LAST_FIT * pieces / constants.INDEPENDENT
    news = min(int(measurement.counts.sum()) * independent_share(measurement), most)
    share = min(news / len(rows), 1.0)
    modelled = measurement.modelled(model)
    slope = _slopes(model, measurement, modelled)
    weight, floor = {}, {}
    for channel, values in measurement.measured.items():
        speed = np.gradient(modelled[channel], measurement.signals["time_s"])[rows]
        by_level = _noise_by_level(values)[rows]
        read = noise[channel] * np.clip(by_level / np.median(by_level), 0.3, MOST_NOISE)
        sd = np.hypot(read, (slope[channel] * measurement.strain_noise)[rows])
        sd = np.hypot(sd, (jitter_s or {}).get(channel, 0.0) * speed)
        sd = np.hypot(sd, glitches(values, noise[channel])[rows])
        floor[channel] = float(np.mean(sd**-2.0) ** -0.5)
        weight[channel] = floor[channel] / sd
    return Likelihood(measurement, rows, weight, floor, share, pieces=pieces)


def known_noise(measurement: Measurement, noise: Mapping[str, float]) -> Likelihood:
    """Every sample with the same noise, which is known."""
    rows = _thinned(measurement)
    share = independent_share(measurement) * int(measurement.counts.sum()) / len(rows)
    weight = {channel: np.ones(len(rows)) for channel in noise}
    return Likelihood(measurement, rows, weight, noise, min(share, 1.0))


def _thinned(measurement: Measurement) -> np.ndarray:
    """Samples that enter the normal equations, of those that count."""
    counting = np.flatnonzero(measurement.counts)
    if len(counting) <= constants.SAMPLES:
        return counting
    return counting[np.linspace(0, len(counting) - 1, constants.SAMPLES).astype(int)]


def _slopes(model: KnitModel, measurement: Measurement, modelled: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
    """Change of each channel with the strain, shape (n,)."""
    step = 1e-4 * max(float(np.ptp(measurement.signals["strain"])), 1e-6)
    moved = {**measurement.signals, **{key: measurement.signals[key] + step for key in ("strain", "strain_nominal")}}
    there = model.simulate(moved, measurement.dt_s)
    return {c: (channel_of(there, c) - here) / step for c, here in modelled.items()}


def _noise_by_level(values: FloatArray) -> FloatArray:
    """Standard deviation of the noise at each sample, from second differences among samples of its level."""
    seen = values[within_range(values)]
    second, middle = np.diff(seen, 2) / np.sqrt(6), seen[1:-1]
    edges = np.quantile(middle, np.linspace(0, 1, LEVELS + 1))
    at, sd = [], []
    for low, high in pairwise(edges):
        inside = (middle >= low) & (middle <= high)
        if inside.sum() >= 50:
            at.append(float(np.median(middle[inside])))
            sd.append(robust_sd(second[inside]))
    overall = max(robust_sd(second), 1e-12)
    return np.interp(values, at, np.maximum(sd, 0.2 * overall)) if at else np.full(len(values), overall)
