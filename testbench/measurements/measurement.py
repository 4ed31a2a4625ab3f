"""A recording made ready for comparison: a uniform grid, force and log-conductance, and which samples count."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from statistics import harmonic_mean
from typing import Any

import numpy as np

from gcode.support.errors import UserError
from gcode.support.read_only import ReadOnly, read_only
from testbench.knit.cache import SimulationCache
from testbench.knit.effect import FloatArray
from testbench.knit.filters import log_conductance
from testbench.knit.model import KnitModel
from testbench.measurements.bins import read_at
from testbench.measurements.responses import CONDUCTANCE_CHANNEL, FORCE_CHANNEL, SIGNAL_OF
from testbench.recordings.channels import FORCE, RESISTANCE
from testbench.recordings.recording import Recording


@dataclass(frozen=True, eq=False)
class Measurement:
    """What a model is compared with.

    Attributes
    ----------
    signals : mapping of str to ndarray, each shape (n,)
        Inputs of a simulation on the uniform grid (`testbench.knit.model.inputs`).
    dt_s : float
        Grid step.
    measured : mapping of str to ndarray, each shape (n,)
        ``force`` in N and ``conductance`` as ln S, as far as they were recorded.
    counts : ndarray of bool, shape (n,)
        Samples that enter fits and errors: read, after the burn-in, and inside this part of the recording.
    recording : Recording
        Where it came from, as sampled.
    strain_noise : ndarray, shape (n,)
        Standard deviation of the noise that is left in the strain.
    start_s : float
        Time of the first grid point after the recording's first sample.
    averaged : tuple of float
        Samples whose mean is as noisy as a grid point, of each recording.
    clamp_play_mm : float
        Where the sensor was clamped anew for this recording: by how much the zero of its displacement may lie
        elsewhere (standard deviation). 0: it was not.
    begins_s : tuple of float
        Where several recordings stand in a row (`joining.joined`): grid times at which they begin, but the first.
    rest_s : float, optional
        Of the last of them alone (`joining.last_of`): the rest of its specimen before it. None: it was fresh.
    """

    signals: Mapping[str, FloatArray]
    dt_s: float
    measured: Mapping[str, FloatArray]
    counts: np.ndarray
    recording: Recording
    strain_noise: FloatArray
    start_s: float = 0.0
    averaged: tuple[float, ...] = (1.0,)
    clamp_play_mm: float = 0.0
    begins_s: tuple[float, ...] = ()
    rest_s: float | None = None

    def __post_init__(self) -> None:
        # Nobody changes a result in place; the arrays of the signals stay as they are: compiled loops take none else.
        object.__setattr__(self, "measured", read_only(self.measured))
        object.__setattr__(self, "signals", ReadOnly(self.signals))

    def __setstate__(self, state: dict[str, Any]) -> None:
        signals = {name: np.array(values) for name, values in state["signals"].items()}
        self.__dict__.update(state | {"signals": ReadOnly(signals)})

    @property
    def seen(self) -> slice:
        """Its part of the recording, with the burn-in: in a ramp and hold nearly all of the motion lies there."""
        return slice(0, int(np.flatnonzero(self.counts)[-1]) + 1)

    @property
    def grid_s(self) -> FloatArray:
        """Times of the grid points after the recording's first sample, shape (n,)."""
        return self.signals["time_s"] + self.start_s

    @property
    def begin_s(self) -> float:
        """Grid time at which the recording begins that holds the first sample that counts."""
        first_s = self.signals["time_s"][np.argmax(self.counts)]
        return max((begin_s for begin_s in self.begins_s if begin_s <= first_s), default=0.0)

    @property
    def is_read(self) -> np.ndarray:
        """Whether each grid point was read, and not interpolated over a gap, shape (n,)."""
        return read_at(self.grid_s, self.recording.time_s - self.recording.time_s[0], self.dt_s)

    @property
    def quieter(self) -> FloatArray:
        """Noise of a usual grid point over that of each, as far as more or fewer samples were averaged; shape (n,).

        It is 1 in one recording. Of several, each of its own rate, a usual one has the mean variance of all.
        """
        averaged = np.array(self.averaged) / harmonic_mean(self.averaged)
        return np.sqrt(averaged)[np.searchsorted(self.begins_s, self.signals["time_s"], side="right")]

    @property
    def channels(self) -> tuple[str, ...]:
        """The measured channels, force first."""
        return tuple(self.measured)

    def at(self, points: np.ndarray | slice) -> Measurement:
        """The same at some of its grid points alone."""
        return replace(
            self,
            signals={name: values[points] for name, values in self.signals.items()},
            measured={name: values[points] for name, values in self.measured.items()},
            counts=self.counts[points],
            strain_noise=self.strain_noise[points],
        )

    def modelled(self, model: KnitModel, cache: SimulationCache | None = None) -> dict[str, FloatArray]:
        """Simulate; force in N and ln G for every measured channel, each shape (n,).

        Raises
        ------
        UserError
            If the model has no law for a channel that was measured.
        """
        state = model.simulate(self.signals, self.dt_s, cache)
        for channel in self.channels:
            if SIGNAL_OF[channel] not in state:
                raise UserError(
                    f"{self.recording.source}: has a {channel}, and the model ({', '.join(model)}) simulates none; "
                    "fit a model on a recording with the same channels"
                )
        return {channel: channel_of(state, channel) for channel in self.channels}

    def residual(self, model: KnitModel, cache: SimulationCache | None = None) -> dict[str, FloatArray]:
        """Measured minus modelled, each shape (n,)."""
        modelled = self.modelled(model, cache)
        return {channel: self.measured[channel] - modelled[channel] for channel in self.channels}


def channel_of(state: Mapping[str, FloatArray], channel: str) -> FloatArray:
    """Force in N, or conductance as ln S, from simulated signals."""
    values = state[SIGNAL_OF[channel]]
    if channel == CONDUCTANCE_CHANNEL:
        return log_conductance(values)
    return values


def sampled(measurement: Measurement, channel: str) -> tuple[FloatArray, FloatArray]:
    """Times from the recording's start and measured values of the samples that count, as recorded, never averaged.

    Of each recording, where several stand in a row: all from the first of its grid points that count to the last.
    """
    recording = measurement.recording
    time_s = recording.time_s - recording.time_s[0]
    rows = np.zeros(len(time_s), bool)
    for counting in _counting_s(measurement):
        rows |= (time_s >= counting[0]) & (time_s <= counting[-1])
    values = recording[FORCE] if channel == FORCE_CHANNEL else -np.log(recording[RESISTANCE])
    return time_s[rows], values[rows]


def _counting_s(measurement: Measurement) -> list[FloatArray]:
    """Grid times that count, of each recording that has any."""
    counting = measurement.grid_s[measurement.counts]
    begins_s = np.array(measurement.begins_s) + measurement.start_s
    return [part for part in np.split(counting, np.searchsorted(counting, begins_s)) if len(part)]
