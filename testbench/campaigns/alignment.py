"""Delay and clock drift between a program's planned motion and the recorded displacement.

Two clocks took part: the machine's controller and the rig's microcontroller. They start apart and run apart:

    planned time = (1 + drift) * recorded time - delay

Correlation finds the delay roughly, window by window the drift, and least squares on the displacement itself both to
a fraction of a sample.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gcode.support.arrays import FloatArray
from gcode.support.errors import UserError
from testbench.recordings.channels import DISPLACEMENT
from testbench.recordings.recording import Recording
from testbench.rig.simulation.simulated import Motion

PLANNED = "displacement_planned_mm"
ALIGNED_HZ = 50.0
WINDOW_S, REACH_S = 30.0, 2.0  # length of a window; how far its lag may be from its neighbour's
TRUSTED_CORRELATION = 0.8
# Of the motion's standard deviation, the rms difference that may be left in any window: a correlation is blind to a
# wrong unit, and one of 0.99 is left where a machine stopped in mid-program.
MOST_DIFFERENCE = 0.3


@dataclass(frozen=True)
class Alignment:
    """How the recording's clock relates to the plan's.

    Attributes
    ----------
    delay_s : float
        Recorded time, on the plan's clock, at which the plan began (negative: the recorder came late).
    drift_ppm : float
        By how much the plan's clock runs faster than the recorder's.
    offset_mm : float
        Recorded displacement where the plan says zero.
    correlation : float
        Of planned and recorded displacement, once aligned.
    rms_mm : float
        Of their difference, once aligned.
    """

    delay_s: float
    drift_ppm: float
    offset_mm: float
    correlation: float
    rms_mm: float

    def planned_time_s(self, recorded_s: FloatArray) -> FloatArray:
        """Times of the recording on the plan's clock, in s."""
        return (1 + self.drift_ppm * 1e-6) * recorded_s - self.delay_s


def align(recording: Recording, motion: Motion) -> Alignment:
    """Find the delay and the drift.

    Raises
    ------
    UserError
        If the recorded displacement does not follow the planned motion.
    """
    recorded = recording.resampled(ALIGNED_HZ)
    time_s, seen_mm = recorded.time_s, recorded[DISPLACEMENT]
    step = np.arange(0, motion.duration_s, 1 / ALIGNED_HZ)
    planned_mm = np.interp(step, motion.time_s, motion.displacement_mm)
    if np.ptp(planned_mm) == 0 or np.ptp(seen_mm) == 0:
        raise UserError(
            f"{recording.source}: nothing moves in the plan or in the recording; there is nothing to align"
        )
    delay_s, drift = _coarse(time_s, seen_mm, planned_mm)
    found = _polished(recording, motion, delay_s, drift)
    _check_follows(recording, motion, found)
    return found


def _check_follows(recording: Recording, motion: Motion, found: Alignment) -> None:
    """Refuse an alignment of a displacement that is not the planned one."""
    planned_s = found.planned_time_s(recording.time_s)
    planned_mm = np.interp(planned_s, motion.time_s, motion.displacement_mm)
    starts_s, window = np.unique(recording.time_s // WINDOW_S * WINDOW_S, return_inverse=True)
    during = (planned_s >= 0) & (planned_s <= motion.duration_s)  # what the stage does before and after is no fault
    squares = np.where(during, recording[DISPLACEMENT] - found.offset_mm - planned_mm, 0.0) ** 2
    rms_mm = np.sqrt(np.bincount(window, squares) / np.bincount(window))
    worst = int(rms_mm.argmax())
    if found.correlation < TRUSTED_CORRELATION or rms_mm[worst] > MOST_DIFFERENCE * np.std(planned_mm):
        raise UserError(
            f"{recording.source}: the recorded displacement does not follow this program (correlation "
            f"{found.correlation:.2f}, difference {rms_mm[worst]:.3g} mm rms at best about {starts_s[worst]:.0f} s); "
            "is it the program that was run, was it run to its end without a stop, and is the displacement in mm?"
        )


def applied(recording: Recording, motion: Motion, alignment: Alignment) -> Recording:
    """The part of the recording during the plan, on the plan's clock, with the planned displacement beside it."""
    time_s = alignment.planned_time_s(recording.time_s)
    rows = (time_s >= 0) & (time_s <= motion.duration_s)
    channels = {name: values[rows] for name, values in recording.channels.items()}
    channels[PLANNED] = np.interp(time_s[rows], motion.time_s, motion.displacement_mm)
    return replace(recording, time_s=time_s[rows], channels=channels)


def _coarse(time_s: FloatArray, seen_mm: FloatArray, planned_mm: FloatArray) -> tuple[float, float]:
    """Delay and drift from correlations: of everything, then window by window."""
    lag, quality = best_lag(seen_mm, planned_mm)
    lags = _tracked(seen_mm, planned_mm, lag, quality)
    if len(lags) < 2:
        return lag / ALIGNED_HZ + time_s[0], 0.0
    centre_s, lag_s = (np.array(column) / ALIGNED_HZ for column in zip(*lags, strict=True))
    # The line through the windows' lags, by the median of its slopes: a window may have matched another cycle.
    i, j = np.triu_indices(len(lag_s), 1)
    slope = float(np.median((lag_s[j] - lag_s[i]) / (centre_s[j] - centre_s[i])))
    start_s = float(np.median(lag_s - slope * centre_s))
    # lag = recorded grid time - planned time: planned = (1 - slope) * grid time - start.
    return start_s + (1 - slope) * time_s[0], -slope


def best_lag(seen: FloatArray, planned: FloatArray) -> tuple[int, float]:
    """Samples by which `seen` lags behind `planned`, and the correlation where they overlap."""
    from scipy.signal import correlate, correlation_lags

    a, b = seen - seen.mean(), planned - planned.mean()
    sums = correlate(a, b, method="fft")
    lags = correlation_lags(len(a), len(b))
    lag = int(lags[np.argmax(sums)])
    return lag, _correlation_at(seen, planned, lag)


def _correlation_at(seen: FloatArray, planned: FloatArray, lag: int) -> float:
    start, end = max(0, lag), min(len(seen), len(planned) + lag)
    a, b = seen[start:end], planned[start - lag : end - lag]
    if len(a) < 3 or np.ptp(a) == 0 or np.ptp(b) == 0:
        return 0.0
    return float(np.corrcoef(a, b)[0, 1])


def _tracked(seen: FloatArray, planned: FloatArray, lag: int, quality: float) -> list[tuple[float, float]]:
    """(centre, lag) of windows, in samples: each searched near its neighbour's lag."""
    size, reach = int(WINDOW_S * ALIGNED_HZ), int(REACH_S * ALIGNED_HZ)
    starts = np.arange(0, len(seen) - size + 1, size)
    if not len(starts):
        return []
    liveliest = int(np.argmax([np.ptp(seen[start : start + size]) for start in starts]))
    if quality < TRUSTED_CORRELATION:
        # So much drift that the whole does not correlate: the liveliest window finds its place in the plan.
        first = int(starts[liveliest])
        lag = first - _place_in(planned, seen[first : first + size])
    found = []
    for direction in (starts[liveliest:], starts[:liveliest][::-1]):
        near = lag
        for start in direction:
            local = _window_lag(seen[start : start + size], planned, int(start), near, reach)
            if local is not None:
                near = round(local)
                found.append((start + size / 2, local))
    return found


def _place_in(planned: FloatArray, window: FloatArray) -> int:
    """Where in the plan a window correlates best, wherever it moves most; before and behind it the stage stands."""
    size = len(window)
    return int(np.argmax(_correlations(np.pad(planned, size, mode="edge"), window))) - size


def _correlations(planned: FloatArray, window: FloatArray) -> FloatArray:
    """Of a window with each part of a plan that is as long, times the window's norm; 0 where nothing moves."""
    from scipy.signal import correlate

    size = len(window)
    a, b = window - window.mean(), planned - planned.mean()
    sums = correlate(b, a, mode="valid", method="fft")
    total, squares = (np.concatenate([[0.0], np.cumsum(values)]) for values in (b, b**2))
    energy = squares[size:] - squares[:-size] - (total[size:] - total[:-size]) ** 2 / size
    least = 1e-9 * max(float(energy.max()), 1e-300)
    return np.where(energy > least, sums / np.sqrt(np.maximum(energy, least)), 0.0)


def _window_lag(window: FloatArray, planned: FloatArray, start: int, near: int, reach: int) -> float | None:
    """The lag of one window, within `reach` of `near`; None where nothing moves or the plan is not there."""
    first, last = start - near - reach, start - near + reach + len(window)
    if first < 0 or last > len(planned) or np.ptp(window) == 0:
        return None
    scores = _correlations(planned[first:last], window)
    best = int(np.argmax(scores))
    if not 0 < best < len(scores) - 1:
        return None
    before, top, after = scores[best - 1 : best + 2]
    bend = before - 2 * top + after
    fraction = 0.5 * (before - after) / bend if bend < 0 else 0.0
    return near + reach - (best + fraction)


def _polished(recording: Recording, motion: Motion, delay_s: float, drift: float) -> Alignment:
    from scipy.optimize import least_squares

    time_s, seen_mm = recording.time_s, recording[DISPLACEMENT]
    span_s = recording.duration_s

    def planned_mm(delay_s: float, drift: float) -> FloatArray:
        return np.interp((1 + drift) * time_s - delay_s, motion.time_s, motion.displacement_mm)

    def difference(x: FloatArray) -> FloatArray:
        return planned_mm(x[0], x[1] / span_s) + x[2] - seen_mm

    start = [delay_s, drift * span_s, float(np.median(seen_mm - planned_mm(delay_s, drift)))]
    best = least_squares(difference, start, loss="soft_l1", f_scale=0.05, diff_step=1e-4)
    delay_s, drift = float(best.x[0]), float(best.x[1] / span_s)
    aligned = planned_mm(delay_s, drift)
    correlation = float(np.corrcoef(aligned, seen_mm)[0, 1]) if np.ptp(aligned) > 0 else 0.0
    rms_mm = float(np.sqrt(np.mean((aligned + best.x[2] - seen_mm) ** 2)))
    return Alignment(delay_s, 1e6 * drift, float(best.x[2]), correlation, rms_mm)
