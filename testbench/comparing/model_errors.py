"""Errors of a model at the samples as recorded, in N and in ln S, beside the noise floor."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from testbench.comparing.numbers import over_noise
from testbench.knit.model import KnitModel
from testbench.measurements.measurement import Measurement, sampled
from testbench.measurements.noise_level import noise_floor
from testbench.measurements.responses import CONDUCTANCE_CHANNEL, FORCE_CHANNEL


def rms_errors(model: KnitModel, measurement: Measurement, free_offset: bool = False) -> dict[str, float]:
    """RMS of measured minus modelled at every counting sample: force in N, conductance in ln S.

    Parameters
    ----------
    free_offset : bool
        Take each channel's mean residual out first: another recording has another force zero and another
        conductance gain (a re-clamped sensor), which no effect should be blamed for.
    """
    modelled = measurement.modelled(model)
    errors = {}
    for channel in measurement.channels:
        time_s, values = sampled(measurement, channel)
        residual = values - np.interp(time_s, measurement.grid_s, modelled[channel])
        if free_offset:
            residual = residual - residual.mean()
        errors[channel] = float(np.sqrt(np.mean(residual**2)))
    return errors


def log_error(model: KnitModel, measurement: Measurement, free_offset: bool = False) -> float:
    """ln of the errors of all channels, summed, to rank models whatever the units; arguments as in `rms_errors`."""
    return float(sum(np.log(error) for error in rms_errors(model, measurement, free_offset).values()))


def noise_floors(measurement: Measurement) -> dict[str, float]:
    """Estimated standard deviation of the sample noise, per channel: force in N, conductance in ln S."""
    return {channel: float(noise_floor(sampled(measurement, channel)[1])) for channel in measurement.channels}


def over_the_floors(errors: Mapping[str, float], floors: Mapping[str, float]) -> float:
    """Errors over the noise floors, averaged over the channels."""
    return sum(over_noise(errors[channel], floors[channel]) for channel in errors) / len(errors)


def channel_name(channel: str) -> str:
    """Words for a channel."""
    return {FORCE_CHANNEL: "force", CONDUCTANCE_CHANNEL: "conductance"}[channel]
