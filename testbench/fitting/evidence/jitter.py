"""Jitter of the age of readings: nobody knows it exactly, so a reading is the noisier the faster the motion."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from testbench.fitting import constants
from testbench.knit.effect import FloatArray
from testbench.knit.model import KnitModel
from testbench.measurements.measurement import Measurement
from testbench.measurements.noise_level import FEWEST, robust_sd, sixth_differences, within_range

JERK_S = 0.3  # a machine's jerks are quicker, strokes are slower
RIPPLE_POINTS = 200  # over the strain, of a ripple: some five for each of forty turns of a screw


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
    rough, of_motion = (sixth_differences(x, lag)[inside] for x in (left, modelled))
    parts = _slower_halves(np.argsort(speed))
    by_law = np.array([constants.LAW_ERROR * robust_sd(of_motion[part]) for part in parts])
    variance = np.maximum(np.array([robust_sd(rough[part]) for part in parts]) ** 2 - by_law**2, 0.0)
    square = np.array([np.median(speed[part] ** 2) for part in parts])
    if len(parts) < 2 or np.ptp(square) == 0 or np.ptp(variance) == 0:
        return 0.0
    # Readings rarer than the grid were interpolated: they show no noise, which must not make them certain.
    sure = np.sqrt([len(part) for part in parts]) / np.maximum(variance, 1e-6 * np.max(variance))
    return max(float(np.polyfit(square, variance, 1, w=sure)[0]), 0.0) ** 0.5


def _slower_halves(ordered: np.ndarray) -> list[np.ndarray]:
    """The slower half, the slower half of the rest, and so on: few samples are as fast as the fastest."""
    parts = []
    while len(ordered) >= 2 * FEWEST:
        half = len(ordered) // 2
        parts.append(ordered[:half])
        ordered = ordered[half:]
    return [*parts, ordered]
