"""A measurement made of a recording: on a uniform grid, with the motion behind the reading of the displacement."""

from __future__ import annotations

import numpy as np

from gcode.support.errors import UserError
from testbench.knit.effect import FloatArray
from testbench.knit.model import inputs
from testbench.measurements.bins import Bins
from testbench.measurements.measurement import Measurement
from testbench.measurements.motion import reading_noise, without_reading_noise, without_small_turns
from testbench.measurements.noise_level import even_step, noise_floor
from testbench.measurements.responses import CONDUCTANCE_CHANNEL, FORCE_CHANNEL
from testbench.recordings.channels import FORCE, RESISTANCE, TEMPERATURE
from testbench.recordings.recording import Recording

MAX_GRID_HZ = 25.0
BURN_IN_S = 3.0
BURN_IN_WAY = 0.01  # of all the way that the strain goes: a ramp before a long hold is no burn-in
MOST_READINGS = 600_000  # 4 h at 40 Hz, 8 h at 20 Hz: what is longer need not be seen so finely
MIN_SAMPLES, MIN_DURATION_S, MIN_STRAIN_RANGE = 200, 20.0, 2e-3


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
    binned = Bins(time_s, rate_hz)
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
    strain, left = without_small_turns(*without_reading_noise(binned(recording.strain), noise), noise)
    signals, averaged = inputs(grid_s, strain, temperature), (binned.averaged,)
    return Measurement(signals, 1.0 / rate_hz, measured, counts, recording, left, float(grid_s[0]), averaged)


def _burn_in_s(time_s: FloatArray, strain: FloatArray) -> float:
    """Time from the start in which a model need not be right yet: it does not know what was before."""
    way = np.cumsum(np.abs(np.diff(strain)))
    return min(BURN_IN_S, float(time_s[1:][way >= BURN_IN_WAY * way[-1]][0]))


def _usual_rate_hz(time_s: FloatArray) -> float:
    """The mean rate, or that of the quicker part where the sampling was slowed down on purpose (in long holds)."""
    mean_s, quick_s = float(time_s[-1]) / (len(time_s) - 1), float(np.quantile(np.diff(time_s), 0.25))
    finest_s = max(quick_s, float(time_s[-1]) / MOST_READINGS)
    return 1 / finest_s if mean_s > 2 * quick_s else 1 / mean_s


def _check_usable(recording: Recording) -> None:
    source = recording.source
    if len(recording) < MIN_SAMPLES or recording.duration_s < MIN_DURATION_S:
        raise UserError(
            f"{source}: too short to identify anything: {len(recording)} samples in "
            f"{np.floor(10 * recording.duration_s) / 10:g} s, "
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
