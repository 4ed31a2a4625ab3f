"""A recording made ready for comparison: a uniform grid, force and log-conductance, and which samples count."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from gcode.support.errors import UserError
from testbench.knit.cache import SimulationCache
from testbench.knit.effect import FloatArray
from testbench.knit.filters import log_conductance
from testbench.knit.model import KnitModel, inputs
from testbench.measurements.motion import TURN, reading_noise, without_reading_noise, without_small_turns
from testbench.measurements.noise_level import even_step, noise_floor
from testbench.measurements.responses import CONDUCTANCE_CHANNEL, FORCE_CHANNEL, SIGNAL_OF
from testbench.recordings.channels import FORCE, RESISTANCE, TEMPERATURE
from testbench.recordings.recording import Recording

MAX_GRID_HZ = 25.0
BURN_IN_S = 3.0
BURN_IN_WAY = 0.01  # of all the way that the strain goes: a ramp before a long hold is no burn-in
MOST_READINGS = 600_000  # 4 h at 40 Hz, 8 h at 20 Hz: what is longer need not be seen so finely
MIN_SAMPLES, MIN_DURATION_S, MIN_STRAIN_RANGE = 200, 20.0, 2e-3
MOST_PLAY = 0.1  # of the gauge length: more is another set-up
MIN_PART = 170  # samples that count in each part; the evidence is weighed in 40 blocks of every fourth sample


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
    averaged : float
        Samples whose mean is as noisy as a grid point.
    clamp_play_mm : float
        Where the sensor was clamped anew for this recording: by how much the zero of its displacement may lie
        elsewhere (standard deviation). 0: it was not.
    begins_s : tuple of float
        Where several recordings stand in a row (`joining.joined`): grid times at which they begin, but the first.
    """

    signals: Mapping[str, FloatArray]
    dt_s: float
    measured: Mapping[str, FloatArray]
    counts: np.ndarray
    recording: Recording
    strain_noise: FloatArray
    start_s: float = 0.0
    averaged: float = 1.0
    clamp_play_mm: float = 0.0
    begins_s: tuple[float, ...] = ()

    @property
    def seen(self) -> slice:
        """Its part of the recording, with the burn-in: in a ramp and hold nearly all of the motion lies there."""
        return slice(0, int(np.flatnonzero(self.counts)[-1]) + 1)

    @property
    def grid_s(self) -> FloatArray:
        """Times of the grid points after the recording's first sample, shape (n,)."""
        return self.signals["time_s"] + self.start_s

    @property
    def channels(self) -> tuple[str, ...]:
        """The measured channels, force first."""
        return tuple(self.measured)

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


def prepare(
    recording: Recording, span: tuple[float, float] | None = None, rate_hz: float | None = None
) -> Measurement:
    """Average a recording onto a uniform grid.

    Bins are averaged in every channel alike, which lowers the noise without shifting force against strain;
    where samples are rarer than the grid, neighbours are interpolated: the grid then starts at the first sample, so
    that samples at even times, and the turns among them, are kept as they are.

    Parameters
    ----------
    recording : Recording
    span : (start_s, end_s), optional
        Only samples in this span count; the history before it is simulated all the same.
    rate_hz : float, optional
        Grid rate; default the recording's own, at most `MAX_GRID_HZ`.

    Notes
    -----
    Of a recording of more than `MOST_READINGS`, every second, third, ... sample enters.

    Raises
    ------
    UserError
        If the recording is too short or too still, or a channel is constant: nothing can be learnt from it.
    """
    _check_usable(recording)
    recording = recording.thinned(-(-len(recording) // MOST_READINGS))
    time_s = recording.time_s - recording.time_s[0]
    rate_hz = rate_hz or min(MAX_GRID_HZ, _usual_rate_hz(time_s))
    binned = _Bins(time_s, rate_hz)
    grid_s = binned.grid_s
    measured = {}
    if recording.has(FORCE):
        measured[FORCE_CHANNEL] = binned(recording[FORCE])
    if recording.has(RESISTANCE):
        measured[CONDUCTANCE_CHANNEL] = binned(-np.log(recording[RESISTANCE]))
    temperature = binned(recording[TEMPERATURE]) if recording.has(TEMPERATURE) else None
    start_s, end_s = span or (0.0, np.inf)
    settled_s = _burn_in_s(time_s, recording.strain)
    counts = (grid_s >= max(start_s, settled_s)) & (grid_s < end_s) & binned.is_read
    # Times far apart, as in a hold of hours, tell little of the noise between them: the lower estimate is meant.
    read = min(reading_noise(time_s, recording.strain), noise_floor(recording.strain))
    noise = max(read, even_step(recording.strain) / 12**0.5) / np.sqrt(binned.averaged)
    strain, left = without_reading_noise(binned(recording.strain), noise)
    signals = inputs(grid_s, without_small_turns(strain, noise), temperature)
    return Measurement(signals, 1.0 / rate_hz, measured, counts, recording, left, float(grid_s[0]), binned.averaged)


def _burn_in_s(time_s: FloatArray, strain: FloatArray) -> float:
    """Time from the start in which a model need not be right yet: it does not know what was before."""
    way = np.cumsum(np.abs(np.diff(strain)))
    return min(BURN_IN_S, float(time_s[1:][way >= BURN_IN_WAY * way[-1]][0]))


def _usual_rate_hz(time_s: FloatArray) -> float:
    """The mean rate, or that of the quicker part where the sampling was slowed down on purpose (in long holds)."""
    mean_s, quick_s = float(time_s[-1]) / (len(time_s) - 1), float(np.quantile(np.diff(time_s), 0.25))
    finest_s = max(quick_s, float(time_s[-1]) / MOST_READINGS)
    return 1 / finest_s if mean_s > 2 * quick_s else 1 / mean_s


class _Bins:
    """Means of the samples around each grid point, moved from their mean time to the grid point."""

    def __init__(self, time_s: FloatArray, rate_hz: float) -> None:
        self._time_s = time_s
        # A sample on the last edge, but for rounding, has a bin of its own.
        count = int(time_s[-1] * rate_hz + 1e-6)
        self._bin = np.minimum((time_s * rate_hz).astype(np.int64), count - 1)
        self._filled = np.bincount(self._bin, minlength=count)
        # Averages are only worth it where nearly every bin has a sample of its own.
        self._average = bool(np.mean(self._filled == 0) < 0.2 and len(time_s) > 1.5 * count)
        self.grid_s = (np.arange(count) + (0.5 if self._average else 0.0)) / rate_hz
        self._off_s = self._means(time_s) - self.grid_s if self._average else np.zeros(count)

    @property
    def is_read(self) -> np.ndarray:
        """Whether a sample lies within a step of each grid point: what was interpolated over a gap is no reading."""
        after = np.searchsorted(self._time_s, self.grid_s).clip(1, len(self._time_s) - 1)
        off_s = np.abs(self._time_s[[after - 1, after]] - self.grid_s).min(axis=0)
        return np.asarray(off_s <= self.grid_s[1] - self.grid_s[0])

    @property
    def averaged(self) -> float:
        """Samples whose mean is as noisy as a grid point: the harmonic mean over the bins."""
        return 1 / float(np.mean(1 / np.maximum(self._filled, 1))) if self._average else 1.0

    def __call__(self, values: FloatArray) -> FloatArray:
        if not self._average:
            return np.interp(self.grid_s, self._time_s, values)
        means = self._means(values)
        return means - self._off_s * np.gradient(means, self.grid_s)

    def _means(self, values: FloatArray) -> FloatArray:
        sums = np.bincount(self._bin, weights=values, minlength=len(self.grid_s))
        gaps = np.interp(self.grid_s, self._time_s, values)
        return np.where(self._filled > 0, sums / np.maximum(self._filled, 1), gaps)


def coarser(measurement: Measurement, rate_hz: float, most_points: float = np.inf) -> Measurement:
    """The same measurement at every so many grid points: fits on it cost less and say the same.

    The rate is at least `rate_hz`, unless that would be more than `most_points`.
    Points are left out, not averaged: where ln G bends sharply, the mean of ln G is not ln G at the mean strain. A
    turn of the strain stands for the points around it, which friction would not remember as it does the turn.
    """
    strain = measurement.signals["strain"]
    every = max(int(1.0 / (measurement.dt_s * rate_hz) + 1e-9), int(np.ceil(len(strain) / most_points)))
    if every < 2:
        return measurement
    kept = _turns_kept(strain, every, float(np.median(measurement.strain_noise)))
    return replace(
        measurement,
        signals={name: values[kept] for name, values in measurement.signals.items()},
        dt_s=measurement.dt_s * every,
        measured={name: values[kept] for name, values in measurement.measured.items()},
        counts=measurement.counts[kept],
        strain_noise=measurement.strain_noise[kept],
    )


def _turns_kept(strain: FloatArray, every: int, noise: float) -> np.ndarray:
    """One sample of each `every`: the middle one, or that at which the strain turns by more than its noise."""
    cells = strain[: len(strain) // every * every].reshape(-1, every)
    before, after = np.r_[cells[0, 0], cells[:-1, -1]], np.r_[cells[1:, 0], cells[-1, -1]]
    above = cells.max(1) - np.maximum(before, after)
    below = np.minimum(before, after) - cells.min(1)
    inside = np.where(above >= below, cells.argmax(1), cells.argmin(1))
    inside[np.maximum(above, below) <= TURN * noise] = every // 2
    inside[:1] = 0  # memories begin at rest there
    return np.arange(len(cells)) * every + inside


def _check_usable(recording: Recording) -> None:
    source = recording.source
    if len(recording) < MIN_SAMPLES or recording.duration_s < MIN_DURATION_S:
        raise UserError(
            f"{source}: too short to identify anything: {len(recording)} samples in {recording.duration_s:.1f} s, "
            f"at least {MIN_SAMPLES} in {MIN_DURATION_S:.0f} s are needed"
        )
    moved = float(np.ptp(recording.strain))
    if moved < MIN_STRAIN_RANGE:
        raise UserError(
            f"{source}: too still to identify anything: the strain moves by {moved:.2%} in all, "
            f"at least {MIN_STRAIN_RANGE:.1%} is needed; check the displacement column and the gauge length"
        )
    names = [name for name in (FORCE, RESISTANCE) if recording.has(name)]
    if not names:
        raise UserError(f"{source}: neither {FORCE} nor {RESISTANCE} was recorded; a comparison needs one of them")
    for name in names:
        if np.ptp(recording[name]) == 0:
            raise UserError(
                f"{source}: {name} is constant ({recording[name][0]:g}); check the wiring or leave it out"
            )


def _check_parts(calibration: Measurement, held: Measurement, cut_s: float) -> None:
    source = calibration.recording.source
    fewest = min(int(part.counts.sum()) for part in (calibration, held))
    if fewest < MIN_PART:
        raise UserError(
            f"{source}: too short to fit on one part and judge on the rest: {fewest} samples in the shorter part, "
            f"at least {MIN_PART} are needed; record longer, or give another recording with --held-out"
        )
    seen = calibration.signals["strain"][calibration.seen]
    if np.ptp(seen) < MIN_STRAIN_RANGE:
        raise UserError(
            f"{source}: too still to identify anything: the strain moves by {np.ptp(seen):.2%} in the first "
            f"{cut_s:.0f} s, on which the model is fitted; give a recording that moves, and this one as --held-out"
        )
    for channel, values in calibration.measured.items():
        if np.ptp(values[calibration.counts]) == 0:
            raise UserError(
                f"{source}: {channel} is constant in the first {cut_s:.0f} s, on which the model is fitted; "
                "check the wiring or leave it out"
            )


def sampled(measurement: Measurement, channel: str) -> tuple[FloatArray, FloatArray]:
    """Times from the recording's start and measured values of the samples that count, as recorded, never averaged."""
    recording = measurement.recording
    time_s = recording.time_s - recording.time_s[0]
    counting = measurement.grid_s[measurement.counts]
    rows = (time_s >= counting[0]) & (time_s <= counting[-1])
    values = recording[FORCE] if channel == FORCE_CHANNEL else -np.log(recording[RESISTANCE])
    return time_s[rows], values[rows]


def split(
    recording: Recording, held_out: Recording | None = None, held_share: float = 1 / 3, clamp_play_mm: float = 0.0
) -> tuple[Measurement, Measurement]:
    """Calibration and held-out measurements; without `held_out`, the last third of the recording.

    Parameters
    ----------
    recording, held_out : Recording
    held_share : float
    clamp_play_mm : float
        See `Measurement`; of the held-out recording.

    Raises
    ------
    UserError
        If the two were taken at different gauge lengths or share no channel, or one recording is too short or too
        still in a part of it; if there is play without a held-out recording, or more than a set-up has.
    """
    check_play(recording, clamp_play_mm)
    if clamp_play_mm and held_out is None:
        raise UserError(
            f"{recording.source}: clamp play is that of a held-out recording, and none was given; "
            "the last third of one recording was not clamped anew"
        )
    if held_out is None:
        cut_s = recording.duration_s * (1 - held_share)
        parts = prepare(recording, (0.0, cut_s)), prepare(recording, (cut_s, np.inf))
        _check_parts(*parts, cut_s)
        return ended(parts[0]), parts[1]
    check_gauge_length(held_out, recording)
    calibration = prepare(recording)
    held = prepare(held_out, rate_hz=1.0 / calibration.dt_s)
    if set(calibration.channels) != set(held.channels):
        raise UserError(
            f"{held_out.source}: measured {', '.join(held.channels)}, but {recording.source} measured "
            f"{', '.join(calibration.channels)}; both need the same channels"
        )
    return calibration, replace(held, clamp_play_mm=clamp_play_mm)


def ended(measurement: Measurement) -> Measurement:
    """The same up to the last sample that counts: nothing may be started from, or scaled by, what comes after."""
    last = int(np.flatnonzero(measurement.counts)[-1]) + 1
    return replace(
        measurement,
        signals={name: values[:last] for name, values in measurement.signals.items()},
        measured={name: values[:last] for name, values in measurement.measured.items()},
        counts=measurement.counts[:last],
        strain_noise=measurement.strain_noise[:last],
    )


def check_gauge_length(one: Recording, other: Recording) -> None:
    """Refuse two recordings that were not taken at the same gauge length.

    Raises
    ------
    UserError
    """
    if abs(one.gauge_length_mm - other.gauge_length_mm) > 1e-3 * other.gauge_length_mm:
        raise UserError(
            f"{one.source}: gauge length {one.gauge_length_mm:g} mm, but {other.source} has "
            f"{other.gauge_length_mm:g} mm; give recordings of the same set-up"
        )


def check_play(recording: Recording, clamp_play_mm: float) -> None:
    """Refuse a play that no clamp has.

    Raises
    ------
    UserError
    """
    most_mm = MOST_PLAY * recording.gauge_length_mm
    if not isinstance(clamp_play_mm, int | float) or not 0 <= clamp_play_mm <= most_mm:
        raise UserError(
            f"clamp play: must be from 0 to {most_mm:g} mm ({MOST_PLAY:.0%} of the gauge length), "
            f"got {clamp_play_mm!r}"
        )
