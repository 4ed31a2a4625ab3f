"""The noise at each sample.

The error of sample i in channel c is e_i = sigma_c s_i z_i, where z_i has unit size. s_i follows the noise of the
reading at its level, the noise of the displacement times the slope of the model (effective variance, Orear, Am. J.
Phys. 50 (1982) 912), the jitter of the reading's age times its speed, and by how much a glitch jumps.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise

import numpy as np

from testbench.fitting import constants
from testbench.fitting.evidence.likelihood import Likelihood
from testbench.fitting.evidence.telling import independent_share
from testbench.knit.effect import FloatArray
from testbench.knit.kinematics.jumps import MAD_TO_SD
from testbench.knit.model import KnitModel
from testbench.measurements.measurement import Measurement, channel_of, sampled
from testbench.measurements.motion import reading_noise
from testbench.measurements.noise_level import (
    FEWEST,
    glitches,
    noise_floor,
    robust_sd,
    rounding,
    spread,
    within_range,
)

ONE_STEP = 1.01 * MAD_TO_SD * np.sqrt(12 / 6)  # the estimate from second differences of one step, over the rounding
LEVELS, MOST_NOISE = 10, 30.0  # levels whose noise is told apart; largest over typical noise
FINEST = 3e-6  # of the spread of a reading: 20 bits free of noise, the best of converters; simulations may have none


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
    weight, floor, is_read = {}, {}, measurement.is_read
    for channel, values in measurement.measured.items():
        speed = np.gradient(modelled[channel], measurement.signals["time_s"])[rows]
        by_level = _noise_by_level(values, is_read, rounding(sampled(measurement, channel)[1]))[rows]
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


def _noise_by_level(values: FloatArray, is_read: np.ndarray, least: float) -> FloatArray:
    """Standard deviation of the noise at each sample, from second differences among readings of its level.

    Of three neighbours in the grid, all of which were read: a straight line over a gap has no noise. Where little
    moves, the readings of an instrument that rounds are all one, and yet no better than its rounding, `least`; where
    more moves, half of the differences are one step, which says no more than that it rounds.
    """
    usable = within_range(values) & is_read
    three = usable[:-2] & usable[1:-1] & usable[2:]
    if three.sum() < FEWEST:
        return np.ones(len(values))
    second, middle = np.diff(values, 2)[three] / np.sqrt(6), values[1:-1][three]
    edges = np.quantile(middle, np.linspace(0, 1, LEVELS + 1))
    at, sd = [], []
    for low, high in pairwise(edges):
        inside = (middle >= low) & (middle <= high)
        if inside.sum() >= FEWEST:
            at.append(float(np.median(middle[inside])))
            sd.append(robust_sd(second[inside]))
    overall = max(robust_sd(second), least, 1e-12)
    told = np.where(np.array(sd) <= ONE_STEP * least, least, sd)
    return np.interp(values, at, np.maximum(told, 0.2 * overall)) if at else np.full(len(values), overall)
