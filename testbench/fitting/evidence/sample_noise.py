"""The noise at each sample.

The error of sample i in channel c is e_i = sigma_c s_i z_i, where z_i has unit size. s_i follows the noise of the
reading at its level, the noise of the displacement times the slope of the model (effective variance, Orear, Am. J.
Phys. 50 (1982) 912), the jitter of the reading's age times its speed, and by how much a glitch jumps.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from statistics import harmonic_mean

import numpy as np
from scipy.ndimage import uniform_filter1d

from testbench.fitting import constants
from testbench.fitting.evidence.independent_samples import in_last_fit, news_of
from testbench.fitting.evidence.likelihood import Likelihood
from testbench.knit.effect import FloatArray
from testbench.knit.model import KnitModel
from testbench.measurements.measurement import Measurement, channel_of, sampled
from testbench.measurements.motion import reading_noise
from testbench.measurements.noise_level import (
    FEWEST,
    glitches,
    noise_floor,
    robust_sd,
    rounding,
    sd_of_steps,
    spread,
    within_range,
)

WAVE = 16  # grid points of a wave by which the strain may be off
LEVELS, MOST_NOISE = 10, 30.0  # levels whose noise is told apart; largest over typical noise
FINEST = 3e-6  # of the spread of a reading: 20 bits free of noise, the best of converters; simulations may have none


def noise_of(measurement: Measurement) -> dict[str, float]:
    """Standard deviation of the white noise at a usual grid point, per channel: force in N, conductance in ln S.

    At each point it is less by `Measurement.quieter`.
    """
    found = {}
    for channel in measurement.channels:
        time_s, values = sampled(measurement, channel)
        inside = within_range(values)
        read = reading_noise(time_s[inside], values[inside])
        noise = max(min(noise_floor(values), read), rounding(values), FINEST * spread(values))
        found[channel] = max(noise / harmonic_mean(measurement.averaged) ** 0.5, 1e-12)
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
    share = min(in_last_fit(measurement, pieces) / len(rows), 1.0)
    modelled = measurement.modelled(model)
    moved = _moved_by_noise(model, measurement, modelled)
    weight, floor, is_read, quieter = {}, {}, measurement.is_read, measurement.quieter
    for channel, values in measurement.measured.items():
        speed = np.gradient(modelled[channel], measurement.signals["time_s"])[rows]
        by_level = _noise_by_level(values, is_read, rounding(sampled(measurement, channel)[1]), quieter)[rows]
        read = noise[channel] * np.clip(by_level / np.median(by_level), 0.3, MOST_NOISE) / quieter[rows]
        sd = np.hypot(read, moved[channel][rows])
        sd = np.hypot(sd, (jitter_s or {}).get(channel, 0.0) * speed)
        sd = np.hypot(sd, glitches(values, noise[channel] / quieter)[rows])
        floor[channel] = float(np.mean(sd**-2.0) ** -0.5)
        weight[channel] = floor[channel] / sd
    return Likelihood(measurement, rows, weight, floor, share, pieces=pieces)


def known_noise(measurement: Measurement, noise: Mapping[str, float]) -> Likelihood:
    """Every sample with the same noise, which is known."""
    rows = _thinned(measurement)
    share = min(news_of(measurement) / len(rows), 1.0)
    weight = {channel: np.ones(len(rows)) for channel in noise}
    return Likelihood(measurement, rows, weight, noise, share, is_known=True)


def _thinned(measurement: Measurement) -> np.ndarray:
    """Samples that enter the normal equations, of those that count."""
    counting = np.flatnonzero(measurement.counts)
    if len(counting) <= constants.SAMPLES:
        return counting
    return counting[np.linspace(0, len(counting) - 1, constants.SAMPLES).astype(int)]


def _moved_by_noise(
    model: KnitModel, measurement: Measurement, modelled: Mapping[str, FloatArray]
) -> dict[str, FloatArray]:
    """Standard deviation of each channel from the noise that is left in the strain, shape (n,).

    The model is moved by two waves of that size, a quarter of a period apart, and not by one shift: friction sticks
    where the strain has just turned, and is steeper there than the curve that it slips along.
    """
    phase = 2 * np.pi * np.arange(len(measurement.strain_noise)) / WAVE
    moved = {c: np.zeros(len(phase)) for c in modelled}
    for wave in (np.cos(phase), np.sin(phase)):
        step = measurement.strain_noise * wave
        strains = {key: measurement.signals[key] + step for key in ("strain", "strain_nominal")}
        there = model.simulate({**measurement.signals, **strains}, measurement.dt_s)
        for c, here in modelled.items():
            moved[c] += (channel_of(there, c) - here) ** 2
    means = {c: uniform_filter1d(squares, WAVE) for c, squares in moved.items()}
    return {c: np.sqrt(np.maximum(mean, 0.0)) for c, mean in means.items()}  # its running sum rounds to less than 0


def _noise_by_level(
    values: FloatArray, is_read: np.ndarray, least: float, quieter: FloatArray | float = 1.0
) -> FloatArray:
    """Standard deviation of the noise at each level, as at a usual grid point, from second differences; shape (n,).

    Of three neighbours in the grid, all of which were read: a straight line over a gap has no noise. Where little
    moves, the readings of an instrument that rounds are all one, and yet no better than its rounding, `least`; where
    more moves, the median of the differences is a step (`sd_of_steps`).
    """
    usable = within_range(values) & is_read
    three = usable[:-2] & usable[1:-1] & usable[2:]
    if three.sum() < FEWEST:
        return np.ones(len(values))
    usual = np.broadcast_to(quieter, values.shape)[1:-1][three]
    second, middle = np.diff(values, 2)[three] / np.sqrt(6) * usual, values[1:-1][three]
    edges = np.quantile(middle, np.linspace(0, 1, LEVELS + 1))
    at, sd = [], []
    for low, high in pairwise(edges):
        inside = (middle >= low) & (middle <= high)
        if inside.sum() >= FEWEST:
            at.append(float(np.median(middle[inside])))
            sd.append(sd_of_steps(second[inside], least / np.sqrt(6)))
    overall = max(robust_sd(second), least, 1e-12)
    return np.interp(values, at, np.maximum(sd, max(0.2 * overall, least))) if at else np.full(len(values), overall)
