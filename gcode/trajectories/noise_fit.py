"""fit(): find a spec whose executed motion has given speed and acceleration statistics."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from gcode.motion.path import Frame
from gcode.support.errors import UserError
from gcode.support.read_only import Unchanging
from gcode.trajectories.natural import NAMES, Noise, Target, trial
from gcode.trajectories.planning import check_gauge_length, plan
from gcode.trajectories.trajectory import Limits, TrajectorySpec

SHAPES = ((2, 0.15), (2, 0.3), (1, 1.0), (3, 0.4))  # octaves, persistence; tried in turn
# Mean |a| times the stroke over the square of mean |v|: 6 to 40 for all shapes, paces, least speeds; and what comes
# within a quarter of that in both means.
BRISKNESS = (2.5, 90.0)
_SEEDS = 4
_TRIAL_S = 690.0
_NEAR = 0.03


@dataclass(frozen=True)
class FitResult(Unchanging):
    """The spec found, and what four other seeds give with it: mean and worst relative deviation of each statistic."""

    spec: TrajectorySpec
    mean: Mapping[str, float]
    worst: Mapping[str, float]

    @property
    def near(self) -> bool:
        """Whether every statistic came within 3 % on the mean over the seeds."""
        return max(abs(value) for value in self.mean.values()) <= _NEAR


def fit(
    target: Target,
    limits: Limits,
    *,
    gauge_length_mm: float = 25.0,
    low_percent: float = 0.0,
    high_percent: float = 30.0,
    on_shape: Callable[[str], None] = lambda note: None,
) -> FitResult:
    """Find a one-noise spec with the target's statistics.

    Bounded least squares over pace, range use, minimum speed and pace spread, for several octave shapes, on the mean
    over four seeds; the best is judged on four other seeds through the whole of `plan`.

    Parameters
    ----------
    target : Target
        Wanted statistics.
    limits : Limits
        Limits of the executed motion.
    gauge_length_mm, low_percent, high_percent : float
        They decide the stroke; the same speeds over a longer stroke mean fewer reversals.
    on_shape : callable
        Told about each octave shape when it is done.

    Raises
    ------
    UserError
        If the limits or the stroke exclude the target.
    """
    check_gauge_length(gauge_length_mm)
    if target.v_mean_mm_per_s >= limits.v_max_mm_per_s or target.a_mean_mm_per_s2 >= limits.a_max_mm_per_s2:
        raise UserError(
            f"limits: v max {limits.v_max_mm_per_s:g} mm/s and a max {limits.a_max_mm_per_s2:g} mm/s2 must be above "
            f"the wanted means, {target.v_mean_mm_per_s:g} mm/s and {target.a_mean_mm_per_s2:g} mm/s2"
        )
    base = Noise(duration_s=_TRIAL_S, low_percent=low_percent, high_percent=high_percent)
    frame = Frame(gauge_length_mm, 0.0, target.rate_hz, (0, 0), limits.v_max_mm_per_s, limits.a_max_mm_per_s2)
    base.model_copy(update={"target": target}).check_room(frame)
    _check_briskness(target, gauge_length_mm * (high_percent - low_percent) / 100.0)
    tried = []
    for octaves, persistence in SHAPES:
        shape = base.model_copy(update={"octaves": octaves, "persistence": persistence})
        tried.append(_fit_shape(shape, target, limits, gauge_length_mm))
        on_shape(f"{octaves} octave(s): {np.sqrt(tried[-1][1] / 2):.1%} away")
    noise = min(tried, key=lambda pair: pair[1])[0].model_copy(update={"duration_s": 1380.0, "target": target})
    spec = TrajectorySpec(
        name="fitted",
        pieces=(noise,),
        limits=limits,
        rate_hz=target.rate_hz,
        approach_mm_per_s=min(target.v_mean_mm_per_s, 0.9 * limits.v_max_mm_per_s),
    )
    try:
        return _judged(spec, target, gauge_length_mm)
    except UserError as error:
        raise UserError(f"fit: nothing that was tried comes near this target ({error}); ask for another") from None


def _check_briskness(target: Target, stroke_mm: float) -> None:
    """Refuse accelerations that no noise of such a mean speed has, before it is sought in vain for half a minute."""
    least, most = (share * target.v_mean_mm_per_s**2 / stroke_mm for share in BRISKNESS)
    if not least <= target.a_mean_mm_per_s2 <= most:
        raise UserError(
            f"fit: at a mean speed of {target.v_mean_mm_per_s:g} mm/s over {stroke_mm:.3g} mm the mean acceleration "
            f"must be {least:.3g} to {most:.3g} mm/s2, got {target.a_mean_mm_per_s2:g}; ask for another, or for "
            "another gauge length or strain range"
        )


def _judged(spec: TrajectorySpec, target: Target, gauge_length_mm: float) -> FitResult:
    runs = [plan(spec, 1000 + seed, gauge_length_mm).statistics() for seed in range(_SEEDS)]
    deviations = np.array([target.deviations(statistics) for statistics in runs])
    mean, worst = deviations.mean(axis=0), np.abs(deviations).max(axis=0)
    return FitResult(
        spec, dict(zip(NAMES, mean.tolist(), strict=True)), dict(zip(NAMES, worst.tolist(), strict=True))
    )


def _fit_shape(shape: Noise, target: Target, limits: Limits, gauge_length_mm: float) -> tuple[Noise, float]:
    """Best noise of one octave shape, and half its summed squared deviations."""
    from scipy.optimize import least_squares

    frames = [
        Frame(gauge_length_mm, 0.0, target.rate_hz, (seed, 0), limits.v_max_mm_per_s, 0.95 * limits.a_max_mm_per_s2)
        for seed in range(_SEEDS)
    ]

    def noise_of(free: np.ndarray) -> Noise:
        cells, peak, least = (float(f"{value:.4g}") for value in np.exp(free[:3]))
        return shape.model_copy(
            update={
                "cells_per_s": cells,
                "peak": peak,
                "min_speed_mm_per_s": least,
                "pace_spread": float(round(free[3], 3)),
            }
        )

    start, low, high = _search_box(shape, target, gauge_length_mm)
    best = least_squares(
        lambda free: np.mean([_deviations(noise_of(free), target, frame) for frame in frames], axis=0),
        start,
        bounds=(low, high),
        diff_step=0.02,
        max_nfev=8,
    )
    return noise_of(best.x), float(best.cost)


def _deviations(noise: Noise, target: Target, frame: Frame) -> np.ndarray:
    """Of a trial; noise that is far too slow to be executed is as far off as standing still."""
    try:
        return trial(noise, target, frame)
    except UserError:
        return np.full(len(NAMES), -1.0)


def _search_box(shape: Noise, target: Target, gauge_length_mm: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Start and bounds of log(cells_per_s), log(peak), log(min_speed), pace_spread."""
    stroke = gauge_length_mm * (shape.high_percent - shape.low_percent) / 100.0
    peak, slow = np.log(shape.level_at_end), np.log(0.2 * target.v_mean_mm_per_s)
    fastest = np.log(target.rate_hz / 2.0 ** (shape.octaves + 1))
    # One cell per second moves the axis by about 0.4 strokes per second.
    start = np.array([min(np.log(target.v_mean_mm_per_s / (0.4 * stroke)), fastest - 0.1), peak, slow, 0.2])
    low = np.array([start[0] - 4.0, peak + np.log(0.8), slow - 5.0, 0.0])
    high = np.array([min(start[0] + 4.0, fastest), peak + np.log(1.25), np.log(0.9 * target.v_mean_mm_per_s), 2.0])
    return start, low, high
